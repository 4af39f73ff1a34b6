"""RATTLE without constraints is the leapfrog scheme; Zhai's history follows a change of the step."""

import math

import numpy as np
import pytest

from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.linear_stability import (
    LinearSystem,
    amplification_matrix,
    decay_limit,
    frequency_limit,
)
from exudyn_inext.integrators.zhai import change_step

pytestmark = pytest.mark.kernel

RATTLE = INTEGRATORS["RATTLE"]


@pytest.mark.parametrize("w", [0.3, 1.9])
def test_a_step_of_an_oscillator_is_that_of_the_leapfrog_scheme(w):
    """q1 = q + v - w^2 q / 2, v1 = v - w^2 (q + q1) / 2 with h = 1; its own history does not count."""
    matrix = amplification_matrix(RATTLE, RATTLE.scheme(), LinearSystem(w * w, 0.0))
    c = 1.0 - 0.5 * w * w
    leapfrog = np.array([[c, 1.0], [-w * w * (1.0 + c) / 2.0, c]])
    # with the acceleration that belongs to q
    of_state = matrix @ np.array([[1.0, 0.0], [0.0, 1.0], [-w * w, 0.0]])
    np.testing.assert_allclose(of_state[:2], leapfrog, atol=1e-14)
    np.testing.assert_allclose(of_state[2], -w * w * leapfrog[0], atol=1e-14)


def test_the_stability_limit_is_that_of_the_leapfrog_scheme():
    assert frequency_limit(RATTLE, RATTLE.scheme()) == pytest.approx(2.0, abs=1e-3)
    assert decay_limit(RATTLE, RATTLE.scheme()) == math.inf


@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0])
def test_the_last_acceleration_of_zhai_is_moved_along_a_line(ratio):
    h, slope = 0.1, np.array([2.0, -1.0])
    state = INTEGRATORS["Zhai"].allocate(2, 2)
    state.a[:] = 5.0
    state.a_previous[:] = 5.0 - h * slope
    change_step(state, ratio)
    np.testing.assert_allclose(state.a_previous, 5.0 - ratio * h * slope, rtol=1e-14)
