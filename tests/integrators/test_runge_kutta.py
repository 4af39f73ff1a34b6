"""Classical Runge-Kutta: its limits on the axes of the complex plane, and the pendulum."""

import numpy as np
import pytest

from exudyn_inext import ExplicitSettings
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.linear_stability import decay_limit, frequency_limit
from reference_models.data import reference_trajectory
from reference_models.inextensible import Inextensible, inextensible_case
from reference_models.scenes import load_scene

RK4 = INTEGRATORS["RK4"]


@pytest.mark.kernel
def test_the_stability_limits_are_those_of_the_textbook():
    assert frequency_limit(RK4, RK4.scheme()) == pytest.approx(2 * np.sqrt(2), rel=1e-6)
    assert decay_limit(RK4, RK4.scheme()) == pytest.approx(2.785293563405282, rel=1e-6)


def test_the_pendulum_moves_as_the_reference_at_a_step_that_zhai_cannot_take():
    scene = load_scene("planar_pendulum")
    case = inextensible_case(scene, Inextensible(5, ExplicitSettings("RK4", stepSize=3.4e-3)))
    assert case.step_size > case.details["stepLimit"] * 2.0 / 2.83
    distance = case.prepare()().positions - reference_trajectory(scene).positions
    assert np.linalg.norm(distance, axis=1).max() <= 6e-3
