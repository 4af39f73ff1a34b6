"""What supports and links do to a cable: what is left of the balance at a state in motion."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import kernel
from ..element.inextensibility import length_gradient
from ..lowered import local_array
from ..system import accelerate_and_project
from .assembly import add_element_force, differences
from .axial_energy import force_in_motion
from .cable import Cable
from .chain import build_chain
from .linked_cable import LinkedCableSystem, cable_system
from .saddle_point import apply_mass


@kernel
def _out_of_balance(chain, q, result):
    """F - M a - C_q^T lam of the length constraints.

    Args:
        chain: solved at q (n, 2, dim).   result: (n, 2, dim) M a without supports; output [N, Nm].
    """
    axes = chain.axes
    for k in range(len(q)):
        for kind in range(2):
            for i in range(len(axes)):
                result[k, kind, i] = chain.nodes[k].force[0, kind, i] - result[k, kind, i]
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(chain.elements)):
        element = chain.elements[k]
        differences(axes, q, k, e)
        length_gradient(axes, element.slope_gram, e, gradient)
        for row in range(3):
            for i in range(len(axes)):
                gradient[row, i] *= -element.multiplier[0]
        add_element_force(axes, gradient, result[k], result[k + 1])


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
        inertia = np.zeros(shape)
        apply_mass(self._free, a.reshape(shape), inertia)
        if self._stretches:
            force = external[: q.size].reshape(shape)
            force_in_motion(self._free, force, q.reshape(shape), v.reshape(shape), on_coordinates)
            on_coordinates -= inertia
        else:
            on_coordinates[:] = inertia
            _out_of_balance(system.chain, q.reshape(shape), on_coordinates)
        of_links = self._take_rods(on_coordinates)
        if self._closed:
            on_coordinates[0] += on_coordinates[-1]
        return SupportForces(on_coordinates, of_links)

    def _take_rods(self, on_coordinates: Array) -> Array:
        """Multipliers (L,) of the links; what the rods do is taken out of the balance."""
        if not isinstance(self._system, LinkedCableSystem):
            return np.zeros(0)
        links = self._system.border.links
        multipliers = links["multiplier"][:, 0]
        forces = (multipliers * links["inverse_length"])[:, np.newaxis] * links["offset"]
        at_nodes = links["weight"][:, :, :, np.newaxis] * forces[:, np.newaxis, np.newaxis, :]
        np.subtract.at(on_coordinates, links["node"], at_nodes)
        return multipliers[len(links) - self._own_links :]
