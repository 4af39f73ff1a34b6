"""A cable with natural curvature is stress-free as an arc of that curvature, and bent when straight."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.assembly import add_elastic_force
from exudyn_inext.cable.cable import Section
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.element.natural_curvature import turning_matrix
from tests.cables import (
    MEASURES,
    arc,
    bending_energy,
    bending_force,
    dense_form,
    opening_arc,
    random_state,
    relative_error,
    sampled,
    slope_gram_matrix,
    straight_cable,
    with_section,
)

pytestmark = pytest.mark.kernel

NATURAL = 0.7
ARC_LENGTH = 1.6

both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)


def elastic_force(cable, q):
    force = np.zeros(q.shape)
    add_elastic_force(build_chain(cable), q, force)
    return force


def curved(number, natural, **changes):
    """Cable of the length `ARC_LENGTH` and EI = 1."""
    return straight_cable(number, 2, length=ARC_LENGTH, section=Section(1.0, 1.0, natural), **changes)


def test_turning_matrix_gives_the_integral_of_the_cross_product():
    nodal = np.random.default_rng(1).standard_normal((4, 2))
    slope, weight = sampled(0.8, 1)
    r_x, r_xx = slope.T @ nodal, sampled(0.8, 2)[0].T @ nodal
    integral = weight @ (r_x[:, 0] * r_xx[:, 1] - r_x[:, 1] * r_xx[:, 0])
    a = turning_matrix(0.8)
    np.testing.assert_allclose(a, -a.T, atol=1e-13)
    assert nodal[:, 0] @ a @ nodal[:, 1] == pytest.approx(integral, rel=1e-12)


@both_measures
@pytest.mark.parametrize("natural", [NATURAL, -2.0])
def test_elastic_force_is_minus_the_gradient_of_the_energy(measure, natural):
    state = with_section(random_state(3, 4, 2, measure), natural_curvature=natural)
    gradient = [
        bending_energy(state.cable, state.q + 1e-30j * unit.reshape(state.q.shape)).imag / 1e-30
        for unit in np.eye(state.q.size)
    ]
    force = elastic_force(state.cable, state.q).ravel()
    assert relative_error(force, np.negative(gradient)) < 1e-12
    assert relative_error(bending_force(state.cable, state.q).ravel(), np.negative(gradient)) < 1e-12


def test_elastic_force_turns_with_the_cable():
    state = with_section(random_state(4, 3, 2, MEASURES[0]), natural_curvature=NATURAL)
    rotation = np.array([[0.6, -0.8], [0.8, 0.6]])
    moved = state.q @ rotation.T
    moved[:, 0] += 5.0
    expected = elastic_force(state.cable, state.q) @ rotation.T
    assert relative_error(elastic_force(state.cable, moved), expected) < 1e-11


def test_straight_cable_is_bent_by_a_couple_at_its_ends():
    cable = curved(4, NATURAL)
    expected = np.zeros(cable.reference.shape)
    expected[[0, -1], 1, 1] = -NATURAL, NATURAL  # EI kappa_0, transverse to the slopes at both ends
    np.testing.assert_allclose(elastic_force(cable, cable.reference), expected, atol=1e-12)


@both_measures
@pytest.mark.parametrize("natural", [NATURAL, -NATURAL])
def test_arc_of_the_natural_curvature_is_left_with_nothing_but_a_uniform_tension(measure, natural):
    """EI kappa_0^2 int t . delta r_x dx does no work where the length is kept; `product` has none of it."""
    errors = []
    tension = natural**2 if measure is MEASURES[0] else 0.0
    for number in (4, 8, 16):
        cable = curved(number, natural, measure=measure)
        q = arc(ARC_LENGTH, number, 1.0 / natural)
        workless = (tension * dense_form(cable, slope_gram_matrix) @ q.ravel()).reshape(q.shape)
        errors.append(np.abs(elastic_force(cable, q) - workless).max())
    assert errors[0] < 1e-2 * abs(natural)
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > 1.9


@both_measures
@pytest.mark.parametrize("natural", [0.9, -0.9])
def test_work_on_an_opening_arc_converges_to_the_exact_one(measure, natural):
    radius = 0.8
    exact = ARC_LENGTH * (1.0 / radius - natural) / radius**2  # -dU/dR of EI L (1/R - kappa_0)^2 / 2
    errors = []
    for number in (4, 8, 16):
        opening = opening_arc(ARC_LENGTH, number, radius)
        force = elastic_force(curved(number, natural, measure=measure), arc(ARC_LENGTH, number, radius))
        errors.append(abs((force * opening).sum() / exact - 1.0))
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > 3.5
    assert errors[-1] < 1e-4


def test_without_natural_curvature_nothing_is_added():
    state = random_state(5, 3, 2, MEASURES[0])
    curved_state = with_section(state, natural_curvature=NATURAL)
    difference = elastic_force(curved_state.cable, state.q) - elastic_force(state.cable, state.q)
    double = replace(state.cable.section, natural_curvature=2 * NATURAL)
    twice = elastic_force(replace(state.cable, section=double), state.q) - elastic_force(state.cable, state.q)
    assert np.abs(difference).max() > 0.1
    np.testing.assert_allclose(twice, 2 * difference, atol=1e-12)
