"""What every kind of constraint must fulfil, on cables with every kind of support."""

import numpy as np
import pytest

from exudyn_inext.constraints import KINDS, constraints_of_cable
from tests.cables import (
    DIMENSIONS,
    LINKS,
    MEASURES,
    SUPPORTS,
    dense_constraints,
    linked_state,
    random_state,
)

NUMBER = 4
STEP = 1e-4

pytestmark = pytest.mark.kernel


def states(dim):
    for supports in SUPPORTS:
        for n_bar in (0, 1, 2, 3, NUMBER):
            yield random_state(11, NUMBER, dim, MEASURES[0], n_bar, supports)


def linked_states(dim):
    for links in LINKS:
        yield linked_state(12, NUMBER, dim, MEASURES[0], links)


def all_constraints():
    for dim in DIMENSIONS:
        for state in (*states(dim), *linked_states(dim)):
            for constraint in constraints_of_cable(state.cable):
                yield state, constraint


def expected_number(cable):
    """Rows by kind, counted by hand."""
    position, slope = cable.fixed.T
    return {
        "pin": cable.dimension * int((position & ~slope).sum()),
        "clamp": 2 * cable.dimension * int((position & slope).sum()),
        "guide": cable.dimension * int((~position & slope).sum()),
        "nodal inextensibility": int((~slope).sum()),
        "length": cable.length_constraints,
    }


def test_the_sweep_meets_every_kind():
    names = {constraint.name for _, constraint in all_constraints()}
    assert len(names) == len(KINDS)


def test_jacobian_is_the_derivative_of_the_value():
    for state, constraint in all_constraints():
        columns = []
        for unit in np.eye(state.q.size):
            change = STEP * unit.reshape(state.q.shape)
            above, below = (constraint.value(state.q + s * change, state.time) for s in (1, -1))
            columns.append((above - below) / (2 * STEP))
        jacobian = constraint.jacobian(state.q, state.time).toarray()
        np.testing.assert_allclose(jacobian, np.array(columns).T, atol=1e-10)


def test_hessian_is_the_derivative_of_the_jacobian_weighted_with_multipliers():
    rng = np.random.default_rng(7)
    for state, constraint in all_constraints():
        multipliers = rng.standard_normal(constraint.number)
        columns = []
        for unit in np.eye(state.q.size):
            change = unit.reshape(state.q.shape)  # the Jacobian is linear in q: differences are exact
            above, below = (constraint.jacobian(state.q + s * change, state.time) for s in (1, -1))
            columns.append(0.5 * (above - below).T @ multipliers)
        hessian = constraint.hessian(multipliers, state.q.shape).toarray()
        np.testing.assert_allclose(hessian, np.array(columns).T, atol=1e-12)


def test_rate_is_the_derivative_along_the_velocity_and_in_time():
    for state, constraint in all_constraints():
        steps = (STEP, -STEP)
        above, below = (constraint.value(state.q + s * state.v, state.time + s) for s in steps)
        found = constraint.rate(state.q, state.v, state.time)
        np.testing.assert_allclose(found, (above - below) / (2 * STEP), atol=1e-7)


def test_gamma_is_minus_the_second_derivative_along_the_velocity_and_in_time():
    for state, constraint in all_constraints():
        steps = (STEP, -STEP)
        above, below = (constraint.rate(state.q + s * state.v, state.v, state.time + s) for s in steps)
        expected = -(above - below) / (2 * STEP)
        found = constraint.gamma(state.q, state.v, state.time)
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_sizes_agree_with_the_number_of_equations():
    for state, constraint in all_constraints():
        number = constraint.number
        assert constraint.value(state.q).shape == (number,)
        assert constraint.gamma(state.q, state.v).shape == (number,)
        assert constraint.rate(state.q, state.v).shape == (number,)
        assert constraint.jacobian(state.q).shape == (number, state.q.size)


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_number_of_equations_by_kind(dim):
    for state in states(dim):
        numbers = {c.name: c.number for c in constraints_of_cable(state.cable)}
        expected = {name: count for name, count in expected_number(state.cable).items() if count}
        assert numbers == expected


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_constraints_are_independent_on_a_slack_cable(dim):
    for state in states(dim):
        jacobian = dense_constraints(state.cable, state.q, state.v).jacobian
        singular = np.linalg.svd(jacobian, compute_uv=False)
        assert len(jacobian) < state.q.size
        assert singular[-1] > 1e-3 * singular[0]


def test_the_reference_configuration_fulfils_supports_and_lengths():
    for state, constraint in all_constraints():
        if constraint.name != "nodal inextensibility" and not state.cable.links:
            value = constraint.value(state.cable.reference)
            np.testing.assert_allclose(value, 0.0, atol=1e-13)


def test_every_row_has_its_own_description():
    names = [f"N{node}" for node in range(NUMBER + 1)]
    for _, constraint in all_constraints():
        texts = [constraint.describe(row, names) for row in range(constraint.number)]
        assert len(set(texts)) == constraint.number
        assert all("node" in text and any(name in text for name in names) for text in texts)
