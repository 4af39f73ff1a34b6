"""The section force is the one that does the work of bending and length constraints, and balances momentum.

Both determine it: virtual displacements of an element that turn no node give its mean, weighted with
6 xi (1 - xi), and n_x = rho_A r_tt - f says how it varies. States and multipliers are random.
"""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.attached import Drag, PointMass
from exudyn_inext.cable.attached_forces import drag_rate
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.section_forces import SectionPoints, SolvedState, multiplier_tension, section_forces
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    arc,
    bending_force,
    damping_force,
    drag_density,
    elements_of,
    hermite,
    random_state,
    slope_gram_matrix,
    straight_cable,
    with_section,
)

pytestmark = pytest.mark.kernel

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)
both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)

GRAVITY = np.array([0.7, -9.81, 1.3])
LAW = Drag(0.7, 0.2, (0.5, -1.0, 0.3))
WITHIN = 0.37  # abscissa of a point mass in its element


def moving(dim, measure=MEASURES[0], **section):
    """Random cable of four unequal elements in random motion, which no solve has made consistent."""
    state = with_section(random_state(31, 4, dim, measure), **section)
    rng = np.random.default_rng(32)
    a, multiplier = rng.standard_normal(state.q.shape), rng.standard_normal(4)
    return state.cable, SolvedState(state.q, state.v, a, multiplier)


def carrying(cable, drag=True, masses=True):
    """The same cable with a mass in its second element and on its third node, and in a flow."""
    ends = np.cumsum(cable.element_lengths)
    points = (PointMass(ends[0] + WITHIN * cable.element_lengths[1], 0.9), PointMass(ends[1], 1.7))
    law = replace(LAW, flow=LAW.flow[: cable.dimension]) if drag else None
    return replace(cable, point_masses=points if masses else (), drag=law)


def found_at(cable, state, arc_length):
    """Section forces of the package under gravity, and their sum N t + Q as (m, dim)."""
    density = cable.section.mass_per_length * GRAVITY[: cable.dimension]
    forces = section_forces(SectionPoints(cable, np.asarray(arc_length)), build_chain(cable), state, density)
    tangent = slopes(cable, state.q, arc_length, 1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    return forces, forces.tension[:, None] * tangent + forces.shear_force


def slopes(cable, x, arc_length, derivative):
    """(m, dim) derivative of the curve with nodal values x at arc lengths."""
    starts = np.append(0.0, np.cumsum(cable.element_lengths))
    rows = []
    for s in arc_length:
        k = min(np.searchsorted(starts[1:], s - 1e-9), cable.number_of_elements - 1)
        shapes = [p.deriv(derivative) if derivative else p for p in hermite(cable.element_lengths[k])]
        rows.append(
            sum(p(s - starts[k]) * y for p, y in zip(shapes, x[k : k + 2].reshape(4, -1), strict=True))
        )
    return np.array(rows)


def gauss(start, end, number=12):
    x, weight = np.polynomial.legendre.leggauss(number)
    return 0.5 * (start + end) + 0.5 * (end - start) * x, 0.5 * (end - start) * weight


@both_measures
@both_dimensions
@pytest.mark.parametrize("section", [{}, {"bending_damping": 0.6}, {"natural_curvature": 0.8}], ids=str)
def test_weighted_mean_is_what_works_on_the_chord(measure, dim, section):
    if dim == 3 and "natural_curvature" in section:
        pytest.skip("planar cables only")
    cable, state = moving(dim, measure, **section)
    start = 0.0
    for k, length, nodal in elements_of(cable, state.q):
        alone = replace(cable, element_lengths=np.array([length]), fixed=cable.fixed[k : k + 2])
        alone = replace(alone, reference=cable.reference[k : k + 2], length_constraints=1)
        q, v = state.q[k : k + 2], state.v[k : k + 2]
        expected = -(bending_force(alone, q) + damping_force(alone, q, v))[1, 0]
        expected += state.multiplier[k] * 2.0 * (slope_gram_matrix(length) @ nodal)[2]
        x, weight = gauss(start, start + length)
        xi = (x - start) / length
        found = (weight * 6.0 * xi * (1.0 - xi) / length) @ found_at(cable, state, x)[1]
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)
        start += length


