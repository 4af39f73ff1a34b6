"""Tension, shear force and bending moment along a cable, from its multipliers and accelerations.

The force in the section is n(x) = N t + Q. Virtual displacements of an element that turn no node give the
mean of n over the element, weighted with 6 xi (1 - xi), from bending, damping and the length multiplier;
the balance of momentum, n_x = rho_A r_tt - f, gives how it varies within. So N(x) is found element by
element, past point loads and supports.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..compiled import clear, kernel
from ..element.bending_damping import add_damping_force
from ..element.inextensibility import length_gradient
from ..element.shape_functions import first_derivatives, quadrature, second_derivatives, shape_functions
from ..lowered import local_array
from .assembly import add_bending, differences
from .attached_forces import attached_variation
from .axial_energy import mean_section_forces
from .cable import Cable, CurvatureMeasure
from .chain import Chain

DERIVATIVES = (shape_functions, first_derivatives, second_derivatives)


@dataclass(frozen=True, eq=False)
class SectionForces:
    """At m points of a cable.

    arc_length: (m,) [m].   position: (m, dim) [m].
    tension: (m,) N [N].   shear_force: (m, dim) Q, across the cable [N].
    bending_moment: (m,) EI (kappa - kappa_0) + D kappa_t, with its sign in the plane, else its size [N m].
    """

    arc_length: Array
    position: Array
    tension: Array
    shear_force: Array
    bending_moment: Array


@kernel
def _mean_section_forces(chain, q, v, multiplier, mean):
    """mean (N, dim): n of each element weighted with 6 xi (1 - xi).   multiplier: (N,) of length."""
    axes = chain.axes
    e, e_t, force, gradient = local_array(3, 3), local_array(3, 3), local_array(3, 3), local_array(3, 3)
    memory = local_array(7, 3)
    for k in range(len(chain.elements)):
        element = chain.elements[k]
        differences(axes, q, k, e)
        differences(axes, v, k, e_t)
        clear(force)
        add_bending(axes, element, e, force)
        if element.damped:
            add_damping_force(axes, element.damping, e, e_t, memory, force)
        length_gradient(axes, element.slope_gram, e, gradient)
        for i in range(len(axes)):
            mean[k, i] = multiplier[k] * gradient[0, i] - force[0, i]


@dataclass(frozen=True, eq=False)
class SolvedState:
    """A cable in motion: q, v, a (n, 2, dim), and its length multipliers (N,)."""

    q: Array
    v: Array
    a: Array
    multiplier: Array


def section_forces(
    cable: Cable, chain: Chain, state: SolvedState, density: Array, arc_length: Array
) -> SectionForces:
    """Section forces at the given points.

    Args:
        cable, chain: the cable and its kernel form.
        state: of `cable`, solved.
        density: (dim,) force density f = rho_A g of gravity, or (N, dim), one of each element [N/m].
        arc_length: (m,) within 0 and the cable's length [m]; at a node, those of the element before it.

    Returns:
        `SectionForces` at these points.
    """
    density = np.broadcast_to(density, (cable.number_of_elements, cable.dimension))
    mean = np.zeros(density.shape)
    if cable.stretches:
        mean_section_forces(chain, state.q, state.v, state.a, np.zeros(state.q.shape), mean)
    else:
        _mean_section_forces(chain, state.q, state.v, state.multiplier, mean)
    ends = np.cumsum(cable.element_lengths)
    k = np.minimum(np.searchsorted(ends, arc_length - 1e-12 * cable.length), len(ends) - 1)
    length = cable.element_lengths[k]
    xi = np.clip((arc_length - (ends[k] - length)) / length, 0.0, 1.0)
    force = mean[k] + _variation(cable, state.a, density, k, xi)
    force += attached_variation(cable, state, density / cable.section.mass_per_length, k, xi)
    position, r_x, r_xx = (_within(state.q, k, s(xi, length)) for s in DERIVATIVES)
    v_x, v_xx = (_within(state.v, k, s(xi, length)) for s in DERIVATIVES[1:])
    tangent = r_x / np.linalg.norm(r_x, axis=1)[:, None]
    tension = np.einsum("mi,mi->m", force, tangent)
    return SectionForces(
        arc_length,
        position,
        tension,
        force - tension[:, None] * tangent,
        _bending_moment(cable, (k, xi), (r_x, r_xx, v_x, v_xx)),
    )


def _within(x: Array, k: np.ndarray, shapes: Array) -> Array:
    """(m, dim) values in elements k (m,), from nodal ones x (n, 2, dim).   shapes: (4, m)."""
    nodal = np.concatenate([x[:-1], x[1:]], axis=1)[k]
    return np.einsum("sm,msi->mi", shapes, nodal)


def _variation(cable: Cable, a: Array, density: Array, k: np.ndarray, xi: Array) -> Array:
    """(m, dim) n less its weighted mean, from the balance of momentum within element k."""
    points, weights = quadrature(1.0)
    weights = weights * 6.0 * points * (1.0 - points)
    length = cable.element_lengths[k]
    mean = np.tensordot(_integrated_shape_functions(points[:, None], length), weights, (1, 0))
    momentum = _within(a, k, _integrated_shape_functions(xi, length) - mean)
    load = density[k] * (length * (xi - weights @ points))[:, None]
    return np.asarray(cable.section.mass_per_length * momentum - load)


def _integrated_shape_functions(xi: Array, length: Array) -> Array:
    """(4, ..., m) integral of the shape functions from the left ends to xi (..., m) [m, m^2, m, m^2]."""
    x, length = np.broadcast_arrays(xi, length)
    return length * np.stack(
        [
            x - x**3 + x**4 / 2,
            length * (x**2 / 2 - 2 * x**3 / 3 + x**4 / 4),
            x**3 - x**4 / 2,
            length * (x**4 / 4 - x**3 / 3),
        ]
    )


def _bending_moment(cable: Cable, places: tuple[np.ndarray, Array], rates: Sequence[Array]) -> Array:
    """(m,) see `SectionForces`.

    places: elements (m,) and where in them (m,).   rates: r_x, r_xx, and their rates in time, each (m, dim).
    """
    section, power = cable.section, 2 if cable.stretches else 3  # by the arc length, stretched or not
    r_x, r_xx, v_x, v_xx = rates
    square = (r_x * r_x).sum(axis=1, keepdims=True)
    kappa = _cross(r_x, r_xx) / square ** (power / 2)
    kappa_t = (_cross(v_x, r_xx) + _cross(r_x, v_xx)) / square ** (power / 2)
    kappa_t -= power * (r_x * v_x).sum(axis=1, keepdims=True) / square * kappa
    moment = section.bending_stiffness * kappa + section.bending_damping * kappa_t
    if cable.dimension == 3:
        return np.asarray(np.linalg.norm(moment, axis=1))
    natural = [cable.natural_curvature(k, np.array([x]))[0] for k, x in zip(*places, strict=True)]
    return np.asarray(moment[:, 0] - section.bending_stiffness * np.array(natural))


def _cross(a: Array, b: Array) -> Array:
    """(m, 3) in space, (m, 1) in the plane."""
    if a.shape[1] == 2:
        return a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1]
    return np.cross(a, b)


def multiplier_tension(cable: Cable, q: Array, v: Array, nodal: Array, length: Array) -> Array:
    """Mean tension of each element (N,) [N], from the multipliers and the curvature.

    A length multiplier lam is a tension 2 lam; a nodal one is concentrated, 2 lam at a point, half of it
    on either side. To both comes what bending and its damping do on a stretch.

    Args:
        q, v: (n, 2, dim).   nodal: (n,) multipliers of Eq. (18) [N m].   length: (N,) of Eq. (19) [N].
    """
    return constraint_tension(cable, nodal, length) + _bending_tension(cable, q, v)


def constraint_tension(cable: Cable, nodal: Array, length: Array) -> Array:
    """The share of the multipliers in that; see `multiplier_tension`."""
    share = nodal.copy()
    if not cable.closed:
        share[[0, -1]] *= 2.0
    else:
        share[[0, -1]] = share[0] + share[-1]
    result: Array = 2.0 * length + (share[1:] + share[:-1]) / cable.element_lengths
    return result


def _bending_tension(cable: Cable, q: Array, v: Array) -> Array:
    """(N,) mean of r_x . (dU/dr_x - (dU/dr_xx)_x) [N].

    EI kappa^2 for U = EI |r_xx|^2 / 2, twice that for EI |r_x|^2 |r_xx|^2 / 2; -2 EI kappa_0 kappa for
    -EI kappa_0 r_x x r_xx; and likewise 2 D kappa_t . kappa of the damping.
    """
    section, share = cable.section, 2.0 if cable.measure is CurvatureMeasure.PRODUCT else 1.0
    means = np.zeros(cable.number_of_elements)
    for k, length in enumerate(cable.element_lengths):
        xi, weight = quadrature(float(length))
        nodal = [np.concatenate([of_nodes[k], of_nodes[k + 1]]) for of_nodes in (q, v)]
        shapes = [s(xi, float(length)).T for s in (first_derivatives, second_derivatives)]
        rates = np.stack([s @ e for e in nodal for s in shapes])
        r_x, r_xx, v_x, v_xx = np.pad(rates, ((0, 0), (0, 0), (0, 3 - cable.dimension)))
        kappa, kappa_t = np.cross(r_x, r_xx), np.cross(v_x, r_xx) + np.cross(r_x, v_xx)
        density = section.bending_stiffness * share * (r_xx * r_xx).sum(axis=1)
        density += 2.0 * section.bending_damping * (kappa_t * kappa).sum(axis=1)
        if cable.is_naturally_curved:
            density -= 2.0 * section.bending_stiffness * cable.natural_curvature(k, xi) * kappa[:, 2]
        means[k] = weight @ density / length
    return means
