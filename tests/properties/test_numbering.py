"""The motion does not depend on how the nodes are numbered, nor on where a cable is cut."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exudyn_inext.integrators import INTEGRATORS
from tests.properties.moving_cables import (
    moving_cable,
    moving_ring,
    numbers,
    run,
    same_motion,
    seeds,
    supports_of_cables,
)

every_integrator = pytest.mark.parametrize("name", INTEGRATORS)


def from_the_other_end(x):
    """Coordinates (..., n, 2, dim) with the nodes in reversed order: slopes point the other way."""
    return x[..., ::-1, :, :] * np.array([1.0, -1.0])[:, None]


@every_integrator
@given(seed=seeds, number=numbers, supports=supports_of_cables, one_group=st.booleans())
def test_a_cable_numbered_from_its_other_end_moves_alike(name, seed, number, supports, one_group):
    state = moving_cable(seed, number, 2, supports, n_bar=1 if one_group else number)
    cable = replace(
        state.cable,
        reference=from_the_other_end(state.cable.reference),
        element_lengths=state.cable.element_lengths[::-1].copy(),
        fixed=state.cable.fixed[::-1].copy(),
    )
    arrays = {key: from_the_other_end(getattr(state, key)) for key in ("q", "v", "external")}
    found = run(replace(state, cable=cable, **arrays), name)
    same_motion(from_the_other_end(found), run(state, name))


def renumbered(x, first):
    """Nodes (n, 2, dim) of a ring, whose last one is the first one, beginning with another one."""
    rolled = np.roll(x[:-1], -first, axis=0)
    return np.concatenate([rolled, rolled[:1]])


@given(seed=seeds, number=st.integers(5, 8), first=st.integers(1, 4))
def test_a_ring_may_be_cut_and_closed_by_constraints_at_any_node(seed, number, first):
    state = moving_ring(seed, number, 2)
    state.external[-1] = 0.0  # forces on the node that stands twice are given once
    cable = replace(
        state.cable,
        reference=renumbered(state.cable.reference, first),
        element_lengths=np.roll(state.cable.element_lengths, -first),
    )
    external = renumbered(state.external, first)
    external[-1] = 0.0
    arrays = {key: renumbered(getattr(state, key), first) for key in ("q", "v")}
    found, expected = run(replace(state, cable=cable, external=external, **arrays)), run(state)
    same_motion(found, np.stack([[renumbered(x, first) for x in row] for row in expected]))


def part(state, nodes):
    """The piece of a cable between its `nodes` (a slice)."""
    elements = slice(nodes.start, nodes.stop - 1)
    cable = replace(
        state.cable,
        reference=state.cable.reference[nodes],
        element_lengths=state.cable.element_lengths[elements],
        fixed=state.cable.fixed[nodes],
        length_constraints=nodes.stop - 1 - nodes.start,
    )
    return replace(state, cable=cable, **{key: getattr(state, key)[nodes] for key in ("q", "v", "external")})


@every_integrator
@given(seed=seeds, number=st.integers(2, 6))
def test_a_cable_cut_at_a_clamp_moves_as_its_two_pieces(name, seed, number):
    state = moving_cable(seed, number, 2, "clamped within")
    middle = int(np.flatnonzero(state.cable.fixed[:, 0])[0])
    whole = run(state, name)
    for nodes in (slice(0, middle + 1), slice(middle, number + 1)):
        same_motion(run(part(state, nodes), name), whole[:, :, nodes])
