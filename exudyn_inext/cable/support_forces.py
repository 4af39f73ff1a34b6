"""What supports and links do to a cable: what is left of the balance at a state in motion."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..system import accelerate_and_project
from .axial_energy import force_in_motion
from .cable import Cable
from .chain import Chain, build_chain
from .index_reduction import ACCELERATION
from .linked_cable import LinkedCableSystem, cable_system
from .saddle_point import apply_mass


def _out_of_balance(chain: Chain, q: Array, inertia: Array) -> Array:
    """F - M a - C_q^T lam of the length constraints, (n, 2, dim).

    Args:
        chain: solved at q (n, 2, dim).   inertia: (n, 2, dim) M a without supports [N, Nm].
    """
    nodes, elements = chain.nodes, chain.elements
    balance: Array = nodes["force"][:, ACCELERATION] - inertia
    e = np.stack([np.diff(q[:, 0], axis=0), q[:-1, 1], q[1:, 1]], axis=1)
    multipliers = elements["multiplier"][:, ACCELERATION, np.newaxis, np.newaxis]
    forces = 2.0 * multipliers * (elements["slope_gram"] @ e)  # see `length_gradient`
    balance[:-1] -= np.stack([-forces[:, 0], forces[:, 1]], axis=1)
    balance[1:] -= forces[:, [0, 2]]
    return balance


class SupportForces(NamedTuple):
    """Multipliers lam of M a + C_q^T lam = F.

    on_coordinates: (n, 2, dim) of constraints that hold or move a coordinate; means nothing at free slopes.
    of_links: (L,) of the links of the cable.
    """

    on_coordinates: Array
    of_links: Array


class SupportedCable:
    """A cable with its mass as it is, solved for what its supports do."""

    def __init__(self, cable: Cable) -> None:
        self._closed, self._own_links, self._stretches = cable.closed, len(cable.links), cable.stretches
        self._system = cable_system(cable, 0.0)
        self._free = build_chain(replace(cable, fixed=np.zeros_like(cable.fixed), links=()))

    def solve(self, external: Array, q: Array, v: Array) -> SupportForces:
        """At a state.   external: all that acts, with motions behind it.   q, v: (n_dof,)."""
        system, shape = self._system, self._system.chain.shape
        (a, rate), on_coordinates = np.zeros((2, q.size)), np.zeros(shape)
        accelerate_and_project(system, external, q, v, 0.0, a, rate)
        inertia = apply_mass(self._free, a.reshape(shape))
        if self._stretches:
            force = external[: q.size].reshape(shape)
            force_in_motion(self._free, force, q.reshape(shape), v.reshape(shape), on_coordinates)
            on_coordinates -= inertia
        else:
            on_coordinates = _out_of_balance(system.chain, q.reshape(shape), inertia)
        of_links = self._take_rods(on_coordinates)
        if self._closed:
            on_coordinates[0] += on_coordinates[-1]
        return SupportForces(on_coordinates, of_links)

    def _take_rods(self, on_coordinates: Array) -> Array:
        """Multipliers (L,) of the links; what the rods do is taken out of the balance."""
        if not isinstance(self._system, LinkedCableSystem):
            return np.zeros(0)
        links = self._system.link_system.links
        multipliers = links["multiplier"][:, 0]
        forces = (multipliers * links["inverse_length"])[:, np.newaxis] * links["offset"]
        at_nodes = links["weight"][:, :, :, np.newaxis] * forces[:, np.newaxis, np.newaxis, :]
        np.subtract.at(on_coordinates, links["node"], at_nodes)
        return multipliers[len(links) - self._own_links :]
