"""The vibrating ring: the data of the paper, the independent reference, symmetry and momentum."""

import numpy as np

from examples import vibrating_ring
from tests.examples import scenes

NAME = "vibrating_ring"


def test_its_section_is_that_of_the_scene():
    scenes.require_section(vibrating_ring.RING, NAME)


def test_the_driven_node_follows_the_independent_reference_and_the_ring_stays_symmetric():
    times, points = scenes.run(vibrating_ring)
    assert scenes.distance_to_reference(NAME, times, points[:, 0]) < 1e-3
    centre = points[:, :-1].mean(axis=1)
    np.testing.assert_allclose(centre, 0.0, atol=1e-9)  # nothing holds it: balanced forces alone
    half = vibrating_ring.ELEMENTS // 2
    np.testing.assert_allclose(points[:, :half], -points[:, half:-1], atol=1e-7)
    quarter = vibrating_ring.ELEMENTS // 4
    assert (points[:, 0, 0] + points[:, quarter, 1]).max() < 2 * vibrating_ring.RADIUS + 5e-3  # wide or high
