"""Equilibria against closed forms: elastica, catenary, Euler's columns, and natural frequencies."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipk, ellipkinc

from exudyn_inext.cable.cable import CurvatureMeasure, Section
from exudyn_inext.cable.link import Motion, rest
from exudyn_inext.constraints.distance import hanger
from exudyn_inext.constraints.prescribed_motion import prescribed
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.statics import Potential, find_equilibrium, smallest_eigenvalue
from exudyn_inext.statics import equilibrium as search
from exudyn_inext.statics.saddle_point import factorise
from exudyn_inext.statics.small_motions import small_motions
from tests.cables import MEASURES, arc, relative_error, straight_cable

UNIT = Section(1.0, 1.0)
both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)


def equilibrium(cable, external, start=None, time=0.0, **options):
    start = cable.reference if start is None else start
    return find_equilibrium(Potential([cable], external, time), start, **options)


def end_force(cable, force):
    """(n, 2, dim) external force at the last node."""
    external = np.zeros(cable.reference.shape)
    external[-1, 0] = force
    return external


def reactions(cable, external, q):
    """Multipliers by constraint name: J^T lam is the force that the constraints have to balance."""
    potential = Potential([cable], external, 0.0)
    lam = np.linalg.lstsq(potential.jacobian(q).T.toarray(), potential.force(q), rcond=None)[0]
    return {name: lam[rows] for name, rows in potential.constraints.rows.items()}


# ------------------------------------------------------------------- elastica


def elastica_tip(load):
    """(x, y) / L of a cantilever along x under P L^2 / EI = `load` along y, by elliptic integrals.

    With the tip's angle a, m = k^2 = (1 + sin a) / 2 and sin f = 1 / (k sqrt 2):
    sqrt(load) = K(m) - F(f, m), x = sqrt(2 sin a / load), y = 1 - 2 (E(m) - E(f, m)) / sqrt(load).
    """

    def parameters(angle):
        m = 0.5 * (1.0 + np.sin(angle))
        return m, np.arcsin(np.sqrt(0.5 / m))

    def root_of_load(angle):
        m, f = parameters(angle)
        return ellipk(m) - ellipkinc(f, m)

    angle = brentq(lambda a: root_of_load(a) - np.sqrt(load), 1e-6, 0.5 * np.pi - 1e-9, xtol=1e-15)
    m, f = parameters(angle)
    bow = ellipeinc(0.5 * np.pi, m) - ellipeinc(f, m)
    return np.array([np.sqrt(2.0 * np.sin(angle) / load), 1.0 - 2.0 * bow / np.sqrt(load)])


def test_elastica_of_the_tests_is_the_tabulated_one():
    """Tip deflections of Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145."""
    table = {1: (0.05643, 0.30172), 2: (0.16064, 0.49346), 5: (0.38763, 0.71379), 10: (0.55500, 0.81061)}
    for load, (shortening, deflection) in table.items():
        np.testing.assert_allclose(elastica_tip(load), [1.0 - shortening, deflection], atol=1e-5)


@both_measures
@pytest.mark.parametrize("load", [1, 2, 5, 10])
def test_tip_of_the_elastica_converges_with_order_four(measure, load, known_answer):
    errors = []
    for number in (4, 8, 16):
        cable = straight_cable(number, 2, "clamped", 1.0, section=UNIT, measure=measure)
        found = equilibrium(cable, end_force(cable, [0.0, load]))
        assert found.converged
        errors.append(np.abs(found.q[-1, 0] - elastica_tip(load)).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 4.0, atol=0.2)
    assert errors[-1] < 2e-6 * load
    known_answer(f"elastica: tip under {load} EI/L^2, N = 16, {measure.value}", errors[-1], orders.mean())


def test_elastica_in_any_direction_of_space_is_the_planar_one():
    rotation, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    planar, spatial = (straight_cable(8, dim, "clamped", 1.0, section=UNIT) for dim in (2, 3))
    flat = equilibrium(planar, end_force(planar, [0.0, 5.0]))
    turned = replace(spatial, reference=spatial.reference @ rotation.T)
    found = equilibrium(turned, end_force(turned, rotation @ [0.0, 5.0, 0.0]))
    expected = np.pad(flat.q, ((0, 0), (0, 0), (0, 1))) @ rotation.T
    np.testing.assert_allclose(found.q, expected, atol=1e-9)
    assert found.converged
    assert found.smallest_eigenvalue < flat.smallest_eigenvalue * (1.0 + 1e-9)


def test_clamped_cable_with_natural_curvature_rests_as_an_arc():
    for natural in (1.5, -3.0):
        cable = straight_cable(16, 2, "clamped", 1.0, section=Section(1.0, 1.0, natural))
        found = equilibrium(cable, np.zeros(cable.reference.shape))
        assert found.converged
        np.testing.assert_allclose(found.q[:, 0], arc(1.0, 16, 1.0 / natural)[:, 0], atol=1e-5)


# ------------------------------------------------------------------- catenary

SPAN, LENGTH, WEIGHT = 1.2, 1.5, 9.81
GRAVITY = np.array([0.0, -WEIGHT])


def catenary_parameter():
    """c of y = c cosh(x / c) between two points at one height."""
    return brentq(lambda c: 2.0 * c * np.sinh(0.5 * SPAN / c) - LENGTH, 0.1, 10.0, xtol=1e-15)


def catenary(number):
    """(n, 2, 2) nodes at equal arc lengths, from the support at the origin."""
    c = catenary_parameter()
    s = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, number + 1) / c
    q = np.zeros((number + 1, 2, 2))
    q[:, 0, 0] = 0.5 * SPAN + c * np.arcsinh(s)
    q[:, 0, 1] = c * (np.hypot(1.0, s) - np.hypot(1.0, 0.5 * LENGTH / c))
    q[:, 1] = np.stack([np.ones(number + 1), s], axis=1) / np.hypot(1.0, s)[:, None]
    return q


def hanging_cable(number, stiffness):
    """Cable of the length `LENGTH` and rho_A = 1 between two pins, and its weight."""
    cable = straight_cable(number, 2, "both ends pinned", LENGTH, section=Section(1.0, stiffness))
    cable = replace(cable, reference=catenary(number), straight_lengths=True)
    return cable, gravity_force(cable, GRAVITY)


def test_shape_and_end_tension_converge_to_the_catenary_as_the_stiffness_falls(known_answer):
    c = catenary_parameter()
    support = WEIGHT * np.array([c, 0.5 * LENGTH])
    errors = []
    for stiffness in (1e-2, 1e-3, 1e-4):
        cable, weight = hanging_cable(60, stiffness)
        found = equilibrium(cable, weight)
        assert found.converged
        pins = reactions(cable, weight, found.q)["pin"].reshape(2, 2)
        np.testing.assert_allclose(pins[:, 1], -0.5 * WEIGHT * LENGTH, rtol=1e-8)
        np.testing.assert_allclose(pins[0, 0], -pins[1, 0], rtol=1e-8)
        shape = np.abs(found.q[:, 0] - catenary(60)[:, 0]).max()
        errors.append([shape / SPAN, abs(np.linalg.norm(pins[0]) / np.linalg.norm(support) - 1.0)])
    orders = np.log10(np.divide(errors[:-1], errors[1:]))
    assert orders.min() > 0.8
    assert np.max(errors[-1]) < 1e-3
    known_answer("catenary: shape, as EI -> 0 (order in EI)", errors[-1][0], orders[:, 0].mean())
    known_answer(
        "catenary: tension at the pins, as EI -> 0 (order in EI)", errors[-1][1], orders[:, 1].mean()
    )


WAVE = [[0.2, 0.1], [0.0, 0.0]]

STARTS = {
    "taut": lambda q: np.stack([np.linspace(q[0, 0], q[-1, 0], len(q)), np.tile([1.0, 0.0], (len(q), 1))], 1),
    "inverted": lambda q: q * [1.0, -1.0],
    "slack": lambda q: q * [1.0, 0.1],
    "leaning over": lambda q: q + np.sin(np.linspace(0.0, 2.0 * np.pi, len(q)))[:, None, None] * WAVE,
    "folded": lambda q: np.roll(q, 3, axis=0),
}


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_every_start_leads_to_the_one_that_hangs(start):
    cable, weight = hanging_cable(16, 1e-3)
    hanging = equilibrium(cable, weight)
    found = equilibrium(cable, weight, start(cable.reference))
    assert found.converged
    assert found.violation < 1e-9
    np.testing.assert_allclose(found.q, hanging.q, atol=1e-8)
    assert found.q[8, 0, 1] < -0.3


def test_a_cable_that_stands_upright_falls_within_few_steps_of_few_models(monkeypatch):
    """It begins in an unstable equilibrium; softer models than the one that served last mostly do not."""
    factorisations = []

    def counted(*matrices):
        factorisations.append(1)
        return factorise(*matrices)

    monkeypatch.setattr(search, "factorise", counted)
    cable = straight_cable(12, 2, "pinned", 1.5, section=Section(0.2, 0.05))
    found = equilibrium(cable, gravity_force(cable, GRAVITY), cable.reference[..., ::-1])
    assert found.converged
    np.testing.assert_allclose(found.q[-1, 0], [0.0, -1.5], atol=1e-6)
    assert found.iterations < 15
    assert len(factorisations) < 30


def test_hanger_carries_what_the_two_spans_leave_to_it():
    """At small bending stiffness each span is a catenary; half of each span's weight is on the hanger."""
    number = 32
    cable, _ = hanging_cable(number, 1e-4)
    two = np.concatenate([cable.reference, np.add(cable.reference[1:], [[SPAN, 0.0], [0.0, 0.0]])])
    rod = hanger(number, rest(np.array([SPAN, 0.3])), 0.3)
    line = straight_cable(2 * number, 2, "both ends pinned", 2 * LENGTH, section=cable.section, links=(rod,))
    line = replace(line, reference=two, straight_lengths=True)
    weight = gravity_force(line, GRAVITY)
    found = equilibrium(line, weight)
    assert found.converged
    forces = reactions(line, weight, found.q)
    np.testing.assert_allclose(found.q[number, 0], [SPAN, 0.0], atol=1e-9)
    total = forces["pin"].reshape(2, 2).sum(axis=0) - [0.0, forces["distance"][0]]
    np.testing.assert_allclose(total, [0.0, -2 * WEIGHT * LENGTH], atol=1e-7)
    assert abs(forces["distance"][0]) == pytest.approx(WEIGHT * LENGTH, rel=5e-3)


