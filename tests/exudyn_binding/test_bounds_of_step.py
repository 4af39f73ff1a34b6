"""The step size rule, what decides a step, and what a refusal says."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext import ExplicitSettings
from exudyn_inext.errors import StepSizeError
from exudyn_inext.run.step_choice import (
    StepChoice,
    StepSizeBounds,
    largest_step,
    rule_step,
    step_above_limit,
    warn_of_damping,
)

pytestmark = pytest.mark.kernel


def round_section(radius, density, youngs_modulus):
    """rho_A and EI."""
    return np.pi * radius**2 * density, np.pi / 4 * radius**4 * youngs_modulus


def test_rule_reproduces_the_step_of_the_papers_ring():
    length = 2 * np.pi * 0.5 / 20
    h = rule_step(length, *round_section(5e-3, 2700.0, 7.0e9), 0.9)
    assert h == pytest.approx(2.4842e-4, abs=5e-9)


def test_rule_reproduces_the_step_of_the_papers_pendulum():
    h = rule_step(1.8 / 5, *round_section(2e-3, 2766.76, 6.895e9), 0.7)
    assert h == pytest.approx(2.588e-3, abs=5e-7)


def bounds(bending=3.0, stabilisation=3.0, rule=3.0, **others):
    others = {"undamped": bending} | others
    return StepSizeBounds(bending, stabilisation, rule, 123.5, "cable 'main'", **others)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (bounds(rule=1.0), (1.0, "rule (37)")),
        (bounds(bending=1.0), (0.9, "bending")),
        (bounds(stabilisation=1.0), (0.9, "stabilisation")),
        (bounds(bending=1.05, rule=1.0), (0.945, "bending")),
    ],
)
def test_smallest_bound_decides_and_is_named(given, expected):
    h, decided_by = largest_step(given, safety=0.9)
    assert (h, decided_by) == (pytest.approx(expected[0]), expected[1])


def test_stability_limit_is_the_smaller_of_both_bounds_and_not_the_rule():
    assert bounds(bending=2.0, rule=1.0).stability_limit == 2.0
    assert bounds(stabilisation=1.5, rule=1.0).stability_limit == 1.5


@pytest.mark.parametrize(("damped", "place"), [("node 3", "node 3"), ("", "cable 'main'")])
def test_a_warning_of_damping_names_the_member_of_an_ensemble(damped, place):
    slowed = bounds(bending=1e-3, undamped=1.0, damping=2e3, damped=damped)
    choice = StepChoice(slowed, ExplicitSettings(), 1e-3, "bending")
    of_member = replace(choice, bounds=choice.bounds_of_member(2))
    with pytest.warns(UserWarning, match=f"1/s at {place} of member 2 bounds the step"):
        warn_of_damping(of_member, 1.0)


def test_steps_up_to_the_limit_are_accepted():
    assert step_above_limit(2.0, bounds(bending=2.0), "Zhai") is None
    assert step_above_limit(1.0, bounds(bending=2.0), "Zhai") is None


@pytest.mark.parametrize(
    ("given", "cause", "remedy"),
    [
        (bounds(bending=2.5), "w_max = 123.5 rad/s of cable 'main'", "fewer elements"),
        (bounds(stabilisation=2.5), "constraint stabilisation", "stabilizationRate"),
    ],
)
def test_refusal_names_value_limit_culprit_and_remedy(given, cause, remedy):
    error = step_above_limit(2.75, given, "Zhai")
    assert isinstance(error, StepSizeError)
    for part in ("stepSize = 2.75 s", "above 2.5 s", "'Zhai'", cause, "reduce the step", remedy):
        assert part in str(error)


def test_damping_that_lowers_the_limit_is_quoted_with_the_limit_without_it():
    given = bounds(bending=0.1, undamped=2.0 / 123.5 * 100, damping=7.5)
    message = str(step_above_limit(0.2, given, "RATTLE"))
    assert "a damping of 7.5 1/s, which lowers it from 1.619 s" in message
    assert "reduce the damping" in message


def test_mass_scaling_is_advised_where_it_helps_and_only_there():
    given = bounds(bending=2.5)
    assert "massScaling" not in str(step_above_limit(2.75, given, "Zhai"))
    assert "massScaling" not in str(step_above_limit(2.75, given, "Zhai", lambda: bounds(bending=2.6)))
    assert "or set massScaling = 0.3." in str(step_above_limit(2.75, given, "Zhai", bounds))


def test_contacts_to_come_are_named_with_what_makes_them_fast():
    given = bounds(contact=0.5, touching="the wheel", softer="frictionVelocityPenalty")
    message = str(step_above_limit(0.6, given, "RATTLE"))
    for part in ("above 0.5 s", "when contacts close: the wheel", "0.4995 s", "lower their frictionVelocity"):
        assert part in message
