"""What every kind of constraint must fulfil, on cables with every kind of support."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.link import rest
from exudyn_inext.cable.links import CLOSURE
from exudyn_inext.constraints import constraints_of_cable, distance, prescribed_motion
from exudyn_inext.constraints.kinds import HELD
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


def held_state(dim):
    """One coordinate of a position is held."""
    state = random_state(13, NUMBER, dim, MEASURES[0], NUMBER, "free")
    links = prescribed_motion.prescribed(2, rest(state.q[2, 0] + 0.01), [1])
    return replace(state, cable=replace(state.cable, links=tuple(links)))


def all_constraints():
    for dim in DIMENSIONS:
        for state in (*states(dim), *linked_states(dim), held_state(dim)):
            yield state, constraints_of_cable(state.cable)


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
    names = {name for _, constraints in all_constraints() for name in constraints.rows}
    links = {CLOSURE, distance.KIND, *prescribed_motion.KINDS}
    assert names == {*HELD, "length", "nodal inextensibility", *links}


def test_jacobian_is_the_derivative_of_the_value():
    for state, constraints in all_constraints():
        columns = []
        for unit in np.eye(state.q.size):
            change = STEP * unit.reshape(state.q.shape)
            above, below = (constraints.value(state.q + s * change, state.time) for s in (1, -1))
            columns.append((above - below) / (2 * STEP))
        jacobian = constraints.jacobian(state.q, state.time).toarray()
        np.testing.assert_allclose(jacobian, np.array(columns).T, atol=1e-10)


def test_hessian_is_the_derivative_of_the_jacobian_weighted_with_multipliers():
    rng = np.random.default_rng(7)
    for state, constraints in all_constraints():
        multipliers = rng.standard_normal(constraints.number)
        columns = []
        for unit in np.eye(state.q.size):
            change = unit.reshape(state.q.shape)  # the Jacobian is linear in q: differences are exact
            above, below = (constraints.jacobian(state.q + s * change, state.time) for s in (1, -1))
            columns.append(0.5 * (above - below).T @ multipliers)
        hessian = constraints.hessian(multipliers).toarray()
        np.testing.assert_allclose(hessian, np.array(columns).T, atol=1e-12)


def test_rate_is_the_derivative_along_the_velocity_and_in_time():
    for state, constraints in all_constraints():
        steps = (STEP, -STEP)
        above, below = (constraints.value(state.q + s * state.v, state.time + s) for s in steps)
        found = constraints.rate(state.q, state.v, state.time)
        np.testing.assert_allclose(found, (above - below) / (2 * STEP), atol=1e-7)


def test_gamma_is_minus_the_second_derivative_along_the_velocity_and_in_time():
    for state, constraints in all_constraints():
        steps = (STEP, -STEP)
        above, below = (constraints.rate(state.q + s * state.v, state.v, state.time + s) for s in steps)
        expected = -(above - below) / (2 * STEP)
        found = constraints.gamma(state.q, state.v, state.time)
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_sizes_agree_with_the_number_of_equations():
    for state, constraints in all_constraints():
        number = constraints.number
        assert constraints.value(state.q).shape == (number,)
        assert constraints.gamma(state.q, state.v).shape == (number,)
        assert constraints.rate(state.q, state.v).shape == (number,)
        assert constraints.jacobian(state.q).shape == (number, state.q.size)


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_number_of_equations_by_kind(dim):
    for state in states(dim):
        rows = constraints_of_cable(state.cable).rows
        numbers = {name: len(own) for name, own in rows.items()}
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
    for state, constraints in all_constraints():
        for name in constraints.rows.keys() - {"nodal inextensibility"} if not state.cable.links else ():
            value = constraints.value(state.cable.reference)[constraints.rows[name]]
            np.testing.assert_allclose(value, 0.0, atol=1e-13)


def test_every_row_has_its_own_description():
    names = [f"N{node}" for node in range(NUMBER + 1)]
    for _, constraints in all_constraints():
        places = [constraints.describe(row, names) for row in range(constraints.number)]
        assert len(set(places)) == constraints.number
        assert all("node" in text and any(name in text for name in names) for _, text in places)
