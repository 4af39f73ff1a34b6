"""The motion does not depend on where, and from where, one looks at it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exudyn_inext.integrators import INTEGRATORS
from tests.properties.moving_cables import (
    STEPS,
    H,
    moving_cable,
    numbers,
    run,
    same_motion,
    seeds,
    supports_of_cables,
)

every_integrator = pytest.mark.parametrize("name", INTEGRATORS)


def orthogonal(seed, dim, mirrors):
    """(dim, dim) a rotation, or a rotation and a reflection."""
    rng = np.random.default_rng([seed, 1])
    matrix = np.linalg.qr(rng.standard_normal((dim, dim)))[0]
    if (np.linalg.det(matrix) < 0) != mirrors:
        matrix[0] *= -1.0
    return matrix


def turned(state, matrix, shift):
    """The same cable in the same motion, its place turned by `matrix` and moved by `shift` (dim,)."""

    def placed(q):
        return q @ matrix.T + np.stack([shift, 0 * shift])

    cable = replace(state.cable, reference=placed(state.cable.reference))
    return replace(
        state, cable=cable, q=placed(state.q), v=state.v @ matrix.T, external=state.external @ matrix.T
    )


@every_integrator
@given(seed=seeds, number=numbers, supports=supports_of_cables, mirrors=st.booleans())
def test_a_cable_moved_turned_and_mirrored_in_the_plane_moves_alike(name, seed, number, supports, mirrors):
    state = moving_cable(seed, number, 2, supports)
    matrix, shift = orthogonal(seed, 2, mirrors), np.array([3.0, -2.0])
    found, expected = run(turned(state, matrix, shift), name), run(state, name) @ matrix.T
    expected[:, 0, :, 0] += shift
    same_motion(found, expected)


@pytest.mark.parametrize("name", ["RATTLE", "Zhai"])
@given(seed=seeds, number=numbers, supports=supports_of_cables, mirrors=st.booleans())
def test_a_cable_moved_turned_and_mirrored_in_space_moves_alike(name, seed, number, supports, mirrors):
    state = moving_cable(seed, number, 3, supports)
    matrix, shift = orthogonal(seed, 3, mirrors), np.array([3.0, -2.0, 1.0])
    found, expected = run(turned(state, matrix, shift), name), run(state, name) @ matrix.T
    expected[:, 0, :, 0] += shift
    same_motion(found, expected)


@every_integrator
@given(seed=seeds, number=numbers, wind=st.tuples(*[st.floats(-5.0, 5.0)] * 2))
def test_a_free_cable_seen_from_a_train_moves_alike(name, seed, number, wind):
    state, wind = moving_cable(seed, number, 2), np.array(wind)
    v = state.v + np.stack([wind, 0 * wind])
    found, expected = run(replace(state, v=v), name), run(state, name)
    times = H * STEPS / 5 * np.arange(1, 6)
    expected[:, 0, :, 0] += np.multiply.outer(times, wind)[:, None]
    expected[:, 1, :, 0] += wind
    same_motion(found, expected)


def embedded(state, plane):
    """A planar cable in the plane that the columns of `plane` (3, 2) span."""
    cable = replace(state.cable, reference=state.cable.reference @ plane.T)
    arrays = {name: getattr(state, name) @ plane.T for name in ("q", "v", "external")}
    return replace(state, cable=cable, **arrays)


@pytest.mark.parametrize("name", ["RATTLE", "Zhai"])
@given(seed=seeds, number=numbers, supports=supports_of_cables)
def test_a_planar_motion_in_any_plane_of_space_is_that_in_the_plane(name, seed, number, supports):
    state, plane = moving_cable(seed, number, 2, supports), orthogonal(seed, 3, False)[:, :2]
    same_motion(run(embedded(state, plane), name), run(state, name) @ plane.T)
