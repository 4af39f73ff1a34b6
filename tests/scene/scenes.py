"""Two cables and bodies joined by random smooth constraints, and a dense oracle of the whole."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag

from exudyn_inext.cable.cable import CurvatureMeasure
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.scene.bodies import BodiesSystem, MassBlock, VariableBlocks
from exudyn_inext.scene.coupled_system import CoupledSystem, Part
from exudyn_inext.scene.joints import JointBlock, JointTerms
from tests.cables import (
    bending_force,
    damping_force,
    dense_constraints,
    dense_mass,
    linked_state,
    random_state,
    with_section,
)

TIME = 0.3


class QuadraticJoints:
    """c = G x + x^T H x / 2 + b(t) on chosen coordinates x of the whole: every term of Eq. (27) is met."""

    def __init__(self, rng, places, number, size):
        self.places, self.number, self.size = places, number, size
        self.linear = rng.standard_normal((number, len(places)))
        quadratic = 0.2 * rng.standard_normal((number, len(places), len(places)))
        self.quadratic = quadratic + quadratic.transpose(0, 2, 1)
        self.shift = np.zeros(number)

    def drive(self, t):
        return np.sin(t + np.arange(self.number)), np.cos(t + np.arange(self.number))

    def value(self, t, q):
        x = q[self.places]
        return self.linear @ x + 0.5 * x @ self.quadratic @ x + self.drive(t)[0] - self.shift

    def jacobian(self, q):
        rows = np.zeros((self.number, self.size))
        rows[:, self.places] = self.linear + self.quadratic @ q[self.places]
        return rows

    def drift(self, t):
        return self.drive(t)[1]

    def gamma(self, t, v):
        x = v[self.places]
        return -(x @ self.quadratic @ x) + self.drive(t)[0]


@dataclass
class GivenItems:
    """Forces and joints that do not come from Exudyn."""

    joints: list
    blocks: list
    rule: QuadraticJoints
    inputs: list

    def forces(self, t, q, v):
        return self.inputs

    def constrain(self, t, q, v):
        jacobian = self.rule.jacobian(q)
        for block in self.blocks:
            block.jacobian[:] = jacobian[block.rows, block.dofs]
        return JointTerms(self.rule.value(t, q), self.rule.drift(t), self.rule.gamma(t, v))

    def violations(self, t, q):
        return self.rule.value(t, q)

    def motions(self, t):
        return self.inputs


@dataclass
class Whole:
    """Everything, and its state."""

    cables: list
    masses: list
    system: CoupledSystem
    rule: QuadraticJoints
    inputs: list
    slices: list
    q: np.ndarray
    v: np.ndarray

    def cable_drifts(self, rows):
        """c_t of each cable's constraints."""
        return [r.rate - r.jacobian @ self.v[dofs] for r, dofs in zip(rows, self.slices, strict=False)]

    def dense(self, lead=0.0, acceleration=None):
        """M, F, and the terms of all constraints, cables' first, without the package's solves."""
        mass, force, rows = [], [], []
        for state, dofs in zip(self.cables, self.slices, strict=False):
            q, v = (x[dofs].reshape(state.q.shape) for x in (self.q, self.v))
            led = v if acceleration is None else v + lead * acceleration[dofs].reshape(state.q.shape)
            mass.append(dense_mass(state.cable))
            force.append(bending_force(state.cable, q) + damping_force(state.cable, q, led) + state.external)
            rows.append(dense_constraints(state.cable, q, v, state.time))
        mass += self.masses
        force.append(self.inputs[-1])
        jacobian = block_diag(*(r.jacobian for r in rows))
        jacobian = np.hstack([jacobian, np.zeros((len(jacobian), len(self.q) - jacobian.shape[1]))])
        terms = {
            "jacobian": np.vstack([jacobian, self.rule.jacobian(self.q)]),
            "value": np.concatenate([*(r.value for r in rows), self.rule.value(TIME, self.q)]),
            "gamma": np.concatenate([*(r.gamma for r in rows), self.rule.gamma(TIME, self.v)]),
            "drift": np.concatenate([*self.cable_drifts(rows), self.rule.drift(TIME)]),
        }
        terms["rate"] = terms["jacobian"] @ self.v + terms["drift"]
        return block_diag(*mass), np.concatenate([f.ravel() for f in force]), terms


def solve_dense(mass, jacobian, force, target):
    """x and multipliers of [M C^T; C 0]; redundant rows (of closed cables) by least squares."""
    size, rows = len(mass), len(jacobian)
    matrix = np.block([[mass, jacobian.T], [jacobian, np.zeros((rows, rows))]])
    solution = np.linalg.lstsq(matrix, np.concatenate([force, target]), rcond=1e-12)[0]
    return solution[:size], solution[size:]


def whole(seed, dim, joints=3, zeta=5.0, damped=False, linked=False):
    """Two cables of 3 and 4 elements, a constant and a variable mass block, and `joints` rows."""
    rng = np.random.default_rng(seed)
    measure = CurvatureMeasure.SECOND_DERIVATIVE
    states = [
        random_state(seed, 3, dim, measure, supports="pinned"),
        linked_state(seed, 4, dim, measure, "hanger") if linked else random_state(seed + 1, 4, dim, measure),
    ]
    if damped:
        states[0] = with_section(states[0], bending_damping=0.3)
    states = [replace(state, time=TIME) for state in states]
    roots = [rng.standard_normal((k, k)) for k in (2, 3)]
    masses = [root @ root.T + np.eye(len(root)) for root in roots]
    bodies = BodiesSystem(
        5,
        [MassBlock(np.array([0, 1]), masses[0])],
        [VariableBlocks(np.array([[2, 3, 4]]), np.array([-1]), np.zeros((1, 4)))],
    )
    bodies.set_masses(0, masses[1][None].copy(), np.zeros(5))
    systems = [*(cable_system(state.cable, zeta) for state in states), bodies]
    ends = np.cumsum([0, *(state.q.size for state in states), 5])
    slices = [slice(a, b) for a, b in pairwise(ends)]
    free = [np.flatnonzero(~np.repeat(s.cable.fixed[:, :, None], dim, axis=2)) for s in states]
    places = [slices[0].start + free[0][-3:], slices[1].start + free[1][:3], slices[2].start + np.arange(5)]
    q = np.concatenate([*(s.q.ravel() for s in states), rng.standard_normal(5)])
    v = np.concatenate([*(s.v.ravel() for s in states), rng.standard_normal(5)])
    rule = QuadraticJoints(rng, np.concatenate(places), joints, len(q))
    rule.shift = rule.value(TIME, q) - 0.01 * rng.standard_normal(joints)
    inputs = [*(state.inputs for state in states), rng.standard_normal(5)]
    parts = [Part(system, dofs) for system, dofs in zip(systems, slices, strict=True)]
    blocks = [JointBlock(part.system, part.dofs, np.arange(joints)) for part in parts]
    names = [f"joint {k}" for k in range(joints)]
    system = CoupledSystem(parts, GivenItems(names, blocks, rule, inputs), zeta)
    return Whole(states, masses, system, rule, inputs, slices, q, v)
