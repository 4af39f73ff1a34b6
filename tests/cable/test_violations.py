"""How far a configuration is from the constraints: what RATTLE iterates on."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.system import correct_position
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    dense_constraints,
    elements_of,
    linked_state,
    random_state,
    slope_gram_matrix,
    straight_cable,
)

pytestmark = pytest.mark.kernel

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def violation(state, q):
    """What `correct_position` returns, with a tolerance that leaves the configuration alone."""
    correction = np.full(q.size, 7.0)
    worst = correct_position(cable_system(state.cable, 0.0), state.inputs, q.ravel(), np.inf, 0.0, correction)
    assert (correction == 7.0).all()
    return worst


def of_nodes(cable, q):
    return np.abs((q[:, 1] ** 2).sum(axis=1) - 1.0)[~cable.fixed[:, 1]]


def of_groups(cable, q):
    """Stretch of each group: the sum of its elements' own, relative to their lengths."""
    squares = [
        np.sum(nodal * (slope_gram_matrix(length) @ nodal)) for _, length, nodal in elements_of(cable, q)
    ]
    stretch = np.array(squares) / cable.constrained_lengths() - 1.0
    group = cable.group_of_element()
    return np.abs([stretch[group == g].sum() for g in range(cable.length_constraints)])


@both_dimensions
@pytest.mark.parametrize("supports", ["free", "clamped"])
@pytest.mark.parametrize("n_bar", [1, 3, 5])
def test_violation_is_the_largest_of_slopes_and_groups(dim, n_bar, supports):
    state = random_state(11, 5, dim, MEASURES[0], n_bar, supports)
    stretched, turned = state.q.copy(), state.q.copy()
    stretched[:, 0] *= 1.3
    turned[2, 1] *= 1.5
    for q, decisive in ((stretched, of_groups), (turned, of_nodes)):
        cable = state.cable
        expected = max(of_groups(cable, q).max(), of_nodes(cable, q).max())
        assert violation(state, q) == pytest.approx(expected, rel=1e-12)
        if n_bar == 5:
            assert expected == decisive(cable, q).max()


@both_dimensions
def test_a_straight_cable_violates_nothing(dim):
    for n_bar in (0, 2, 4):
        cable = straight_cable(4, dim, length_constraints=n_bar)
        state = replace(random_state(11, 4, dim, MEASURES[0], n_bar), cable=cable)
        assert violation(state, cable.reference) < 1e-14


@both_dimensions
@pytest.mark.parametrize("links", ["hanger", "rod", "moving node"])
def test_a_link_is_measured_with_the_element_at_its_first_node(dim, links):
    """Far from its anchor or from the other node; the elements are all of different lengths."""
    state = linked_state(12, 5, dim, MEASURES[0], links)
    cable, q = state.cable, state.q.copy()
    first = cable.links[0].nodes[0]
    q[first, 0] += 3.0
    values = dense_constraints(cable, q, state.v, state.time)
    name = "prescribed motion" if links == "moving node" else "distance"
    of_link = np.abs(values.value[values.rows[name]]).max() / cable.element_lengths[min(first, 4)]
    with_one_length = replace(cable, length_constraints=0)
    found = violation(replace(state, cable=with_one_length), q)
    assert of_link > of_nodes(cable, q).max()
    assert found == pytest.approx(of_link, rel=1e-12)
