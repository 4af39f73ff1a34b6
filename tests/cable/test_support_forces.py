"""What supports and links do to a cable in motion, for many states at once."""

import numpy as np
import pytest

from exudyn_inext.cable.support_forces import SupportedCable
from tests.cables import DIMENSIONS, LINKS, MEASURES, linked_state, random_state, with_section

STATES = 3


def some_states(state):
    """(k, n_external) forces and motions, and (k, n_dof) coordinates and velocities around a state."""
    rng, held = np.random.default_rng(1), np.repeat(state.cable.fixed[:, :, None], state.q.shape[2], axis=2)
    q, v = (
        np.stack(
            [array + np.where(held, 0.0, 0.01 * rng.standard_normal(array.shape)) for _ in range(STATES)]
        )
        for array in (state.q, state.v)
    )
    if state.cable.closed:
        q[:, -1], v[:, -1] = q[:, 0], v[:, 0]
    external = np.outer(np.arange(1.0, STATES + 1.0), state.inputs)
    external[:, state.q.size :] = state.inputs[state.q.size :]
    return external, q.reshape(STATES, -1), v.reshape(STATES, -1), np.array([0.0, 1e-3, 2e-3])


@pytest.mark.parametrize("stiffness", [None, 1e3])
@pytest.mark.parametrize("dim", DIMENSIONS)
@pytest.mark.parametrize("links", ["closed and pinned", "rod", "moving hanger, rod and node"])
def test_states_together_have_the_forces_of_each_alone(links, dim, stiffness):
    assert links in LINKS
    state = linked_state(1, 4, dim, MEASURES[0], links)
    state = state if stiffness is None else with_section(state, axial_stiffness=stiffness)
    given = some_states(state)
    together = SupportedCable(state.cable).solve(*given)
    for k in range(STATES):
        alone = SupportedCable(state.cable).solve(*(array[k : k + 1] for array in given))
        np.testing.assert_allclose(
            together.on_coordinates[k], alone.on_coordinates[0], rtol=1e-10, atol=1e-10
        )
        np.testing.assert_allclose(together.of_links[k], alone.of_links[0], rtol=1e-10, atol=1e-10)
    assert max(np.abs(np.diff(forces, axis=0)).max(initial=0.0) for forces in together) > 0.1


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_nothing_acts_where_nothing_holds(dim):
    """At free positions all forces balance, damping among them."""
    state = random_state(2, 4, dim, MEASURES[0], supports="pinned")
    state = with_section(state, bending_damping=0.02)
    on_coordinates = SupportedCable(state.cable).solve(*some_states(state)).on_coordinates
    free = ~state.cable.fixed[:, 0]
    assert np.abs(on_coordinates[:, free, 0]).max() < 1e-9 * np.abs(on_coordinates[:, ~free, 0]).max()