def test_moving_support_is_taken_at_the_given_time():
    cable, weight = hanging_cable(16, 1e-3)
    moved = Motion(lambda t: np.array([[SPAN - 0.1 * t, 0.05 * t], [-0.1, 0.05], [0.0, 0.0]]))
    free_end = straight_cable(16, 2, "pinned", LENGTH).fixed
    moving = replace(cable, fixed=free_end, links=tuple(prescribed(16, moved, [0, 1])))
    there = cable.reference.copy()
    there[-1, 0] = [SPAN - 0.2, 0.1]
    expected = equilibrium(replace(cable, reference=there), weight, cable.reference)
    found = equilibrium(moving, weight, time=2.0)
    assert found.converged
    np.testing.assert_allclose(found.q, expected.q, atol=1e-8)


# ------------------------------------------------------------------- columns

CRITICAL = {"clamped": 0.25 * np.pi**2, "pinned on a roller": np.pi**2}


def column(kind, number=12):
    """Upright cable of unit length and EI; its top is free, or on a vertical roller."""
    supports = "clamped" if kind == "clamped" else "pinned"
    cable = straight_cable(number, 2, supports, 1.0, section=UNIT)
    upright = replace(cable, reference=np.ascontiguousarray(cable.reference[..., ::-1]))
    if kind == "clamped":
        return upright
    roller = prescribed(number, rest(np.array([0.0, 1.0])), [0])
    return replace(upright, links=tuple(roller))


