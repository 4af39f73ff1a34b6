"""What supports and links do to a cable: what is left of the balance at a state in motion."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import Bound
from ..system import accelerate_and_project
from .axial_energy import force_in_motion
from .axial_stiffness import set_step_of_means
from .cable import Cable
from .chain import build_chain
from .index_reduction import ACCELERATION
from .linked_cable import LinkedCableSystem, cable_system
from .records import link_type
from .saddle_point import apply_mass


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
        self._system = cable_system(cable, 0.0)
        self._free = build_chain(replace(cable, fixed=np.zeros_like(cable.fixed), links=()))
        self._accelerate = Bound(accelerate_and_project, self._system)
        self._links: Any = np.zeros(0, link_type(cable.dimension))
        if isinstance(self._system, LinkedCableSystem):
            self._links = self._system.link_system.links

    def solve(self, external: Array, q: Array, v: Array, steps: Array) -> SupportForces:
        """At k states.

        Args:
            external: (k, n_external) all that acts, with motions behind it.   q, v: (k, n_dof).
            steps: (k,) before the states, whose mean axial forces count [s].
        """
        shape = (len(q), *self._system.chain.shape)
        a, balance = np.zeros(q.shape), np.zeros(shape)
        links: Any = np.zeros((len(q), len(self._links)), self._links.dtype)
        balances = self._without_strains if self._stretches else self._without_lengths
        balances(external, q, v, steps, a, links, balance)
        balance -= apply_mass(self._free, a.reshape(shape))
        of_links = self._take_rods(links, balance)
        if self._closed:
            balance[:, 0] += balance[:, -1]
        return SupportForces(balance, of_links, a)

    def _states(
        self, external: Array, q: Array, v: Array, steps: Array, a: Array, links: Any
    ) -> Iterator[int]:
        """Solve for each of them.   a: (k, n_dof) and links: (k, L) output."""
        rate = np.zeros(q.shape[1])
        for k in range(len(q)):
            for chain in (self._system.chain, self._free) if self._stretches else ():
                set_step_of_means(steps[k], chain.nodes, chain.elements)
            self._accelerate(external[k], q[k], v[k], 0.0, a[k], rate)
            links[k] = self._links
            yield k

    def _without_lengths(self, external: Array, q: Array, v: Array, steps: Array, *output: Array) -> None:
        """F - C_q^T lam of the length constraints, into the last of the outputs, (k, n, 2, dim)."""
        a, links, balance = output
        chain = self._system.chain
        pulls = np.zeros((len(q), len(chain.elements)))
        for k in self._states(external, q, v, steps, a, links):
            balance[k] = chain.nodes["force"][:, ACCELERATION]
            pulls[k] = chain.elements["multiplier"][:, ACCELERATION]
        states = q.reshape(balance.shape)
        e = np.empty((*pulls.shape, 3, balance.shape[-1]))
        e[:, :, 0] = states[:, 1:, 0] - states[:, :-1, 0]
        e[:, :, 1], e[:, :, 2] = states[:, :-1, 1], states[:, 1:, 1]
        gradient = 2.0 * chain.elements["slope_gram"] @ e  # see `length_gradient`
        along = pulls[:, :, np.newaxis, np.newaxis] * gradient
        balance[:, :-1, 0] += along[:, :, 0]
        balance[:, :-1, 1] -= along[:, :, 1]
        balance[:, 1:] -= along[:, :, ::2]

    def _without_strains(self, external: Array, q: Array, v: Array, steps: Array, *output: Array) -> None:
        """F less what axial stiffness does, as above."""
        a, links, balance = output
        shape = balance.shape[1:]
        for k in self._states(external, q, v, steps, a, links):
            force = external[k, : q.shape[1]].reshape(shape)
            q_k, v_k, a_k = (array[k].reshape(shape) for array in (q, v, a))
            force_in_motion(self._free, force, q_k, v_k, a_k, balance[k])

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
