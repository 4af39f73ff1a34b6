"""Cables, bodies and joints as one `system` of the integrators.

The parts are evaluated by the same protocols as alone; joints then correct what they give, see `joints`.
Runs in plain Python: forces come from outside, and each part is one call.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.linear_response import improve_damping, leave_to_joints
from ..called_system import Bound
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .joints import JointSolve, JointTerms


class Part(NamedTuple):
    """One part.   system: its equations.   dofs: its place in the coupled vectors.

    whole: the part that it is evaluated in, with others; None: alone.
    """

    system: Any
    dofs: slice
    whole: "Part | None" = None


class _Resolved(NamedTuple):
    """What is evaluated at once, with the implementations of its protocols, found once."""

    dofs: slice
    rates: Callable[..., None]
    accelerate: Callable[..., None]
    correct: Callable[..., float]
    improve: Callable[..., None] | None


def _resolve(part: Part, has_joints: bool) -> _Resolved:
    protocols = index_reduced_rates, accelerate_and_project, correct_position
    rates, accelerate, correct = (Bound(protocol, part.system) for protocol in protocols)
    improves = has_joints and leave_to_joints(part.system)
    improve = Bound(improve_damping, part.system) if improves else None
    return _Resolved(part.dofs, rates, accelerate, correct, improve)


class CoupledSystem:
    """A `system` of the integrators; their external force is the time alone, (1,).

    native_items: what acts on the parts, and joins them, see `native.native_items.NativeItems`.
    zeta: stabilisation rate of the joints [1/s], as of the cables.
    multipliers: nu (m,) of the joints at the last evaluation: M a + C_q^T nu = F.
    terms: of the joints when they were evaluated last.
    parts: cables, bodies, first order states.   wholes: what of them is evaluated at once.
    states: place of the first order states.
    in_one: evaluates all of them, and the joints, if it is set: see `run.parts_in_one`.
    """

    in_one: Any = None
    states = slice(0, 0)

    def __init__(
        self,
        parts: Sequence[Part],
        native_items: Any,
        zeta: float,
        wholes: Sequence[Part] | None = None,
    ) -> None:
        self.parts = parts
        self.wholes = parts if wholes is None else wholes
        self.native_items = native_items
        self.zeta = zeta
        self.drift_correction = np.zeros(len(native_items.joints))
        self.multipliers = np.zeros(len(native_items.joints))
        self._drift = np.zeros(len(native_items.joints))
        self.has_joints = len(native_items.joints) > 0

    @cached_property
    def resolved(self) -> list[_Resolved]:
        """The wholes."""
        return [_resolve(part, self.has_joints) for part in self.wholes]

    @cached_property
    def solve(self) -> JointSolve:
        """Of the joints."""
        return JointSolve(self.native_items.blocks, self.native_items.joints)

    def joint_force(self, dofs: slice) -> Array:
        """J^T nu on one part, at the last evaluation.   dofs: its place."""
        if self.in_one:
            return self.in_one.joint_force(dofs)
        return self.solve.joint_force(self.multipliers, dofs)

    @property
    def drift(self) -> Array:
        """c_t (m,) of the joints at the last evaluation."""
        return self.in_one.drift if self.in_one else self._drift

    def accelerate_joined(self, q: Array, acceleration: Array, target: Array) -> Array:
        """Let J a = target; returns what the damping of cables adds then, see `improve_damping` (n,)."""
        self.multipliers = self.solve.apply(acceleration, target)
        added = np.zeros(len(acceleration))
        for part in self.resolved:
            if part.improve is not None:
                added[part.dofs] = acceleration[part.dofs]
                part.improve(q[part.dofs], added[part.dofs])
        if added.any():
            self.multipliers = self.multipliers + self.solve.apply(added, np.zeros(len(target)))
            acceleration += added
        return added

    def join(self, t: float, q: Array, v: Array) -> JointTerms:
        """Joints at (t, q, v), their Schur complement factorised; the parts are factorised at q."""
        self.terms: JointTerms = self.native_items.constrain(t, q, v)
        self._drift = self.terms.drift
        self.solve.factorise()
        return self.terms


@index_reduced_rates.register(CoupledSystem)
def coupled_rates(system, external, q, v, acceleration, rate):
    """Eq. (30). Arguments: see `index_reduced_rates`; external: (1,) time [s]."""
    t = float(external[0])
    if system.in_one:
        forces = system.native_items.act(t, q, v)
        return system.in_one.rates(t, forces, q, v, acceleration, rate)
    forces = system.native_items.forces(t, q, v)
    for part, force in zip(system.resolved, forces, strict=True):
        dofs = part.dofs
        part.rates(force, q[dofs], v[dofs], acceleration[dofs], rate[dofs])
    if not system.has_joints:
        return
    terms, solve = system.join(t, q, v), system.solve
    speed = solve.times_jacobian(v) + terms.drift
    system.accelerate_joined(q, acceleration, terms.gamma - system.zeta * speed)
    solve.apply(rate, -system.zeta * terms.value - terms.drift)


@accelerate_and_project.register(CoupledSystem)
def accelerate_and_project_coupled(system, external, q, v, duration, acceleration, end_velocity):
    """Arguments: see `accelerate_and_project`; external: (1,) time [s]."""
    t, states = float(external[0]), system.states
    velocity = v + duration * acceleration
    leaps = duration > 0.0 and states.stop > states.start
    if leaps:
        rates, velocity[states] = leap(system.native_items, states, t, q, v, duration, acceleration)
        ends = velocity[states].copy()
    if system.in_one:
        forces = system.native_items.act(t, q, velocity)
        if leaps:
            forces[states] = rates
        system.in_one.accelerate(t, forces, q, v, duration, acceleration, end_velocity)
    else:
        forces = system.native_items.forces(t, q, velocity)
        if leaps:
            forces[-1][:] = rates
        _accelerate(system, t, forces, q, v, duration, acceleration, end_velocity)
    if leaps:
        end_velocity[states] = ends


def leap(native_items, states, t, q, v, duration, acceleration):
    """Rates y' of the first order states in the middle of a step, and y at its end.

    y leaps over the velocities, as places do: y_(n+1) = y_n + h y'(t_(n+1/2)). Oscillations of y and v, as of
    oil under pressure, then keep their energy up to h w = 2; with rates foreseen from y_n and v_n they grow.

    states: their place in v.   Other arguments: see `accelerate_and_project`; v in the middle of the step,
    duration: half of it.
    """
    middle = t - duration, q - duration * v, v
    rates = native_items.rates_of_states(*middle)
    return rates, v[states] + duration * (2.0 * rates - acceleration[states])


def _accelerate(system, t, forces, q, v, duration, acceleration, end_velocity):
    """As `accelerate_and_project`, with known forces of native items on the wholes."""
    for part, force in zip(system.resolved, forces, strict=True):
        dofs = part.dofs
        part.accelerate(force, q[dofs], v[dofs], duration, acceleration[dofs], end_velocity[dofs])
    if not system.has_joints:
        return
    terms, solve = system.join(t, q, v), system.solve
    end_velocity += duration * system.accelerate_joined(
        q, acceleration, terms.gamma + system.drift_correction
    )
    solve.apply(end_velocity, -terms.drift)


@correct_position.register(CoupledSystem)
def correct_coupled_position(system, external, q, tolerance, learning, correction):
    """Arguments: see `correct_position`; external: (1,) time [s]."""
    t = float(external[0])
    if system.in_one:
        return system.in_one.correct(t, q, tolerance, learning, correction)
    worst = 0.0
    if system.has_joints:
        value = system.native_items.violations(t, q)
        system.drift_correction -= learning * value
        worst = float(np.abs(value).max())
    for part, inputs in zip(system.resolved, system.native_items.motions(t), strict=True):
        dofs = part.dofs
        violation = part.correct(inputs, q[dofs], tolerance, learning, correction[dofs])
        if violation < tolerance:
            correction[dofs] = 0.0
        if not violation <= worst:  # keeps a NaN
            worst = violation
    if system.has_joints and not worst < tolerance:
        system.solve.apply(correction, -value)
    return worst