def eigenvalue_of_straight(cable, load):
    potential = Potential([cable], end_force(cable, [0.0, -load]), 0.0)
    q = cable.reference
    multipliers = np.linalg.lstsq(potential.jacobian(q).T.toarray(), potential.force(q), rcond=None)[0]
    return smallest_eigenvalue(small_motions(potential, q, multipliers))[0]


@pytest.mark.parametrize("kind", CRITICAL)
def test_smallest_eigenvalue_of_a_column_vanishes_at_eulers_load(kind, known_answer):
    cable = column(kind)
    found = brentq(lambda p: eigenvalue_of_straight(cable, p), 0.5 * CRITICAL[kind], 1.5 * CRITICAL[kind])
    assert found == pytest.approx(CRITICAL[kind], rel=1e-4)
    known_answer(f"Euler's column, {kind}: critical load", abs(found / CRITICAL[kind] - 1.0))


@pytest.mark.parametrize("kind", CRITICAL)
def test_column_stands_below_eulers_load(kind):
    cable = column(kind)
    rng = np.random.default_rng(5)
    start = cable.reference + 1e-2 * rng.standard_normal(cable.reference.shape)
    found = equilibrium(cable, end_force(cable, [0.0, -0.95 * CRITICAL[kind]]), start)
    assert found.converged
    np.testing.assert_allclose(found.q, cable.reference, atol=1e-6)


