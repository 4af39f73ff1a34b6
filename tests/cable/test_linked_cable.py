"""Chains with links, closed ones included: the bordered O(N) solve gives what a dense solve gives."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.frequency import nodal_multipliers_of
from exudyn_inext.cable.link import Link, rest
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.constraints import prescribed_motion
from exudyn_inext.system import accelerate_and_project, correct_position, index_reduced_rates
from tests.cables import (
    DIMENSIONS,
    LINKS,
    LINKS_LAST,
    MEASURES,
    dense_constraints,
    dense_mass,
    dense_rates,
    linked_state,
    relative_error,
    structured_rates,
)

ZETA = 5.0
TOLERANCE = 1e-11

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)
all_links = pytest.mark.parametrize("links", LINKS)


def compare(state, mass_scaling=0.0):
    acceleration, rate, chain = structured_rates(state, ZETA, mass_scaling)
    expected, expected_rate, lam, _, constraints = dense_rates(state, ZETA, mass_scaling)
    assert relative_error(acceleration, expected) < TOLERANCE
    assert relative_error(rate, expected_rate) < TOLERANCE
    if "length" in constraints.rows:
        length = lam[constraints.rows["length"]][state.cable.group_of_element()]
        assert np.abs(chain.elements["multiplier"][:, 0] - length).max() < TOLERANCE * np.abs(lam).max()


@pytest.mark.kernel
@pytest.mark.parametrize(("dim", "measure"), [(2, MEASURES[0]), (3, MEASURES[0]), (3, MEASURES[1])])
@all_links
def test_small_chains_agree_with_the_dense_solve(dim, measure, links):
    for number, n_bar in ((4, 4), (6, 3), (5, 0)):
        compare(linked_state(51, number, dim, measure, links, n_bar))


@both_dimensions
@all_links
def test_long_chains_agree_with_the_dense_solve(dim, links):
    for number in (11, 24, 40):
        compare(linked_state(52, number, dim, MEASURES[0], links))


@pytest.mark.kernel
@both_dimensions
@all_links
def test_mass_scaling_adds_the_bending_stiffness_to_the_mass(dim, links):
    compare(linked_state(53, 5, dim, MEASURES[0], links), mass_scaling=0.1)


@pytest.mark.kernel
@both_dimensions
@all_links
def test_nodal_multipliers_agree_with_the_dense_solve(dim, links):
    """With a link on a slope, too, that is not transverse to it.

    How first and last node of a closed cable share theirs depends on the direction of its closure.
    """
    state = linked_state(55, 5, dim, MEASURES[0], links)
    weights, direction = np.array([[0.4, 0.7]]), np.array([0.6, 0.8, 0.0])[:dim]
    turned = Link(prescribed_motion.AT_REST, (2,), weights, rest(weights[0] @ state.q[2]), direction)
    state = replace(state, cable=replace(state.cable, links=(*state.cable.links, turned)))
    system = cable_system(state.cable, ZETA)
    a, rate = np.zeros(state.q.size), np.zeros(state.q.size)
    index_reduced_rates(system, state.inputs, state.q.ravel(), state.v.ravel(), a, rate)
    _, _, lam, _, constraints = dense_rates(state, ZETA)
    expected = np.zeros(len(state.q))
    expected[~state.cable.fixed[:, 1]] = lam[constraints.rows["nodal inextensibility"]]
    found = nodal_multipliers_of(system, a.reshape(state.q.shape))
    for nodal in (expected, found):
        nodal[0], nodal[-1] = (nodal[0] + nodal[-1], 0.0) if state.cable.closed else (nodal[0], nodal[-1])
    assert np.abs(found - expected).max() < TOLERANCE * np.abs(lam).max()


@pytest.mark.kernel
@both_dimensions
@all_links
def test_projection_of_positions_and_velocities_agrees_with_the_dense_solve(dim, links):
    duration = 0.05
    state = linked_state(54, 6, dim, MEASURES[0], links, 3)
    cable = state.cable
    q, v = state.q.ravel(), state.v.ravel()
    system = cable_system(cable, ZETA)
    a, end, correction = (np.zeros(q.size) for _ in range(3))
    accelerate_and_project(system, state.inputs, q, v, duration, a, end)
    moved = state.q + 0.01 * state.v
    worst = correct_position(system, state.inputs, moved.ravel(), 1e-10, 0.0, correction)

    expected, *_ = dense_rates(state, 0.0)
    assert relative_error(a, expected) < TOLERANCE
    c = dense_constraints(cable, state.q, state.v, state.time)
    response = np.linalg.solve(dense_mass(cable), c.jacobian.T)
    project = response @ np.linalg.inv(c.jacobian @ response)
    free = v + duration * expected
    assert relative_error(end, free - project @ (c.rate + duration * c.jacobian @ expected)) < 1e-10
    value = dense_constraints(cable, moved, state.v, state.time).value
    assert relative_error(correction, -project @ value) < 1e-10
    assert worst >= 0.99 * np.abs(value[c.rows["nodal inextensibility"]]).max()
    of_links = [value[c.rows[name]] for name in LINKS_LAST if name in c.rows]
    assert worst >= max((np.abs(x).max() for x in of_links), default=0.0) / cable.element_lengths.max()


@pytest.mark.kernel
@both_dimensions
def test_both_ends_of_a_closed_cable_move_alike(dim):
    state = linked_state(55, 7, dim, MEASURES[0], "closed")
    for x in structured_rates(state, ZETA)[:2]:
        nodes = x.reshape(state.q.shape)
        np.testing.assert_array_equal(nodes[0], nodes[-1])
