"""The planar pendulum: the data of the paper, the independent reference, energy."""

import numpy as np
import pytest

from examples import planar_pendulum
from tests.examples import scenes
from tests.examples.measures import total_energy
from tests.examples.twins import run_inextensible

NAME = "planar_pendulum"


def test_its_section_is_that_of_the_scene():
    scenes.require_section(planar_pendulum.CABLE, NAME)


def test_the_tip_follows_the_independent_reference():
    times, points = scenes.run(planar_pendulum)
    assert times[-1] == pytest.approx(planar_pendulum.END_TIME) and len(times) > 400
    assert scenes.distance_to_reference(NAME, times, points[:, -1]) < 1.5e-3
    assert np.abs(points[:, 0]).max() == 0.0
    assert scenes.largest_stretch(points, planar_pendulum.LENGTH / planar_pendulum.ELEMENTS) < 1 + 1e-9


def test_energy_stays():
    run = run_inextensible(planar_pendulum, 2.0)
    kinetic, total = total_energy(run, [(planar_pendulum.LENGTH, planar_pendulum.CABLE)], [], [0, -9.81, 0])
    assert np.abs(total - total[0]).max() < 1e-3 * np.ptp(kinetic)