@pytest.mark.parametrize("kind", CRITICAL)
@pytest.mark.parametrize("angle", [40.0, 100.0])
def test_straight_column_is_left_above_eulers_load_for_the_buckled_elastica(kind, angle):
    """The largest angle a to the vertical is that of P / P_cr = (2 K(sin^2(a/2)) / pi)^2."""
    a = np.deg2rad(angle)
    load = CRITICAL[kind] * (2.0 * ellipk(np.sin(0.5 * a) ** 2) / np.pi) ** 2
    cable = column(kind, 24)
    found = equilibrium(cable, end_force(cable, [0.0, -load]))
    assert found.converged
    slope = found.q[-1, 1]
    assert np.arctan2(abs(slope[0]), slope[1]) == pytest.approx(a, abs=2e-4)


def test_smallest_eigenvalue_of_a_cantilever_is_its_lowest_frequency_squared():
    stiffness, density, length = 0.7, 0.3, 1.8
    exact = 1.8751040687**2 * np.sqrt(stiffness / density) / length**2
    errors = []
    for number in (2, 4, 8):
        cable = straight_cable(number, 2, "clamped", length, section=Section(density, stiffness))
        found = equilibrium(cable, np.zeros(cable.reference.shape))
        assert found.converged
        errors.append(abs(np.sqrt(found.smallest_eigenvalue) / exact - 1.0))
    assert errors[-1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 3.5


# ------------------------------------------------------------------- nothing to be found


def on_a_slide():
    """Its ends glide along x, along which it is pulled."""
    cable = straight_cable(4, 2, section=UNIT)
    links = [*prescribed(0, rest(np.zeros(2)), [1]), *prescribed(4, rest(np.zeros(2)), [1])]
    return replace(cable, links=tuple(links)), [1.0, 0.0]


def floating(force):
    return lambda: (straight_cable(4, 2, section=UNIT), force)


@pytest.mark.parametrize("case", [floating([0.0, -1.0]), floating([0.0, 0.0]), on_a_slide])
def test_cable_that_nothing_holds_has_no_stable_equilibrium(case):
    cable, force = case()
    found = equilibrium(cable, end_force(cable, force))
    assert not found.converged
    assert found.message.startswith(("it runs away", "no stable equilibrium within reach"))


def test_search_that_is_cut_off_says_so():
    cable = straight_cable(8, 2, "clamped", 1.0, section=UNIT)
    found = equilibrium(cable, end_force(cable, [0.0, 10.0]), most=2)
    assert not found.converged
    assert found.message == "no stable equilibrium within reach"
    assert found.iterations == 2
    assert found.residual > 1e-3


def test_supports_out_of_reach_are_a_violation_of_constraints():
    cable, weight = hanging_cable(8, 1e-3)
    reference = cable.reference.copy()
    reference[-1, 0, 0] = 1.1 * LENGTH
    found = equilibrium(replace(cable, reference=reference), weight)
    assert not found.converged
    assert found.message == "the constraints cannot be met"
    assert found.violation > 1e-3


def test_both_measures_have_one_equilibrium_in_the_limit():
    cable, weight = hanging_cable(40, 1e-2)
    first = equilibrium(cable, weight)
    second = equilibrium(replace(cable, measure=CurvatureMeasure.PRODUCT), weight)
    assert first.converged and second.converged
    assert relative_error(second.q[:, 0], first.q[:, 0]) < 1e-4
