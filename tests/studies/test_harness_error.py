"""The error metric on motions whose distance is known."""

import numpy as np
import pytest

from exudyn_inext.errors import InputError
from reference_models.trajectory import Trajectory
from studies.harness.reference import distance_to_reference, interpolation_error


def circle(times, radius=1.0):
    angle = 2.0 * times
    positions = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    return Trajectory(times, positions)


REFERENCE = circle(np.linspace(0.0, 5.0, 501))


def test_a_larger_circle_is_off_by_the_difference_of_the_radii():
    error = distance_to_reference(circle(REFERENCE.times, radius=1.003), REFERENCE)
    assert error.maximum == pytest.approx(3e-3, rel=1e-9)
    assert error.rms == pytest.approx(3e-3, rel=1e-9)


def test_rms_weighs_all_samples():
    positions = REFERENCE.positions.copy()
    positions[::2, 2] += 1e-3
    error = distance_to_reference(Trajectory(REFERENCE.times, positions), REFERENCE)
    assert error.maximum == pytest.approx(1e-3)
    assert error.rms == pytest.approx(1e-3 * np.sqrt(251 / 501))


def test_samples_between_those_of_the_reference_are_compared_in_time():
    exact = circle(np.linspace(0.0, 5.0, 714))
    assert distance_to_reference(exact, REFERENCE).maximum < 1e-8


def test_interpolation_error_is_that_of_a_cubic_spline_of_twice_the_period():
    """On a smooth motion it falls with the fourth power of the sampling period."""
    coarse = interpolation_error(circle(np.linspace(0.0, 5.0, 101))).rms
    fine = interpolation_error(circle(np.linspace(0.0, 5.0, 201))).rms
    assert 10 < coarse / fine < 40


def test_a_run_beyond_the_reference_is_refused():
    with pytest.raises(InputError, match=r"ends at 6 s, the reference at 5 s"):
        distance_to_reference(circle(np.linspace(0.0, 6.0, 601)), REFERENCE)


def test_a_trajectory_of_the_wrong_shape_is_refused():
    with pytest.raises(InputError, match=r"\(3, 3\)"):
        Trajectory(np.zeros(3), np.zeros((3, 2)))
