"""Energy, forces and section forces of a cable with axial stiffness, whose axial forces are explicit."""

import numpy as np

from ..arrays import Array
from ..compiled import clear, kernel
from ..element.inextensibility import contract, length_gradient
from ..lowered import local_array
from .assembly import ACCELERATION, add_bending, damp_element, differences, leave_targets
from .axial import add_forces_of, assemble_chain, mean_stretch, stored_energy
from .axial_stiffness import ADDED_MASS, FORCE
from .cable import Cable
from .chain import Chain
from .index_reduction import assemble_forces
from .saddle_point import free_force


@kernel
def static_energy(chain, q, force):
    """Energy of bending and axial forces [J], and force (n, 2, dim) output [N, Nm], zero on entry.

    Args:
        chain: with explicit axial forces.   q: (n, 2, dim).
    """
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    assemble_chain(axes, nodes, elements, force, q, force, 0.0, leave_targets, 0.0)
    energy = stored_energy(axes, nodes, elements, chain, q, force, force)
    for k in range(len(nodes)):
        free_force(axes, nodes, elements, k, ACCELERATION, force[k])
    return energy


@kernel
def force_in_motion(chain, external, q, v, a, force):
    """force (n, 2, dim) of all but inertia at (q, v, a) [N, Nm].   external: (n, 2, dim)."""
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    assemble_forces(axes, nodes, elements, external, q, v, 0.0, v, leave_targets, 0.0)
    add_forces_of(axes, nodes, elements, a)
    for k in range(len(nodes)):
        free_force(axes, nodes, elements, k, ACCELERATION, force[k])


@kernel
def mean_section_forces(chain, q, v, a, rest, mean):
    """mean (N, dim): section force of each element weighted with 6 xi (1 - xi), see `section_forces`.

    rest: (n, 2, dim) zero.
    """
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    assemble_chain(axes, nodes, elements, rest, q, v, 0.0, leave_targets, 0.0)
    add_forces_of(axes, nodes, elements, a)
    e, e_t, gradient, force = local_array(3, 3), local_array(3, 3), local_array(3, 3), local_array(3, 3)
    damped, memory = local_array(3, 3), local_array(7, 3)
    for k in range(len(elements)):
        element = elements[k]
        differences(axes, q, k, e)
        differences(axes, v, k, e_t)
        clear(damped)
        damp_element(axes, nodes, elements, k, e, e_t, memory, damped)
        length_gradient(axes, element.slope_gram, e, gradient)
        clear(force)
        add_bending(axes, element, e, force)
        stretch = mean_stretch(element, 0.5 * contract(axes, e, gradient))
        along = 0.75 * element.per_length / stretch * element.target[ACCELERATION]
        for i in range(len(axes)):
            mean[k, i] = along * gradient[0, i] - force[0, i] / (stretch * stretch) - damped[0, i]


def middle_tension(cable: Cable, chain: Chain, a: Array) -> Array:
    """(N,) in the middle of elements, at the last evaluation, which gave a (n, 2, dim) [N]."""
    axial = chain.elements["axial"]
    along = np.einsum("kai,kai->k", chain.elements["gradient"], np.concatenate([a[:-1], a[1:]], axis=1))
    force: Array = axial[:, FORCE] + axial[:, ADDED_MASS] * along
    return 1.5 * force / cable.element_lengths


def strain_tension(cable: Cable, chain: Chain) -> Array:
    """(N,) mean tension of each element by its strains, damping included [N].

    chain: evaluated by `mean_section_forces`.
    """
    lengths = cable.element_lengths
    ends = (np.append(lengths, 0.0) + np.append(0.0, lengths)) / 6.0
    nodal = chain.nodes["axial"][:, FORCE] / ends
    return chain.elements["axial"][:, FORCE] / lengths + (nodal[:-1] + nodal[1:]) / 6.0
