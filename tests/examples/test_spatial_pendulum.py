"""The spatial pendulum: the data of the paper, the independent reference, spin about the vertical."""

import numpy as np

from examples import spatial_pendulum
from tests.examples import scenes
from tests.examples.measures import cable_momentum
from tests.examples.twins import run_inextensible

NAME = "spatial_pendulum"


def test_its_section_is_that_of_the_scene():
    scenes.require_section(spatial_pendulum.CABLE, NAME)


def test_the_tip_follows_the_independent_reference():
    times, points = scenes.run(spatial_pendulum)
    assert scenes.distance_to_reference(NAME, times, points[:, -1]) < 1.5e-3
    assert np.abs(points[:, 0]).max() == 0.0
    assert scenes.largest_stretch(points, spatial_pendulum.LENGTH / spatial_pendulum.ELEMENTS) < 1 + 1e-9


def test_angular_momentum_about_the_vertical_through_the_pin_stays():
    _, history = run_inextensible(spatial_pendulum, 1.0)
    _, spin = cable_momentum(*history.cables[0], spatial_pendulum.LENGTH, spatial_pendulum.CABLE)
    as_a_rod = (
        spatial_pendulum.CABLE.massPerLength * spatial_pendulum.LENGTH**2 / 3 * spatial_pendulum.PUSH[1]
    )
    np.testing.assert_allclose(spin[:, 2], as_a_rod, rtol=1e-6)
