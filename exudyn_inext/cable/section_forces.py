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


class SectionPoints:
    """Points of a cable where section forces are asked for, and what depends on nothing else.

    Args:
        cable: the cable.
        arc_length: (m,) within 0 and the cable's length [m]; at a node, those of the element before it.

    element, xi: (m,) where they are.
    shapes: (m, 4, 4) of the nodal coordinates of an element: r, r_x, r_xx, and the integral of r from the
        left end less its weighted mean.
    load: (m,) the same of a constant load of 1 [m].   natural: (m,) curvature kappa_0 [1/m].
    """

    def __init__(self, cable: Cable, arc_length: Array) -> None:
        self.cable, self.arc_length = cable, arc_length
        ends = np.cumsum(cable.element_lengths)
        self.element = np.searchsorted(ends, arc_length - 1e-12 * cable.length)
        self.element = k = np.minimum(self.element, len(ends) - 1)
        length = cable.element_lengths[k]
        self.xi = xi = np.clip((arc_length - (ends[k] - length)) / length, 0.0, 1.0)
        points, weights = quadrature(1.0)
        weights = weights * 6.0 * points * (1.0 - points)
        mean = np.tensordot(_integrated_shape_functions(points[:, None], length), weights, (1, 0))
        shapes = [s(xi, length) for s in DERIVATIVES]
        shapes.append(_integrated_shape_functions(xi, length) - mean)
        self.shapes = np.array(shapes).transpose(2, 0, 1).copy()
        self.load = length * (xi - weights @ points)
        self.natural = np.zeros(len(k))
        if cable.dimension == 2:
            natural = [cable.natural_curvature(*place)[0] for place in zip(k, xi[:, np.newaxis], strict=True)]
            self.natural[:] = natural

    def within(self, x: Array, first: int, end: int) -> Array:
        """(m, end - first, dim) of nodal values x (n, 2, dim), by these rows of `shapes`."""
        nodal = np.concatenate([x[self.element], x[self.element + 1]], axis=1)
        result: Array = self.shapes[:, first:end] @ nodal
        return result


def section_forces(points: SectionPoints, chain: Chain, state: SolvedState, density: Array) -> SectionForces:
    """Section forces at some points of a cable.

    Args:
        points: of the cable.   chain: its kernel form.   state: of the cable, solved.
        density: (dim,) force density f = rho_A g of gravity, or (N, dim), one of each element [N/m].

    Returns:
        `SectionForces` at these points.
    """
    cable, k = points.cable, points.element
    density = np.broadcast_to(density, (cable.number_of_elements, cable.dimension))
    mean = np.zeros(density.shape)
    if cable.stretches:
        mean_section_forces(chain, state.q, state.v, state.a, np.zeros(state.q.shape), mean)
    else:
        _mean_section_forces(chain, state.q, state.v, state.multiplier, mean)
    force = mean[k] + cable.section.mass_per_length * points.within(state.a, 3, 4)[:, 0]
    force -= density[k] * points.load[:, np.newaxis]
    force += attached_variation(cable, state, density / cable.section.mass_per_length, k, points.xi)
    position, r_x, r_xx = points.within(state.q, 0, 3).transpose(1, 0, 2)
    v_x, v_xx = points.within(state.v, 1, 3).transpose(1, 0, 2)
    tangent = r_x / np.sqrt((r_x * r_x).sum(axis=1))[:, np.newaxis]
    tension = (force * tangent).sum(axis=1)
    return SectionForces(
        points.arc_length,
        position,
        tension,
        force - tension[:, np.newaxis] * tangent,
        _bending_moment(cable, points.natural, (r_x, r_xx, v_x, v_xx)),
    )


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


def _bending_moment(cable: Cable, natural: Array, rates: Sequence[Array]) -> Array:
    """(m,) see `SectionForces`.

    natural: (m,) kappa_0 [1/m].   rates: r_x, r_xx, and their rates in time, each (m, dim).
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
    return np.asarray(moment[:, 0] - section.bending_stiffness * natural)


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
