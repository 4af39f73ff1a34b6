"""The O(N) solve gives what a dense solve of the saddle-point system (29) gives."""

import numpy as np
import pytest

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.frequency import nodal_multipliers_of
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.cable.saddle_point import apply_mass
from exudyn_inext.system import accelerate_and_project, correct_position
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    SUPPORTS,
    dense_constraints,
    dense_mass,
    dense_rates,
    random_state,
    relative_error,
    structured_rates,
)

ZETA = 5.0
TOLERANCE = 1e-11
LENGTH_CONSTRAINTS = {
    "none": lambda number: 0,
    "one": lambda number: 1,
    "half": lambda number: number // 2,
    "all": lambda number: number,
}

both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)
both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)
all_supports = pytest.mark.parametrize("supports", SUPPORTS)


def moves(cable):
    """Whether the constraints leave a motion."""
    held = cable.dimension * cable.fixed.sum()
    rows = held + (~cable.fixed[:, 1]).sum() + cable.length_constraints
    return rows < cable.reference.size


def compare(state, mass_scaling=0.0):
    """Structured and dense solution agree: both columns of Eq. (29), coordinates and multipliers."""
    acceleration, rate, chain = structured_rates(state, ZETA, mass_scaling)
    expected, expected_rate, lam, mu, constraints = dense_rates(state, ZETA, mass_scaling)
    assert relative_error(acceleration, expected) < TOLERANCE
    assert relative_error(rate, expected_rate) < TOLERANCE
    group = state.cable.group_of_element()
    if "length" in constraints.rows:
        for column, multipliers in enumerate((lam, mu)):
            length = multipliers[constraints.rows["length"]][group]
            found = chain.elements["multiplier"][:, column]
            assert np.abs(found - length).max() < TOLERANCE * np.abs(multipliers).max()
    nodal = nodal_multipliers_of(CableSystem(chain, 0.0), acceleration.reshape(state.q.shape))
    expected_nodal = np.zeros(len(state.q))
    expected_nodal[~state.cable.fixed[:, 1]] = lam[constraints.rows["nodal inextensibility"]]
    assert np.abs(nodal - expected_nodal).max() < TOLERANCE * np.abs(lam).max()


@pytest.mark.kernel
@both_measures
@both_dimensions
@all_supports
def test_small_chains_agree_with_the_dense_solve(measure, dim, supports):
    for number in (1, 2, 5):
        for n_bar in LENGTH_CONSTRAINTS.values():
            state = random_state(31, number, dim, measure, n_bar(number), supports)
            if moves(state.cable):
                compare(state)


@both_measures
@both_dimensions
@pytest.mark.parametrize("n_bar", LENGTH_CONSTRAINTS)
def test_chains_of_many_lengths_agree_with_the_dense_solve(measure, dim, n_bar):
    for number in (*range(1, 13), 21, 34):
        supports = list(SUPPORTS)[number % len(SUPPORTS)]
        groups = LENGTH_CONSTRAINTS[n_bar](number)
        state = random_state(32, number, dim, measure, groups, supports)
        if moves(state.cable):
            compare(state)


@both_measures
@both_dimensions
@all_supports
def test_long_chains_agree_with_the_dense_solve(measure, dim, supports):
    for n_bar in LENGTH_CONSTRAINTS.values():
        compare(random_state(33, 24, dim, measure, n_bar(24), supports))


@pytest.mark.kernel
@both_measures
@both_dimensions
def test_mass_scaling_adds_the_bending_stiffness_to_the_mass(measure, dim):
    for number, supports in enumerate(SUPPORTS, start=3):
        compare(random_state(37, number, dim, measure, supports=supports), mass_scaling=0.1)


@both_dimensions
@pytest.mark.kernel
def test_projection_of_positions_and_velocities_agrees_with_the_dense_solve(dim):
    duration = 0.05
    state = random_state(38, 6, dim, MEASURES[0], 3, "pinned")
    cable = state.cable
    q, v = state.q.ravel(), state.v.ravel()
    system = CableSystem(build_chain(cable), ZETA)
    a, end, correction = (np.zeros(q.size) for _ in range(3))
    accelerate_and_project(system, state.external.ravel(), q, v, duration, a, end)
    moved = state.q + 0.01 * state.v
    worst = correct_position(system, state.external.ravel(), moved.ravel(), 1e-10, 0.0, correction)

    expected, *_ = dense_rates(state, 0.0)
    assert relative_error(a, expected) < TOLERANCE
    c = dense_constraints(cable, state.q, state.v)
    mass = dense_mass(cable)
    response = np.linalg.solve(mass, c.jacobian.T)
    project = response @ np.linalg.inv(c.jacobian @ response)
    free = v + duration * expected
    assert relative_error(end, free - project @ (c.jacobian @ free)) < 1e-10
    value = dense_constraints(cable, moved, state.v).value
    assert relative_error(correction, -project @ value) < 1e-10
    assert worst >= 0.99 * np.abs(value[c.rows["nodal inextensibility"]]).max()


@pytest.mark.kernel
@both_dimensions
def test_slopes_in_all_directions_find_a_transverse_basis(dim):
    rng = np.random.default_rng(34)
    state = random_state(34, 5, dim, MEASURES[0])
    for slope in np.vstack([np.eye(dim), -np.eye(dim), rng.standard_normal((4, dim))]):
        # a half turn: the same cable seen from elsewhere, its first slope along `slope`
        bisector = slope / np.linalg.norm(slope) + state.q[0, 1] / np.linalg.norm(state.q[0, 1])
        if np.linalg.norm(bisector) < 1e-12:
            bisector = np.eye(dim)[1]
        turn = 2 * np.outer(bisector, bisector) / (bisector @ bisector) - np.eye(dim)
        turned = type(state)(state.cable, *(x @ turn for x in (state.q, state.v, state.external)))
        acceleration, rate, _ = structured_rates(turned, ZETA)
        expected, expected_rate, *_ = structured_rates(state, ZETA)
        shape = state.q.shape
        assert relative_error(acceleration.reshape(shape), expected.reshape(shape) @ turn) < 1e-10
        assert relative_error(rate.reshape(shape), expected_rate.reshape(shape) @ turn) < 1e-10


@pytest.mark.kernel
@both_dimensions
def test_multiplication_with_the_mass_matrix_takes_supports_out(dim):
    state = random_state(35, 4, dim, MEASURES[0], supports="clamped and pinned")
    free = np.repeat(~state.cable.fixed[:, :, None], dim, axis=2).ravel()
    expected = dense_mass(state.cable) * np.outer(free, free) + np.diag(1.0 - free)
    found = apply_mass(build_chain(state.cable), state.v + 1.0)
    assert relative_error(found.ravel(), expected @ (state.v + 1.0).ravel()) < 1e-13


@pytest.mark.kernel
def test_two_solves_of_one_chain_do_not_influence_each_other():
    state = random_state(36, 5, 2, MEASURES[0], supports="pinned")
    other = type(state)(state.cable, state.q * 1.1, -state.v, state.external + 1.0)
    once, _, _ = structured_rates(state, ZETA)
    structured_rates(other, ZETA)
    np.testing.assert_array_equal(structured_rates(state, ZETA)[0], once)