@both_dimensions
@pytest.mark.parametrize("loads", ["none", "masses", "drag", "both"])
def test_difference_along_an_element_balances_momentum(dim, loads):
    """Mass times acceleration less gravity, less the drag, and a jump at each point mass within."""
    cable, state = moving(dim)
    cable = carrying(cable, drag=loads in ("drag", "both"), masses=loads in ("masses", "both"))
    g, start = GRAVITY[:dim], 0.0
    for length in cable.element_lengths:
        points = start + length * np.array([1e-6, 0.2, 0.5, 0.9, 1.0])
        force = found_at(cable, state, points)[1]
        for row in range(1, len(points)):
            x, weight = gauss(points[0], points[row])
            expected = cable.section.mass_per_length * weight @ (slopes(cable, state.a, x, 0) - g)
            if cable.drag is not None:
                # to the accuracy of the package's four points
                x, weight = gauss(start, points[row], 4)
                r_x, speed = slopes(cable, state.q, x, 1), slopes(cable, state.v, x, 0)
                expected -= weight @ drag_density(cable, r_x, speed)
            mass = cable.point_masses[0].arc_length if cable.point_masses else np.inf
            if points[0] < mass < points[row]:
                expected += 0.9 * (slopes(cable, state.a, [mass], 0)[0] - g)
            np.testing.assert_allclose(force[row] - force[0], expected, rtol=1e-5, atol=1e-4)
        start += length


@both_dimensions
def test_masses_and_drag_leave_the_weighted_mean(dim):
    """They act on the nodes by their own forces, so the mean is still that of bending and constraints."""
    bare, state = moving(dim)
    start = 0.0
    for length in bare.element_lengths:
        for drag, masses in ((True, False), (False, True)):
            cable, means = carrying(bare, drag, masses), []
            for of in (bare, cable):
                inner = start + WITHIN * length
                parts = [gauss(start, inner, 6), gauss(inner, start + length, 6)]
                x, weight = (np.concatenate(column) for column in zip(*parts, strict=True))
                xi = (x - start) / length
                means.append((weight * 6.0 * xi * (1.0 - xi) / length) @ found_at(of, state, x)[1])
            # the package's mean of the drag is that of its four points
            np.testing.assert_allclose(
                means[1], means[0], rtol=1e-3 if drag else 1e-11, atol=1e-3 if drag else 1e-11
            )
        start += length


