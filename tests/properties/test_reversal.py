"""RATTLE is symmetric: with all velocities turned round, it retraces its steps. Zhai and RK4 are not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.properties.moving_cables import (
    SAME,
    H,
    moving_cable,
    moving_ring,
    numbers,
    run,
    seeds,
    supports_of_cables,
)


def distance_to_the_start(state, name="RATTLE", **options):
    """What is left between the start and where the reversed motion ends, and how far it was away."""
    away = run(state, name, **options)[-1]
    back = run(replace(state, q=away[0].copy(), v=-away[1]), name, **options)[-1]
    gap = max(np.abs(back[0] - state.q).max(), 0.01 * np.abs(back[1] + state.v).max())
    return gap, np.abs(away[0] - state.q).max()


@pytest.mark.parametrize("dim", [2, 3])
@given(seed=seeds, number=numbers, supports=supports_of_cables, theta=st.sampled_from([0.0, 0.3]))
def test_rattle_is_reversible(dim, seed, number, supports, theta):
    gap, way = distance_to_the_start(moving_cable(seed, number, dim, supports), mass_scaling=theta * H**2)
    assert gap < SAME
    assert way > 0.05


@given(seed=seeds, number=st.integers(4, 6))
def test_rattle_is_reversible_on_a_hanger_with_a_rod(seed, number):
    gap, way = distance_to_the_start(moving_cable(seed, number, 2, links=("hanger", "rod")))
    assert gap < SAME
    assert way > 0.05


@given(seed=seeds, number=st.integers(5, 8))
def test_rattle_is_reversible_on_a_ring(seed, number):
    gap, way = distance_to_the_start(moving_ring(seed, number, 2))
    assert gap < SAME
    assert way > 0.05


@pytest.mark.parametrize("name", ["Zhai", "RK4"])
def test_the_others_do_not_return(name):
    gap, _ = distance_to_the_start(moving_cable(1, 4, 2, "pinned"), name, h=2 * H)
    assert gap > 100 * SAME
