"""Tension, shear force and bending moment along a cable, from its multipliers and accelerations.

The force in the section is n(x) = N t + Q. Virtual displacements of an element that turn no node give the
mean of n over the element, weighted with 6 xi (1 - xi), from bending, damping and the length multiplier;
the balance of momentum, n_x = rho_A r_tt - f, gives how it varies within. So N(x) is found element by
element, past point loads and supports.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, clear, inlined, kernel
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
        means = mean_section_forces if cable.stretches else _mean_section_forces
        self.set_means, self.set_forces = Prepared(means), Prepared(_forces_at)


def section_forces(points: SectionPoints, chain: Chain, state: SolvedState, density: Array) -> SectionForces:
    """Section forces at some points of a cable.

    Args:
        points: of the cable.   chain: its kernel form.   state: of the cable, solved.
        density: (dim,) force density f = rho_A g of gravity, or (N, dim), one of each element [N/m].

    Returns:
        `SectionForces` at these points.
    """
    cable, section = points.cable, points.cable.section
    density = np.zeros((cable.number_of_elements, cable.dimension)) + density
    mean = np.zeros(density.shape)
    if cable.stretches:
        points.set_means(chain, state.q, state.v, state.a, np.zeros(state.q.shape), mean)
    else:
        points.set_means(chain, state.q, state.v, state.multiplier, mean)
    position, shear = np.zeros((2, len(points.element), cable.dimension))
    shear += attached_variation(cable, state, density / section.mass_per_length, points.element, points.xi)
    tension, moment = np.zeros((2, len(points.element)))
    law = section.mass_per_length, section.bending_stiffness, section.bending_damping, cable.stretches
    where = points.element, points.shapes, points.load, points.natural
    points.set_forces(where, law, mean, density, state.q, state.v, state.a, position, shear, tension, moment)
    return SectionForces(points.arc_length, position, tension, shear, moment)


@kernel
def _forces_at(points, law, mean, density, q, v, a, position, force, tension, moment):
    """`SectionForces` at m points.

    Args:
        points: element, shapes, load and natural of `SectionPoints`.
        law: rho_A, EI, D, and whether the cable stretches.
        mean, density: (N, dim) of the elements, see `section_forces`.   q, v, a: (n, 2, dim).
        position, tension, moment: output, zero on entry.
        force: (m, dim) what is attached adds to n; output: shear force.
    """
    element, shapes, load, natural = points
    mass, stiffness, damping, stretches = law
    r, curvature = local_array(4, 3), local_array(2, 3)
    for m in range(len(element)):
        k = element[m]
        clear(r)
        for i in range(q.shape[2]):
            force[m, i] += mean[k, i] - density[k, i] * load[m]
            for c in range(4):
                node, kind = k + c // 2, c % 2
                position[m, i] += shapes[m, 0, c] * q[node, kind, i]
                force[m, i] += mass * shapes[m, 3, c] * a[node, kind, i]
                for order in range(2):
                    r[order, i] += shapes[m, 1 + order, c] * q[node, kind, i]
                    r[2 + order, i] += shapes[m, 1 + order, c] * v[node, kind, i]
        square = r[0, 0] ** 2 + r[0, 1] ** 2 + r[0, 2] ** 2
        for i in range(q.shape[2]):
            tension[m] += force[m, i] * r[0, i] / np.sqrt(square)
        for i in range(q.shape[2]):
            force[m, i] -= tension[m] * r[0, i] / np.sqrt(square)
        _set_curvature(r, square, 2.0 if stretches else 3.0, curvature)
        for i in range(3):
            curvature[0, i] = stiffness * curvature[0, i] + damping * curvature[1, i]
        moment[m] = curvature[0, 2] - stiffness * natural[m]
        if q.shape[2] == 3:
            moment[m] = np.sqrt(curvature[0, 0] ** 2 + curvature[0, 1] ** 2 + curvature[0, 2] ** 2)


@inlined
def _set_curvature(r, square, power, curvature):
    """kappa and kappa_t (2, 3) [1/m, 1/(m s)], by the arc length, stretched (power 2) or not (3).

    r: (4, 3) r_x, r_xx, and their rates in time.   square: r_x . r_x.
    """
    scale, rate = square ** (-0.5 * power), 0.0
    for i in range(3):
        rate += power * r[0, i] * r[2, i] / square
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turn = r[2, j] * r[1, k] - r[2, k] * r[1, j] + r[0, j] * r[3, k] - r[0, k] * r[3, j]
        curvature[0, i] = scale * (r[0, j] * r[1, k] - r[0, k] * r[1, j])
        curvature[1, i] = scale * turn - rate * curvature[0, i]


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
    return 2.0 * length + (share[1:] + share[:-1]) / cable.element_lengths


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
