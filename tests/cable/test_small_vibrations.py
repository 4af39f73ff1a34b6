"""Parts of the largest frequency, each on its own: Sturm sequence, tracker, cables that cannot move."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigvalsh_tridiagonal

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.frequency import FrequencyTracker, largest_frequency, largest_of_tridiagonal
from exudyn_inext.cable.linear_response import respond
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.cable.saddle_point import apply_mass
from exudyn_inext.cable.stiffness import add_link_stiffness
from exudyn_inext.called_system import called
from exudyn_inext.system import index_reduced_rates
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    dense_constraints,
    dense_largest_frequency,
    dense_mass,
    linked_state,
    random_state,
    relative_error,
    straight_cable,
    with_resting_anchors,
)

pytestmark = pytest.mark.kernel

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


@pytest.mark.parametrize("number", [1, 2, 3, 7, 40])
def test_largest_eigenvalue_of_a_tridiagonal_matrix(number):
    rng = np.random.default_rng(number)
    for scale in (1.0, 1e6):
        diagonal, off_diagonal = scale * rng.standard_normal(number), scale * rng.standard_normal(number)
        expected = eigvalsh_tridiagonal(diagonal, off_diagonal[: number - 1])[-1]
        assert largest_of_tridiagonal(number, diagonal, off_diagonal) == pytest.approx(
            expected, abs=1e-12 * scale
        )


def test_what_is_behind_the_matrix_does_not_count():
    assert largest_of_tridiagonal(2, np.array([1.0, 3.0]), np.array([0.0, 1e9])) == pytest.approx(3.0)


def at_rest(state):
    return replace(state, v=np.zeros_like(state.v))


def evaluated(state):
    """The system, and the accelerations that it gave."""
    system = cable_system(state.cable, 0.0)
    a, rate = np.zeros(state.q.size), np.zeros(state.q.size)
    index_reduced_rates(system, state.inputs, state.q.ravel(), state.v.ravel(), a, rate)
    return system, a.reshape(state.q.shape)


@pytest.mark.parametrize(("dim", "links"), [(2, None), (3, None), (2, "rod")])
def test_tracker_finds_the_largest_frequency_and_stays_there(dim, links):
    state = random_state(44, 4, dim, MEASURES[0], supports="pinned")
    if links:
        state = with_resting_anchors(linked_state(43, 5, dim, MEASURES[0], links))
    state = at_rest(state)
    expected = dense_largest_frequency(state)
    system, a = evaluated(state)
    tracker = FrequencyTracker(system, state.q.shape)
    first = tracker.frequency(state.q, a)
    assert 0.9 * expected < first <= expected * (1.0 + 1e-9)
    errors = []
    for _ in range(4):
        a = evaluated_again(system, state)
        errors.append(abs(tracker.frequency(state.q, a) / expected - 1.0))
    assert errors[-1] < 0.02 and errors[-1] <= errors[0]


def evaluated_again(system, state):
    a, rate = np.zeros(state.q.size), np.zeros(state.q.size)
    index_reduced_rates(system, state.inputs, state.q.ravel(), state.v.ravel(), a, rate)
    return a.reshape(state.q.shape)


def test_tracker_recovers_from_a_state_that_is_no_number():
    state = at_rest(random_state(44, 4, 2, MEASURES[0], supports="pinned"))
    system, a = evaluated(state)
    tracker = FrequencyTracker(system, state.q.shape)
    good = tracker.frequency(state.q, a)
    assert np.isnan(tracker.frequency(state.q, a * np.nan))
    assert tracker.frequency(state.q, evaluated_again(system, state)) == pytest.approx(good, rel=1e-9)


def test_a_cable_that_cannot_move_has_no_frequency():
    for number in (1, 2):
        held = straight_cable(number, 2, fixed=np.ones((number + 1, 2), dtype=bool), length_constraints=0)
        system = cable_system(held, 0.0)
        q = held.reference
        assert largest_frequency(system, np.zeros(q.size), q) == 0.0
        system, a = evaluated(replace(random_state(1, number, 2, MEASURES[0]), cable=held, q=q, v=0.0 * q))
        assert FrequencyTracker(system, q.shape).frequency(q, 0.0 * a) == 0.0


@pytest.mark.parametrize("number", [1, 2, 3])
def test_frequencies_that_occur_twice_are_found_like_those_that_occur_once(number):
    """A straight cable vibrates alike in both planes: the Lanczos recursion ends halfway."""
    found = []
    for dim in DIMENSIONS:
        q = straight_cable(number, dim).reference
        system = cable_system(straight_cable(number, dim), 0.0)
        found.append(largest_frequency(system, np.zeros(q.size), q))
    assert found[1] == pytest.approx(found[0], rel=1e-6)
    assert found[0] > 10.0


def test_a_cable_that_is_pushed_until_nothing_vibrates_has_no_frequency():
    cable = straight_cable(1, 2, "clamped")
    push = np.zeros(cable.reference.shape)
    push[1, 0, 0] = 1.0
    frequencies = [
        largest_frequency(cable_system(cable, 0.0), -size * push.ravel(), cable.reference)
        for size in (0.0, 1e6)
    ]
    assert frequencies[0] > 1.0
    assert frequencies[1] == 0.0


def test_a_configuration_that_is_no_number_has_no_frequency():
    state = at_rest(random_state(44, 4, 2, MEASURES[0], supports="pinned"))
    q = state.q.copy()
    q[2, 1, 0] = np.nan
    assert np.isnan(largest_frequency(cable_system(state.cable, 0.0), state.inputs, q))


PULLED = slice(None), slice(0, 1), slice(2, 4), slice(-1, None)  # nodes


def on_nodes(nodes, force):
    """What acts on these alone."""
    alone = np.zeros_like(force)
    alone[nodes] = force[nodes]
    return alone


def response(system, force):
    x = np.full(force.shape, np.nan)
    respond(called(system, respond), 0, force.ravel(), x.reshape(-1))
    return x


@both_dimensions
def test_responses_of_a_cable_that_stretches_to_forces_on_single_nodes_add_up(dim):
    state = random_state(44, 5, dim, MEASURES[0], supports="pinned")
    section = replace(state.cable.section, axial_stiffness=1e3)
    system, _ = evaluated(replace(state, cable=replace(state.cable, section=section)))
    force = np.random.default_rng(45).standard_normal(state.q.shape)
    alone = [response(system, on_nodes(slice(k, k + 1), force)) for k in range(6)]
    assert relative_error(sum(alone), response(system, force)) < 1e-12
    assert all(np.abs(x).max() > 1e-3 * np.abs(sum(alone)).max() for x in alone)


@both_dimensions
@pytest.mark.parametrize("links", [None, "closed", "rod", "moving hanger, rod and node"])
def test_responses_and_mass_are_those_of_the_dense_system(dim, links):
    state = (
        linked_state(43, 5, dim, MEASURES[0], links) if links else random_state(44, 5, dim, MEASURES[0], 3)
    )
    system, _ = evaluated(state)
    rng = np.random.default_rng(45)
    force = rng.standard_normal(state.q.shape)
    jacobian = dense_constraints(state.cable, state.q, state.v, state.time).jacobian
    mass, zero = dense_mass(state.cable), np.zeros((len(jacobian), len(jacobian)))
    matrix = np.block([[mass, jacobian.T], [jacobian, zero]])
    for nodes in PULLED:
        x = response(system, on_nodes(nodes, force))
        assert not state.cable.closed or (x[-1] == x[0]).all()
        given = np.concatenate([on_nodes(nodes, force).ravel(), np.zeros(len(jacobian))])
        assert relative_error(x.ravel(), np.linalg.solve(matrix, given)[: x.size]) < 1e-10
    image = apply_mass(build_chain(state.cable), force)
    assert relative_error(image.ravel(), mass @ force.ravel()) < 1e-12


@both_dimensions
@pytest.mark.parametrize("links", ["rod", "hanger", "moving node"])
def test_stiffness_of_links_is_the_derivative_of_their_jacobian(dim, links):
    """sum nu d2c/dq2 x, and it is added; linear links have none."""
    state = linked_state(43, 5, dim, MEASURES[0], links)
    system, _ = evaluated(state)
    rng, number = np.random.default_rng(46), len(state.cable.links)
    multiplier, x = rng.standard_normal(number), rng.standard_normal(state.q.shape)
    y = np.ones(state.q.shape)
    add_link_stiffness(system.link_system.links, multiplier, x, y)

    def jacobian(q):
        return dense_constraints(state.cable, q, state.v, state.time).jacobian[-number:]

    expected = multiplier @ (jacobian(state.q + x) - jacobian(state.q - x)) / 2.0
    np.testing.assert_allclose(y.ravel() - 1.0, expected, atol=1e-11)
    assert links == "moving node" or np.abs(expected).max() > 1e-2
