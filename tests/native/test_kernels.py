"""Small kernels of coupled scenes: norms of quaternions, comparison of states."""

import numpy as np
import pytest

from exudyn_inext.native.joint_rows import _keep_norms
from exudyn_inext.native.native_items import _compare

pytestmark = pytest.mark.kernel


def test_moved_quaternions_are_scaled_to_the_norms_they_had():
    """Coordinates are displacements from references; what is no quaternion stays."""
    rng = np.random.default_rng(3)
    places, references = np.array([[1, 2, 3, 4], [9, 8, 7, 6]]), rng.standard_normal((2, 4))
    q, moved = rng.standard_normal((2, 10))
    before = moved.copy()
    _keep_norms(places, references, q, moved)
    for at, reference in zip(places, references, strict=True):
        found, had, turned = (x[at] + reference for x in (moved, q, before))
        assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(had), rel=1e-14)
        np.testing.assert_allclose(found / np.linalg.norm(found), turned / np.linalg.norm(turned), rtol=1e-12)
    np.testing.assert_array_equal(moved[[0, 5]], before[[0, 5]])


@pytest.mark.parametrize(
    ("x", "y", "same", "finite"),
    [
        ([1.0, 2.0], [1.0, 2.0], True, True),
        ([1.0, 2.0], [1.0, 2.5], False, True),
        ([0.5, 2.0], [1.0, 2.0], False, True),
        ([np.nan, 2.0], [np.nan, 2.0], False, False),
        ([1.0, np.inf], [1.0, np.inf], True, False),
        ([np.inf, 1.0], [1.0, 1.0], False, False),
    ],
)
def test_states_are_compared_and_looked_at(x, y, same, finite):
    assert tuple(map(bool, _compare(np.array(x), np.array(y)))) == (same, finite)
