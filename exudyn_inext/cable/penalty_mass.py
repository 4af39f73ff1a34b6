"""The penalty formulation of Bayo: constraints as very heavy springs, dampers and masses.

C'' + 2 z C' + z^2 C = 0 is weighed with a large mass k instead of being enforced by multipliers:
(M + k C_q^T C_q) a = F + k C_q^T (gamma - 2 z C' - z^2 C) has no multipliers at all, so that any explicit
solver can take it, and whatever else acts on the nodes adds to F.

Source: E. Bayo, J. Garcia de Jalon, M. A. Serna, A modified Lagrangian formulation for the dynamic
analysis of constrained mechanical systems, CMAME 71 (1988) 183-195.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import inlined, kernel
from ..element.inertia import mass_matrix
from .assembly import GAMMA, RATE, VALUE
from .cable import Cable
from .chain import Chain, build_chain
from .constraint_rows import add_gradient, set_length_gradients, unconstrained_force
from .sparse_forms import form_of_cable


class PenaltySystem(NamedTuple):
    """A chain whose constraints, supports included, are penalised.

    chain: coefficients and memory; nothing is held.
    mass: (n, 2, dim, n, 2, dim) mass without penalties [kg, kg m, kg m^2].
    reference: (n, 2, dim) reference configuration, where supports hold.
    nodal: (n,) penalty of each nodal constraint (18) [kg m^2], 0 where there is none.
    length: (N,) penalty of the length constraint (19) that each element belongs to [kg].
    held: (n, 2, dim) penalties of held coordinates [kg, kg m^2], 0 where free.
    gradient: (n, 2, dim) memory.
    z: rate at which violations decay [1/s].
    """

    chain: Chain
    mass: Array
    reference: Array
    nodal: Array
    length: Array
    held: Array
    gradient: Array
    z: float


def build_penalty_system(cable: Cable, held: np.ndarray, penalty: float, z: float) -> PenaltySystem:
    """Penalties relative to the masses of the elements.

    A constraint on a length or position [m] weighs penalty * rho_A l, one on a slope [-] penalty * rho_A l^3.

    Args:
        cable: without supports and links.
        held: (n, 2, dim) coordinates that the ground holds at their reference values.
        penalty: k over the element mass [-].   z: stabilisation rate [1/s].
    """
    shape, lengths = cable.reference.shape, cable.element_lengths
    masses = penalty * cable.section.mass_per_length * lengths
    of_position, of_slope = _at_nodes(masses, cable.closed), _at_nodes(masses * lengths**2, cable.closed)
    weights = np.repeat(np.stack([of_position, of_slope], axis=1)[:, :, None], shape[2], axis=2)
    unconstrained: np.ndarray = np.array(held[:, 1].all(axis=1))
    if cable.closed:  # the last node is the first one once more
        weights[-1] = 0.0
        unconstrained[-1] = True
    return PenaltySystem(
        chain=build_chain(cable),
        mass=cable.section.mass_per_length * form_of_cable(cable, mass_matrix).toarray().reshape(shape * 2),
        reference=cable.reference,
        nodal=np.where(unconstrained, 0.0, of_slope),
        length=_in_groups(masses, cable.group_of_element()),
        held=np.where(held, weights, 0.0),
        gradient=np.zeros(shape),
        z=z,
    )


def _at_nodes(of_elements: Array, closed: bool) -> Array:
    """(n,) mean of the neighbouring elements."""
    first, last = (of_elements[-1], of_elements[0]) if closed else (of_elements[0], of_elements[-1])
    return 0.5 * (np.append(first, of_elements) + np.append(of_elements, last))


def _in_groups(of_elements: Array, group: np.ndarray) -> Array:
    """(N,) mean over the group of each element."""
    same = group[:, None] == group
    return same @ of_elements / same.sum(axis=1)


@inlined
def _demand(terms, z):
    """gamma - 2 z C' - z^2 C of a constraint."""
    return terms[GAMMA] - 2.0 * z * terms[RATE] - z * z * terms[VALUE]


@kernel
def penalty_force(system, external, q, v, force):
    """force = Q_ext + Q_el + Q_damping + k C_q^T (gamma - 2 z C' - z^2 C).

    Args:
        system: coefficients and memory.
        external: (n, 2, dim) [N, Nm].
        q, v: (n, 2, dim) coordinates and velocities.
        force: (n, 2, dim) output [N, Nm].
    """
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    unconstrained_force(system.chain, external, q, v, force)
    z = system.z
    for k in range(len(nodes)):
        push = system.nodal[k] * _demand(nodes[k].constraint, z)
        for i in range(len(axes)):
            force[k, 1, i] += push * 2.0 * q[k, 1, i]
            for kind in range(2):
                away = q[k, kind, i] - system.reference[k, kind, i]
                force[k, kind, i] -= system.held[k, kind, i] * (2.0 * z * v[k, kind, i] + z * z * away)
    first = 0
    demand = 0.0
    for k in range(len(elements)):
        demand += _demand(elements[k].constraint, z)
        if nodes[k + 1].ends_group:
            for j in range(first, k + 1):
                for i in range(len(axes)):
                    push = system.length[j] * demand
                    force[j, 0, i] += push * elements[j].gradient[0, i]
                    force[j, 1, i] += push * elements[j].gradient[1, i]
                    force[j + 1, 0, i] += push * elements[j].gradient[2, i]
                    force[j + 1, 1, i] += push * elements[j].gradient[3, i]
            first = k + 1
            demand = 0.0


@kernel
def penalty_mass(system, q, mass):
    """mass = M + k C_q^T C_q.

    Args:
        system: coefficients and memory.
        q: (n, 2, dim) coordinates.
        mass: (n, 2, dim, n, 2, dim) output [kg, kg m, kg m^2].
    """
    axes, nodes, elements = system.chain.axes, system.chain.nodes, system.chain.elements
    gradient = system.gradient
    for place in np.ndindex(mass.shape):
        mass[place] = system.mass[place]
    for k in range(len(nodes)):
        for i in range(len(axes)):
            mass[k, 0, i, k, 0, i] += system.held[k, 0, i]
            mass[k, 1, i, k, 1, i] += system.held[k, 1, i]
            for j in range(len(axes)):
                mass[k, 1, i, k, 1, j] += 4.0 * system.nodal[k] * q[k, 1, i] * q[k, 1, j]
    set_length_gradients(axes, nodes, elements, q)
    first = 0
    gradient[0] = 0.0
    for k in range(len(elements)):
        gradient[k + 1] = 0.0
        add_gradient(axes, elements[k].gradient, gradient[k], gradient[k + 1])
        if nodes[k + 1].ends_group:
            _add_outer_product(axes, system.length[k], gradient, first, k + 2, mass)
            first = k + 1
            gradient[k + 1] = 0.0


@inlined
def _add_outer_product(axes, weight, gradient, first, last, mass):
    """mass += weight g g^T with g at the nodes first to last - 1."""
    for m in range(first, last):
        for a in range(2):
            for i in range(len(axes)):
                left = weight * gradient[m, a, i]
                for n in range(first, last):
                    for b in range(2):
                        for j in range(len(axes)):
                            mass[m, a, i, n, b, j] += left * gradient[n, b, j]
