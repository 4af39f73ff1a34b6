"""Random cables in motion: what the properties are tried on."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from exudyn_inext.cable.cable import CurvatureMeasure
from tests.cables import State, random_state, some_links, with_resting_anchors
from tests.moving import move, on_constraints

MEASURE = CurvatureMeasure.SECOND_DERIVATIVE
ZETA = 20.0
H, STEPS = 4e-3, 50
SAME = 1e-8  # of coordinates of order 1 and velocities of order 5, whose constraints are met to 1e-10

seeds = st.integers(0, 10**6)
numbers = st.integers(2, 6)
supports_of_cables = st.sampled_from(["free", "pinned", "clamped", "pinned within", "pinned and guided"])


def moving_cable(seed, number, dim, supports="free", links=(), n_bar=None):
    """A cable with unequal elements that moves on its constraints under random forces."""
    state = random_state(seed, number, dim, MEASURE, n_bar, supports)
    state = on_constraints(state)
    if not links:
        return state
    cable = replace(state.cable, links=some_links(links, state.q))
    return on_constraints(with_resting_anchors(replace(state, cable=cable)))


def moving_ring(seed, number, dim):
    """A closed cable that moves on its constraints under random forces."""
    rng = np.random.default_rng([seed, number, dim])
    angle = 2.0 * np.pi * np.arange(number) / number
    radius = 1.0 + rng.uniform(-0.2, 0.2, number)
    q = np.zeros((number + 1, 2, dim))
    q[:-1, 0, 0], q[:-1, 0, 1] = radius * np.cos(angle), radius * np.sin(angle)
    q[:-1, 1, 0], q[:-1, 1, 1] = -np.sin(angle), np.cos(angle)
    q[:-1, 1] += rng.uniform(-0.2, 0.2, (number, dim))
    q[-1] = q[0]
    v = rng.standard_normal(q.shape)
    v[-1] = v[0]
    state = random_state(seed, number, dim, MEASURE)
    lengths = np.linalg.norm(np.diff(q[:, 0], axis=0), axis=1) * 1.05
    cable = replace(state.cable, element_lengths=lengths, closed=True)
    return on_constraints(State(cable, q, v, state.external))


def same_motion(found, expected):
    """q and v agree; accelerations, which are no state, within what stiffness makes of the difference."""
    np.testing.assert_allclose(found[:, 0], expected[:, 0], atol=SAME)
    np.testing.assert_allclose(found[:, 1], expected[:, 1], atol=100 * SAME)


def run(state, name="RATTLE", h=H, steps=STEPS, **options):
    """(5, 3, n, 2, dim) history of a short motion."""
    return move(state, h, steps, steps // 5, name, ZETA, **options)
