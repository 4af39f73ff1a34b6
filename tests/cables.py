"""Random cables, and what the tests know about them without the package.

Shape functions come from their interpolation conditions, element matrices are the textbook's closed
forms, forces and tangents come from quadrature with 12 points, the saddle-point system is dense.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from scipy.linalg import block_diag, eigh, null_space

from exudyn_inext.cable.cable import Cable, CurvatureMeasure, Section
from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.link import Motion, rest
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.cable.links import all_links, motions_of
from exudyn_inext.constraints import constraints_of_cable
from exudyn_inext.constraints.distance import hanger, rod
from exudyn_inext.constraints.prescribed_motion import prescribed
from exudyn_inext.system import index_reduced_rates

MEASURES = list(CurvatureMeasure)
DIMENSIONS = (2, 3)

# (share of the length, position held, slope held)
SUPPORTS = {
    "free": [],
    "pinned": [(0.0, True, False)],
    "clamped": [(0.0, True, True)],
    "both ends pinned": [(0.0, True, False), (1.0, True, False)],
    "clamped and pinned": [(0.0, True, True), (1.0, True, False)],
    "both ends clamped": [(0.0, True, True), (1.0, True, True)],
    "pinned within": [(0.5, True, False)],
    "clamped within": [(0.5, True, True)],
    "pinned and guided": [(0.0, True, False), (1.0, False, True)],
}


@dataclass(frozen=True, eq=False)
class State:
    """A cable, its coordinates and velocities, and the external force, each (n, 2, dim), at a time."""

    cable: Cable
    q: Any
    v: Any
    external: Any
    time: float = 0.0

    @property
    def inputs(self):
        """(n_external,) what a system takes: the force, then the motions of the anchors."""
        motions = [motion.at(self.time).ravel() for motion in motions_of(all_links(self.cable))]
        return np.concatenate([self.external.ravel(), *motions])


def fixed_nodes(number, supports):
    """(n, 2) flags of one of the `SUPPORTS`."""
    fixed = np.zeros((number + 1, 2), dtype=bool)
    for share, position, slope in SUPPORTS[supports]:
        fixed[round(share * number)] |= (position, slope)
    return fixed


def straight_cable(number, dim, supports="free", length=None, **changes):
    """Straight cable along x with unit section; `changes` replaces fields of the Cable."""
    length = float(number) if length is None else length
    q = np.zeros((number + 1, 2, dim))
    q[:, 0, 0] = np.linspace(0.0, length, number + 1)
    q[:, 1, 0] = 1.0
    cable = Cable(
        reference=q,
        element_lengths=np.full(number, length / number),
        section=Section(1.0, 1.0),
        measure=CurvatureMeasure.SECOND_DERIVATIVE,
        length_constraints=number,
        fixed=fixed_nodes(number, supports),
    )
    return replace(cable, **changes)


def arc(length, number, radius, dim=2):
    """(n, 2, dim) nodes of a circular arc of that length, turning left; right if the radius is negative."""
    s = np.linspace(0.0, length, number + 1) / radius
    q = np.zeros((number + 1, 2, dim))
    q[:, 0, 0], q[:, 0, 1] = radius * np.sin(s), radius * (1 - np.cos(s))
    q[:, 1, 0], q[:, 1, 1] = np.cos(s), np.sin(s)
    return q


def opening_arc(length, number, radius, dim=2):
    """(n, 2, dim) derivative of `arc` with respect to its radius."""
    step = 1e-5
    return (arc(length, number, radius + step, dim) - arc(length, number, radius - step, dim)) / (2 * step)


def planar_pendulum(number, dim=2, **changes):
    """The pendulum of the paper's section 4.2, straight along x, and its gravity."""
    area = np.pi * 2e-3**2
    section = Section(2766.76 * area, 6.895e9 * area * 2e-3**2 / 4)
    cable = straight_cable(number, dim, "pinned", 1.8, section=section, **changes)
    return cable, np.array([0.0, -9.81, 0.0][:dim])


