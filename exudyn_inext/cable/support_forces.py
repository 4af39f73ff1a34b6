"""What supports and links do to a cable: what is left of the balance at a state in motion."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import Bound
from ..compiled import Prepared, kernel
from ..element.inextensibility import length_gradient
from ..lowered import local_array
from ..system import accelerate_and_project
from .assembly import ACCELERATION, differences
from .axial_energy import force_in_motion
from .axial_stiffness import set_step_of_means
from .cable import Cable
from .linked_cable import LinkedCableSystem
from .many_cables import cable_systems
from .records import link_type
from .saddle_point import apply_mass
from .section_forces import SolvedState

Solved = tuple[Any, SolvedState]
"""The system of a cable, which holds its multipliers, and its state."""


class SupportForces(NamedTuple):
    """Multipliers lam and accelerations a of M a + C_q^T lam = F, at k states.

    on_coordinates: (k, n, 2, dim) of constraints that hold or move a coordinate; nothing at free slopes.
    of_links: (k, L) of the links of the cable.   accelerations: (k, n_dof).
    """

    on_coordinates: Array
    of_links: Array
    accelerations: Array


class SupportedCable:
    """A cable with its mass as it is, solved for what its supports do."""

    def __init__(self, cable: Cable) -> None:
        self._closed, self._own_links, self._stretches = cable.closed, len(cable.links), cable.stretches
        free = replace(cable, fixed=np.zeros_like(cable.fixed), links=())
        self._system, of_free = cable_systems([cable, free], 0.0)
        self._free = of_free.chain
        self._step = 0.0
        self._last: tuple[Any, ...] = ()  # what decides on the state that was solved last
        self._accelerate = Bound(accelerate_and_project, self._system)
        self._set_force = Prepared(force_in_motion if cable.stretches else _force_in_motion)
        self._links: Any = np.zeros(0, link_type(cable.dimension))
        if isinstance(self._system, LinkedCableSystem):
            self._links = self._system.link_system.links

    def solve(self, external: Array, q: Array, v: Array, steps: Array) -> SupportForces:
        """At k states.

        Args:
            external: (k, n_external) all that acts, with motions behind it.   q, v: (k, n_dof).
            steps: (k,) before the states, whose mean axial forces count [s].
        """
        a, balance = np.zeros(q.shape), np.zeros((len(q), *self._system.chain.shape))
        links: Any = np.zeros((len(q), len(self._links)), self._links.dtype)
        self._last = ()
        for k in range(len(q)):
            state = self._solve_one(external[k], q[k], v[k], steps[k])
            a[k], links[k] = state.a.ravel(), self._links
            self._set_balance(external[k, : q.shape[1]].reshape(state.a.shape), state, balance[k])
        of_links = self._take_rods(links, balance)
        if self._closed:
            balance[:, 0] += balance[:, -1]
        return SupportForces(balance, of_links, a)

    def solved(self, external: Array, q: Array, v: Array, step: float) -> Solved:
        """One state, which may have been the last one; arguments: see `solve`."""
        given = external.tobytes(), q.tobytes(), v.tobytes(), step if self._stretches else 0.0
        if self._last != given:
            self._state, self._last = self._solve_one(external, q, v, step), given
        return self._system, self._state

    def _solve_one(self, external: Array, q: Array, v: Array, step: float) -> SolvedState:
        if self._stretches and step != self._step:
            for chain in self._system.chain, self._free:
                set_step_of_means(step, chain.nodes, chain.elements)
            self._step = step
        a, rest = np.zeros((2, q.size))
        self._accelerate(external, q, v, 0.0, a, rest)
        return solved_state(self._system, q.copy(), v.copy(), a)

    def _set_balance(self, force: Array, state: SolvedState, balance: Array) -> None:
        """F - M a less what lengths or strains do, but with nodal multipliers and links.

        force: (n, 2, dim) that acts on the nodes.   balance: (n, 2, dim) output.
        """
        if self._stretches:
            self._set_force(self._free, force, state.q, state.v, state.a, balance)
        else:
            self._set_force(self._system.chain, state.q, balance)
        balance -= apply_mass(self._free, state.a)

    def _take_rods(self, links: Any, balance: Array) -> Array:
        """Multipliers (k, L) of the links; what the rods do is taken out of the balance."""
        multipliers: Array = links["multiplier"][:, :, 0]
        if not multipliers.size:
            return multipliers
        forces = (multipliers * links["inverse_length"])[:, :, np.newaxis] * links["offset"]
        at_nodes = links["weight"][..., np.newaxis] * forces[:, :, np.newaxis, np.newaxis, :]
        states = np.arange(len(links))[:, np.newaxis, np.newaxis]
        np.subtract.at(balance, (states, links["node"]), at_nodes)
        return multipliers[:, links.shape[1] - self._own_links :]


def solved_state(system: Any, q: Array, v: Array, a: Array) -> SolvedState:
    """Of a system that has just given these accelerations.   q, v, a: (n_dof,)."""
    multiplier = system.chain.elements["multiplier"][:, ACCELERATION].copy()
    shape = system.chain.shape
    return SolvedState(q.reshape(shape), v.reshape(shape), a.reshape(shape), multiplier)


@kernel
def _force_in_motion(chain, q, force):
    """force (n, 2, dim) of all but inertia, nodal constraints and links, after the solve at q [N, Nm]."""
    axes, e, gradient = chain.axes, local_array(3, 3), local_array(3, 3)
    for k in range(len(chain.nodes)):
        for i in range(len(axes)):
            force[k, 0, i] = chain.nodes[k].force[ACCELERATION, 0, i]
            force[k, 1, i] = chain.nodes[k].force[ACCELERATION, 1, i]
    for k in range(len(chain.elements)):
        differences(axes, q, k, e)
        length_gradient(axes, chain.elements[k].slope_gram, e, gradient)
        pull = chain.elements[k].multiplier[ACCELERATION]
        for i in range(len(axes)):
            force[k, 0, i] += pull * gradient[0, i]
            force[k, 1, i] -= pull * gradient[1, i]
            force[k + 1, 0, i] -= pull * gradient[0, i]
            force[k + 1, 1, i] -= pull * gradient[2, i]