@both_dimensions
def test_tension_is_along_the_cable_and_shear_force_across(dim):
    cable, state = moving(dim)
    points = np.linspace(0.0, cable.length, 23)
    forces, _ = found_at(cable, state, points)
    tangent = slopes(cable, state.q, points, 1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    np.testing.assert_allclose((tangent * forces.shear_force).sum(axis=1), 0.0, atol=1e-12)
    assert np.abs(forces.shear_force).max() > 0.1
    np.testing.assert_allclose(forces.position, slopes(cable, state.q, points, 0), atol=1e-12)
    np.testing.assert_array_equal(forces.arc_length, points)


@both_dimensions
def test_forces_at_a_node_are_those_of_the_element_before_it(dim):
    cable, state = moving(dim)
    node = np.cumsum(cable.element_lengths)[1]
    before, at, behind = found_at(cable, state, node + np.array([-1e-9, 0.0, 1e-9]))[1]
    np.testing.assert_allclose(at, before, atol=1e-6)
    assert np.abs(behind - before).max() > 0.1


@pytest.mark.parametrize("damping", [0.0, 0.7])
@both_dimensions
def test_bending_moment_is_that_of_the_curvature_and_its_rate(dim, damping):
    """Curvature from the angle between tangents nearby; positive in the plane where it turns left."""
    natural = 0.8 if dim == 2 else 0.0
    cable, state = moving(dim, natural_curvature=natural, bending_damping=damping)
    points, step = np.array([0.3, 1.7, 2.9]), 1e-5

    def curvature(time):
        """(m, 3) vector at a time [s]."""
        q = state.q + time * state.v
        r_x = [np.pad(slopes(cable, q, points + s, 1), ((0, 0), (0, 3 - dim))) for s in (-step, 0.0, step)]
        behind, here, ahead = (np.linalg.norm(one, axis=1)[:, None] for one in r_x)
        return np.cross(r_x[0], r_x[2]) / behind / ahead / (2.0 * step * here)

    rate = (curvature(1e-4) - curvature(-1e-4)) / 2e-4
    expected = cable.section.bending_stiffness * curvature(0.0) + damping * rate
    if dim == 2:
        expected = expected[:, 2] - cable.section.bending_stiffness * natural
    else:
        expected = np.linalg.norm(expected, axis=1)
    forces, _ = found_at(cable, state, points)
    np.testing.assert_allclose(forces.bending_moment, expected, rtol=1e-5)


# ------------------------------------------------------------------- tension from multipliers


@pytest.mark.parametrize("closed", [False, True])
def test_a_nodal_multiplier_is_shared_by_the_elements_beside_its_node(closed):
    """Twice the multiplier in all, over the lengths on either side; the ends of a ring are one node."""
    lengths = np.array([1.0, 2.0, 4.0])
    cable = replace(straight_cable(3, 2), element_lengths=lengths, closed=closed)
    cable = replace(cable, section=replace(cable.section, bending_stiffness=1e-30))
    at_rest = np.zeros(cable.reference.shape)
    first, last = [1.0, 0.0, 0.25], [1.0, 0.0, 0.25]
    shares = {
        0: first if closed else [2.0, 0.0, 0.0],
        1: [1.0, 0.5, 0.0],
        2: [0.0, 0.5, 0.25],
        3: last if closed else [0.0, 0.0, 0.5],
    }
    for node, expected in shares.items():
        nodal = np.eye(4)[node]
        found = multiplier_tension(cable, cable.reference, at_rest, nodal, np.zeros(3))
        np.testing.assert_allclose(found, expected, atol=1e-12)
        np.testing.assert_array_equal(nodal, np.eye(4)[node])
    multiplier = np.array([1.0, -2.0, 3.0])
    of_length = multiplier_tension(cable, cable.reference, at_rest, np.zeros(4), multiplier)
    np.testing.assert_allclose(of_length, [2.0, -4.0, 6.0], atol=1e-12)


@both_measures
@pytest.mark.parametrize("natural", [0.0, 0.7])
def test_bending_of_an_arc_counts_with_its_curvature_squared(measure, natural):
    """EI (kappa^2 - 2 kappa_0 kappa), the first term twice for `product`, and 2 D kappa kappa_t."""
    radius, stiffness, number, damping = 2.0, 3.0, 8, 0.4
    cable = straight_cable(number, 2, length=1.5, measure=measure)
    laws = {"bending_stiffness": stiffness, "natural_curvature": natural, "bending_damping": damping}
    cable = replace(cable, section=replace(cable.section, **laws))
    q = arc(1.5, number, radius)
    v = (arc(1.5, number, radius + 1e-4) - arc(1.5, number, radius - 1e-4)) / 2e-4
    found = multiplier_tension(cable, q, v, np.zeros(number + 1), np.zeros(number))
    twice = 2.0 if measure is MEASURES[1] else 1.0
    expected = stiffness * (twice / radius**2 - 2.0 * natural / radius) - 2.0 * damping / radius**3
    np.testing.assert_allclose(found, expected, rtol=1e-3)


# ------------------------------------------------------------------- rate of the drag


def drag_rate_of(normal, tangential, gravity, speed, mass=2.0):
    cable = straight_cable(3, 2)
    law = Drag(normal, tangential, (0.5, 0.0))
    cable = replace(cable, section=replace(cable.section, mass_per_length=mass), drag=law)
    v = np.zeros(cable.reference.shape)
    v[2, 0] = [0.5, speed]  # against the flow; all other nodes move at 0.5 m/s against it
    return drag_rate(cable, np.array(gravity), v)


def test_rate_of_the_drag_is_that_of_the_faster_of_motion_and_fall():
    """d/dv of c v^2 over the mass, with the larger coefficient; a fall ends at rho_A g = c v^2."""
    assert drag_rate(straight_cable(3, 2), np.array([0.0, -9.81]), np.ones((4, 2, 2))) == 0.0
    assert drag_rate_of(0.7, 0.2, [0.0, 0.0], 6.0) == pytest.approx(2 * 0.7 * 6.0 / 2.0)
    assert drag_rate_of(0.2, 0.7, [0.0, 0.0], 6.0) == pytest.approx(2 * 0.7 * 6.0 / 2.0)
    assert drag_rate_of(0.7, 0.2, [0.0, -9.0], 0.0) == pytest.approx(2 * 0.7 * np.sqrt(18.0 / 0.7) / 2.0)
    assert drag_rate_of(0.0, 0.7, [0.0, -9.0], 0.0) == pytest.approx(2 * 0.7 * 0.5 / 2.0)
