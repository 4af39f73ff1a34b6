"""The largest stable step is found where linear theory puts it."""

import dataclasses

import pytest

from reference_models.conventional.model import build
from reference_models.conventional.settings import Explicit
from reference_models.conventional.stability import (
    IMAGINARY_LIMIT,
    is_stable,
    largest_frequency,
    largest_stable_step,
)
from reference_models.conventional.supports import PIN_STIFFNESS
from reference_models.scenes import load_scene

SHORT = dataclasses.replace(load_scene("planar_pendulum"), end_time=0.3)


@pytest.mark.parametrize("quadrature", ["full", "lobatto"])
@pytest.mark.parametrize("integrator", IMAGINARY_LIMIT)
def test_bisection_finds_the_limit_of_linear_theory(integrator, quadrature):
    step_size = largest_stable_step(SHORT, 4, integrator, quadrature)
    frequency = largest_frequency(build(SHORT, 4, quadrature, PIN_STIFFNESS))
    assert step_size * frequency == pytest.approx(IMAGINARY_LIMIT[integrator], rel=0.01)


def test_ten_elements_have_their_known_limit():
    frequency = largest_frequency(build(SHORT, 10, pin_stiffness=PIN_STIFFNESS))
    assert 2.0 / frequency == pytest.approx(2.36e-5, rel=1e-2)


@pytest.mark.parametrize("integrator", IMAGINARY_LIMIT)
def test_one_percent_above_the_limit_is_unstable_even_where_nothing_overflows(integrator):
    model = build(SHORT, 4, pin_stiffness=PIN_STIFFNESS)
    limit = IMAGINARY_LIMIT[integrator] / largest_frequency(model)
    assert not is_stable(model, Explicit(1.01 * limit, integrator), 0.3)


@pytest.mark.parametrize("integrator", IMAGINARY_LIMIT)
def test_two_percent_below_the_limit_is_stable(integrator):
    model = build(SHORT, 4, pin_stiffness=PIN_STIFFNESS)
    limit = IMAGINARY_LIMIT[integrator] / largest_frequency(model)
    assert is_stable(model, Explicit(0.98 * limit, integrator), 0.3)