def random_walk(rng, lengths, dim, turning=0.8):
    """(n, 2, dim) slack configuration: nearly unit slopes that turn from node to node."""
    slopes = [np.eye(dim)[0]]
    for _ in lengths:
        slope = slopes[-1] + turning * rng.uniform(-1, 1, dim)
        slopes.append(slope / np.linalg.norm(slope))
    slopes = np.array(slopes)
    chords = 0.5 * (slopes[1:] + slopes[:-1]) * lengths[:, None]
    positions = np.vstack([np.zeros(dim), np.cumsum(chords, axis=0)])
    return np.stack([positions, slopes * rng.uniform(0.97, 1.03, (len(slopes), 1))], axis=1)


def random_state(seed, number, dim, measure, n_bar=None, supports="free"):
    """A random cable with unequal elements that violates its constraints a little, and moves.

    Coordinates that a support holds are at their reference values and at rest.
    """
    rng = np.random.default_rng([seed, number, dim])
    lengths = rng.uniform(0.8, 1.25, number)
    q = random_walk(rng, lengths, dim)
    held = np.repeat(fixed_nodes(number, supports)[:, :, None], dim, axis=2)
    cable = Cable(
        reference=np.where(held, q, q + 0.02 * rng.standard_normal(q.shape)),
        element_lengths=lengths,
        section=Section(rng.uniform(0.5, 2.0), rng.uniform(0.5, 2.0)),
        measure=measure,
        length_constraints=number if n_bar is None else n_bar,
        fixed=fixed_nodes(number, supports),
    )
    v = np.where(held, 0.0, rng.standard_normal(q.shape))
    return State(cable, q, v, rng.standard_normal(q.shape))


LINKS = {
    "closed": [],
    "closed and pinned": [],
    "hanger": ["hanger"],
    "rod": ["rod"],
    "moving node": ["motion"],
    "moving hanger, rod and node": ["hanger", "rod", "motion"],
    "closed with a moving hanger and a rod": ["hanger", "rod"],
}


def shaken(point):
    """A motion around a point (dim,) with derivatives of its own."""
    dim = len(point)
    size, phase = np.array([0.3, 0.2, 0.1])[:dim], np.arange(dim)

    def at(t):
        angle = 2.0 * t + phase
        waves = [np.sin(angle) - np.sin(phase), 2.0 * np.cos(angle), -4.0 * np.sin(angle)]
        return np.array([point, np.zeros(dim), np.zeros(dim)]) + size * np.array(waves)

    return Motion(at)


