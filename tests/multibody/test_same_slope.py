"""The equation of two slopes that are the same: against rotations and differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exudyn_inext.compiled import plain
from exudyn_inext.multibody.same_slope import same_slopes, slope_difference, slope_gamma

pytestmark = pytest.mark.kernel
SPREAD = [0.1, 1.0, 3.0, 3.1]  # angle between the initial and the present slope


def turned(angle, seed):
    """d, b across it, s at that angle to it, and the rotation from d to s."""
    rotation = Rotation.random(random_state=seed).as_matrix()
    d, b, normal = rotation
    turn = Rotation.from_rotvec(angle * (np.cos(seed) * normal + np.sin(seed) * b)).as_matrix()
    return d, b, turn @ d, turn


def difference(b, d, s, r):
    return plain(slope_difference)(b, d, s, r, np.zeros((2, 3)))


@pytest.mark.parametrize("angle", SPREAD)
def test_it_is_a_component_across_the_first_slope(angle):
    d, b, s, turn = turned(angle, 1)
    r = np.array([0.3, -0.5, 0.8])
    assert abs(difference(b, d, s, r) - (turn @ b) @ r) < 1e-12
    assert abs(difference(b, d, 1.1 * s, 2.0 * s)) < 1e-14


@pytest.mark.parametrize("angle", SPREAD)
def test_derivatives_are_those_of_differences(angle):
    d, b, s, _ = turned(angle, 2)
    r = s + np.array([0.02, -0.03, 0.01])
    gradient, h = np.zeros((2, 3)), 1e-6
    slope_difference(b, d, s, r, gradient)
    for k, step in enumerate(h * np.eye(3)):
        by_s = (difference(b, d, s + step, r) - difference(b, d, s - step, r)) / (2 * h)
        by_r = (difference(b, d, s, r + step) - difference(b, d, s, r - step)) / (2 * h)
        np.testing.assert_allclose(gradient[:, k], [by_s, by_r], atol=1e-7)


@pytest.mark.parametrize("angle", SPREAD[:3])
def test_gamma_is_the_second_difference_along_the_motion(angle):
    d, b, s, _ = turned(angle, 3)
    one, other = np.zeros((2, 3, 3))
    one[:2] = s, [0.3, 0.1, -0.4]
    other[:2] = s + np.array([0.02, -0.03, 0.01]), [-0.2, 0.5, 0.1]
    h = 1e-4
    before, at, after = (difference(b, d, one[0] + t * one[1], other[0] + t * other[1]) for t in (-h, 0, h))
    assert abs(plain(slope_gamma)(b, d, one, other) - (2 * at - before - after) / h**2) < 1e-5


@pytest.mark.parametrize("slope", [[0.6, 0.8], [0, 0, 1.0], [1.0, 0, 0], [0.0, -0.6, 0.8]])
def test_components_are_those_across_the_slope_also_where_it_has_turned_round(slope):
    """As of a cable that stood upright, and hangs."""
    dim = len(slope)
    d, across = same_slopes(np.array(slope))
    s, r = np.zeros(3), np.zeros(3)
    s[:dim], r[:dim] = np.negative(slope), np.array([0.3, -0.5, 0.8])[:dim]
    components = [difference(b, d, s, r) for b in across]
    assert np.hypot.reduce(components) == pytest.approx(np.linalg.norm(np.cross(s, r)))
    one, other = np.zeros((2, 3, 3))
    one[:2], other[:2] = [s, [0.2, -0.4, 0]], [s, [0.1, 0.3, 0]]
    assert np.isfinite([plain(slope_gamma)(b, d, one, other) for b in across]).all()