def some_links(kinds, q):
    """Links of the given kinds that q (n, 2, dim) fulfils at t = 0."""
    number, dim = len(q) - 1, q.shape[2]
    found = []
    if "hanger" in kinds:
        above = q[number // 2, 0] + np.array([0.1, 0.5, 0.3])[:dim]
        found.append(hanger(number // 2, shaken(above), np.linalg.norm(above - q[number // 2, 0])))
    if "rod" in kinds:
        ends = (0, number - 1)
        found.append(rod(ends, dim, np.linalg.norm(q[ends[0], 0] - q[ends[1], 0])))
    if "motion" in kinds:
        found += prescribed(number, shaken(q[number, 0]), range(dim))
    return tuple(found)


def with_section(state, **changes):
    """The same state; `changes` replaces constants of the section."""
    return replace(state, cable=replace(state.cable, section=replace(state.cable.section, **changes)))


def linked_state(seed, number, dim, measure, links, n_bar=None):
    """As `random_state`, with one of the `LINKS`, whose constraints are violated a little, too."""
    state = random_state(seed, number, dim, measure, n_bar, "pinned" if "pinned" in links else "free")
    q, v = state.q, state.v
    closed = "closed" in links
    if closed:
        for array in (q, v):
            array[-1] = array[0]
    fixed = state.cable.fixed.copy()
    fixed[-1] |= closed & fixed[0]
    reference = np.where(fixed[:, :, None], q, state.cable.reference)
    reference[-1] = reference[0] if closed else reference[-1]
    links = some_links(LINKS[links], q + 0.01 * v)
    cable = replace(state.cable, closed=closed, reference=reference, fixed=fixed, links=links)
    return replace(state, cable=cable, time=0.1)


def with_resting_anchors(state):
    """The same state, its anchors held where they are."""
    links = [replace(link, anchor=rest(link.anchor.at(state.time)[0])) for link in state.cable.links]
    return replace(state, cable=replace(state.cable, links=tuple(links)))


def structured_rates(state, zeta, mass_scaling=0.0):
    """Acceleration and projected rate (n_dof,) of the package, and the chain with its multipliers."""
    system = cable_system(state.cable, zeta, ImplicitBending(mass_scaling))
    acceleration, rate = np.zeros(state.q.size), np.zeros(state.q.size)
    index_reduced_rates(system, state.inputs, state.q.ravel(), state.v.ravel(), acceleration, rate)
    return acceleration, rate, system.chain


# ------------------------------------------------------------------- formulas of one element


@cache
def hermite(length):
    """Four cubic polynomials in x from the interpolation conditions at 0 and `length`."""
    powers = np.arange(4)
    value = [0.0**powers, length**powers]
    slope = [powers * 0.0 ** np.maximum(powers - 1, 0), powers * length ** np.maximum(powers - 1, 0.0)]
    conditions = np.array([value[0], slope[0], value[1], slope[1]], dtype=float)
    return [np.polynomial.Polynomial(row) for row in np.linalg.inv(conditions).T]


def fine_quadrature(length):
    """Points and weights of 12 Gauss points on (0, length)."""
    x, weight = np.polynomial.legendre.leggauss(12)
    return 0.5 * length * (x + 1), 0.5 * length * weight


@cache
def sampled(length, derivative):
    """(4, g) derivative of the shape functions at the fine quadrature points, and the weights."""
    x, weight = fine_quadrature(length)
    return np.array([p.deriv(derivative)(x) if derivative else p(x) for p in hermite(length)]), weight


def mass_matrix(length):
    """Textbook closed form, per unit density."""
    x = length
    rows = [
        [156, 22 * x, 54, -13 * x],
        [22 * x, 4 * x**2, 13 * x, -3 * x**2],
        [54, 13 * x, 156, -22 * x],
        [-13 * x, -3 * x**2, -22 * x, 4 * x**2],
    ]
    return x / 420 * np.array(rows)


def stiffness_matrix(length):
    """Textbook closed form, per unit EI."""
    x = length
    rows = [
        [12, 6 * x, -12, 6 * x],
        [6 * x, 4 * x**2, -6 * x, 2 * x**2],
        [-12, -6 * x, 12, -6 * x],
        [6 * x, 2 * x**2, -6 * x, 4 * x**2],
    ]
    return np.array(rows) / x**3


def slope_gram_matrix(length):
    """Textbook closed form of the geometric stiffness matrix at unit tension."""
    x = length
    rows = [
        [36, 3 * x, -36, 3 * x],
        [3 * x, 4 * x**2, -3 * x, -(x**2)],
        [-36, -3 * x, 36, -3 * x],
        [3 * x, -(x**2), -3 * x, 4 * x**2],
    ]
    return np.array(rows) / (30 * x)


# ------------------------------------------------------------------- the cable as a dense system


def elements_of(cable, q):
    """Length, nodal coordinates (4, dim) and first node of each element."""
    for k, length in enumerate(cable.element_lengths):
        yield k, length, np.concatenate([q[k], q[k + 1]])


def curvature_terms(measure, length, nodal):
    """r_x, r_xx (g, dim) and the factor of |r_xx|^2 in kappa^2 (g,), S_x, S_xx, weights."""
    s_x, weight = sampled(length, 1)
    s_xx, _ = sampled(length, 2)
    r_x, r_xx = s_x.T @ nodal, s_xx.T @ nodal
    product = measure is CurvatureMeasure.PRODUCT
    stretch = (r_x * r_x).sum(axis=1) if product else np.ones(len(weight))
    return r_x, r_xx, stretch, s_x, s_xx, weight, float(product)


def bending_energy(cable, q):
    """1/2 EI int kappa^2 - 2 kappa_0 r_x x r_xx dx; works with complex coordinates."""
    total = 0.0
    for _, length, nodal in elements_of(cable, q):
        r_x, r_xx, stretch, _, _, weight, _ = curvature_terms(cable.measure, length, nodal)
        square = stretch * (r_xx**2).sum(axis=1)
        if natural := cable.section.natural_curvature:
            square = square - 2 * natural * (r_x[:, 0] * r_xx[:, 1] - r_x[:, 1] * r_xx[:, 0])
        total += 0.5 * cable.section.bending_stiffness * weight @ square
    return total


def bending_force(cable, q):
    """(n, 2, dim) -dU/dq by quadrature of the derivative of the integrand."""
    force = np.zeros(q.shape)
    for k, length, nodal in elements_of(cable, q):
        r_x, r_xx, stretch, s_x, s_xx, weight, product = curvature_terms(cable.measure, length, nodal)
        square = product * (r_xx**2).sum(axis=1)
        integral = np.einsum("g,ag,gi->ai", weight * stretch, s_xx, r_xx)
        integral += np.einsum("g,ag,gi->ai", weight * square, s_x, r_x)
        if natural := cable.section.natural_curvature:
            turned = np.einsum("ag,gi->agi", s_x, r_xx) - np.einsum("ag,gi->agi", s_xx, r_x)
            integral -= natural * np.einsum("g,agi->ai", weight, turned[:, :, ::-1]) * [1.0, -1.0]
        force[k : k + 2] -= cable.section.bending_stiffness * integral.reshape(2, 2, -1)
    return force


def bending_tangent(cable, q):
    """(n_dof, n_dof) second derivative of the bending energy."""
    dim = cable.dimension
    tangent = np.zeros((q.size, q.size))
    for k, length, nodal in elements_of(cable, q):
        r_x, r_xx, stretch, s_x, s_xx, weight, product = curvature_terms(cable.measure, length, nodal)
        square = product * (r_xx**2).sum(axis=1)
        same = np.einsum("g,ag,bg->ab", weight * stretch, s_xx, s_xx)
        same += np.einsum("g,ag,bg->ab", weight * square, s_x, s_x)
        mixed = np.einsum("g,ag,gi,bg,gj->aibj", 2 * product * weight, s_x, r_x, s_xx, r_xx)
        block = np.einsum("ab,ij->aibj", same, np.eye(dim)) + mixed + mixed.transpose(2, 3, 0, 1)
        if natural := cable.section.natural_curvature:
            half = np.einsum("g,ag,bg->ab", weight, s_x, s_xx)
            block -= natural * np.einsum("ab,ij->aibj", half - half.T, [[0.0, 1.0], [-1.0, 0.0]])
        at = slice(2 * dim * k, 2 * dim * (k + 2))
        tangent[at, at] += cable.section.bending_stiffness * block.reshape(4 * dim, 4 * dim)
    return tangent


def curvature_rates(cable, q, v):
    """Rate of r_x x r_xx (points, 3) along v by a complex step, and weights; of all elements."""
    rates, weights = [], []
    for (_, length, nodal), (_, _, speed) in zip(elements_of(cable, q), elements_of(cable, v), strict=True):
        x, weight = np.polynomial.legendre.leggauss(12)
        shapes = [np.array([p.deriv(d)(0.5 * length * (x + 1)) for p in hermite(length)]) for d in (1, 2)]
        r_x, r_xx = (in_space(shape.T @ (nodal + 1e-30j * speed)) for shape in shapes)
        rates.append(np.cross(r_x, r_xx).imag / 1e-30)
        weights.append(0.5 * length * weight)
    return np.concatenate(rates), np.concatenate(weights)


def in_space(vectors):
    """(m, 2 or 3) -> (m, 3)."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def damping_force(cable, q, v):
    """(n, 2, dim) -D int kappa_t . d(kappa)/dq dx; zero without damping."""
    force = np.zeros(q.shape)
    if cable.section.bending_damping:
        rate, weight = curvature_rates(cable, q, v)
        for unit, place in zip(np.eye(q.size), np.ndindex(q.shape), strict=True):
            gradient, _ = curvature_rates(cable, q, unit.reshape(q.shape))
            force[place] = -cable.section.bending_damping * weight @ (rate * gradient).sum(axis=1)
    return force


def dense_form(cable, form):
    """(n_dof, n_dof) matrix of an element form (4, 4), the same in every direction."""
    n = 2 * (cable.number_of_elements + 1)
    total = np.zeros((n, n))
    for k, length in enumerate(cable.element_lengths):
        total[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += form(length)
    return np.kron(total, np.eye(cable.dimension))


def dense_mass(cable, mass_scaling=0.0):
    """(n_dof, n_dof) M + theta h^2 K without regard to supports."""
    scaled = mass_scaling * cable.section.bending_stiffness * dense_form(cable, stiffness_matrix)
    return cable.section.mass_per_length * dense_form(cable, mass_matrix) + scaled + point_masses(cable)


def weights_at(cable, point):
    """(2 n,) share of each nodal position and slope in the position at an arc length."""
    weights, start = np.zeros(2 * (cable.number_of_elements + 1)), 0.0
    for k, length in enumerate(cable.element_lengths):
        if point <= start + length + 1e-12:
            weights[2 * k : 2 * k + 4] = [p(point - start) for p in hermite(length)]
            break
        start += length
    return weights


def point_masses(cable):
    """(n_dof, n_dof) mass matrix of the point masses."""
    rows = [(weights_at(cable, point.arc_length), point.mass) for point in cable.point_masses]
    total = sum((mass * np.outer(w, w) for w, mass in rows), np.zeros((2 * len(cable.reference),) * 2))
    return np.kron(total, np.eye(cable.dimension))


def drag_density(cable, r_x, speed):
    """(g, dim) drag per length of the reference, from a projector on the normal plane."""
    relative = speed - np.array(cable.drag.flow)
    tangent = r_x / np.linalg.norm(r_x, axis=1)[:, None]
    normal = np.eye(cable.dimension) - np.einsum("gi,gj->gij", tangent, tangent)
    across = np.einsum("gij,gj->gi", normal, relative)
    along = relative - across
    return -np.linalg.norm(r_x, axis=1)[:, None] * (
        cable.drag.normal * np.linalg.norm(across, axis=1)[:, None] * across
        + cable.drag.tangential * np.linalg.norm(along, axis=1)[:, None] * along
    )


def drag_force(cable, q, v):
    """(n, 2, dim) int S f dx at the package's Gauss points: the integrand is no polynomial."""
    force = np.zeros(q.shape)
    if cable.drag is None:
        return force
    for (k, length, nodal), (_, _, speed) in zip(elements_of(cable, q), elements_of(cable, v), strict=True):
        x, weight = np.polynomial.legendre.leggauss(4)
        x, weight = 0.5 * length * (x + 1), 0.5 * length * weight
        s, s_x = (np.array([p.deriv(d)(x) if d else p(x) for p in hermite(length)]) for d in (0, 1))
        density = drag_density(cable, s_x.T @ nodal, s.T @ speed)
        force[k : k + 2] += np.einsum("ag,g,gi->ai", s, weight, density).reshape(2, 2, -1)
    return force


def kinetic_energy(cable, v):
    """1/2 v M v."""
    return 0.5 * v.ravel() @ dense_mass(cable) @ v.ravel()


@dataclass(frozen=True, eq=False)
class DenseConstraints:
    """c, Jacobian and gamma of all constraints, and the slices of each kind."""

    value: Any
    rate: Any
    jacobian: Any
    gamma: Any
    rows: dict[str, slice]


LINKS_LAST = ["distance", "prescribed motion", "coordinate"]  # in the order of `cable.links`


def dense_constraints(cable, q, v, t=0.0):
    """All constraints of the cable, links last."""
    found = constraints_of_cable(cable)
    names = sorted(found.rows, key=lambda name: LINKS_LAST.index(name) if name in LINKS_LAST else -1)
    order = np.concatenate([np.zeros(0, int), *(np.arange(found.number)[found.rows[n]] for n in names)])
    ends = np.cumsum([0, *(len(found.rows[name]) for name in names)])
    return DenseConstraints(
        value=found.value(q, t)[order],
        jacobian=found.jacobian(q, t).toarray()[order],
        rate=found.rate(q, v, t)[order],
        gamma=found.gamma(q, v, t)[order],
        rows={name: slice(a, b) for name, a, b in zip(names, ends, ends[1:], strict=False)},
    )


def refined_solve(matrix, right):
    """Dense solve, equilibrated, with residuals in extended precision: accurate to round-off."""
    scale = 1.0 / np.sqrt(np.abs(matrix).max(axis=1))
    scaled = matrix * scale[:, None] * scale
    inverse = np.linalg.inv(scaled)
    goal = scale[:, None] * right
    x = np.zeros(right.shape)
    for _ in range(4):
        residual = goal - scaled.astype(np.longdouble) @ x.astype(np.longdouble)
        x = x + inverse @ residual.astype(float)
    return scale[:, None] * x


def dense_rates(state, zeta, mass_scaling=0.0):
    """Eq. (29) solved densely: acceleration, projected rate, lam and mu, and the constraints."""
    cable, q, v = state.cable, state.q, state.v
    c = dense_constraints(cable, q, v, state.time)
    mass, speed = dense_mass(cable, mass_scaling), v.ravel()
    zero = np.zeros((len(c.value), len(c.value)))
    matrix = np.block([[mass, c.jacobian.T], [c.jacobian, zero]])
    force = state.external + bending_force(cable, q) + damping_force(cable, q, v)
    force = (force + drag_force(cable, q, v)).ravel()
    right = np.stack(
        [
            np.concatenate([force, c.gamma - zeta * c.rate]),
            np.concatenate([mass @ speed, c.jacobian @ speed - c.rate - zeta * c.value]),
        ],
        axis=1,
    )
    x = refined_solve(matrix, right)
    return x[: q.size, 0], x[: q.size, 1], x[q.size :, 0], x[q.size :, 1], c


def dense_largest_frequency(state, mass_scaling=0.0):
    """w_max of small vibrations at rest on the null space of the constraints' Jacobian."""
    cable = state.cable
    _, _, lam, _, c = dense_rates(replace(state, v=np.zeros_like(state.v)), 1.0, mass_scaling)
    nodal, length = (lam[c.rows.get(name, slice(0))] for name in ("nodal inextensibility", "length"))
    nodes = np.zeros(cable.number_of_elements + 1)
    nodes[~cable.fixed[:, 1]] = nodal
    hessian = bending_tangent(cable, state.q)
    hessian += block_diag(*[np.kron(np.diag([0.0, 2 * x]), np.eye(cable.dimension)) for x in nodes])
    if len(length):
        tension = iter(length[cable.group_of_element()])
        hessian += dense_form(cable, lambda x: 2 * next(tension) * slope_gram_matrix(x))
    for link, multiplier in zip(cable.links, lam[len(lam) - len(cable.links) :], strict=True):
        weights = np.zeros((len(state.q), 2))
        weights[list(link.nodes)] = link.weights
        rank_one = np.outer(weights.ravel(), weights.ravel()) * multiplier / link.length
        hessian += np.kron(rank_one, np.eye(cable.dimension))
    free = null_space(c.jacobian, rcond=1e-9)
    reduced = [free.T @ matrix @ free for matrix in (hessian, dense_mass(cable, mass_scaling))]
    return np.sqrt(eigh(*reduced, eigvals_only=True)[-1])


def relative_error(found, expected):
    """Largest deviation over the largest expected value."""
    return np.abs(np.subtract(found, expected)).max() / np.abs(expected).max()
