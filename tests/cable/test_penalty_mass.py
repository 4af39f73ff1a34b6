"""Very large penalties give the accelerations of the exact constraints; rows are those of the formulas."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.cable import CurvatureMeasure
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.constraint_rows import (
    build_rows,
    constraint_jacobian,
    constraint_values,
    unconstrained_force,
)
from exudyn_inext.cable.penalty_mass import build_penalty_system, penalty_force, penalty_mass
from tests.cables import (
    bending_force,
    damping_force,
    dense_constraints,
    dense_mass,
    linked_state,
    random_state,
    refined_solve,
    relative_error,
    straight_cable,
    with_section,
)

pytestmark = pytest.mark.kernel

Z = 3.0
PLANAR, SPATIAL = (2, CurvatureMeasure.SECOND_DERIVATIVE), (3, CurvatureMeasure.PRODUCT)
KINDS = pytest.mark.parametrize(("dim", "measure"), [PLANAR, SPATIAL], ids=["planar", "spatial"])


def split(cable):
    """The cable without supports, and what they hold (n, 2, dim)."""
    held = np.repeat(cable.fixed[:, :, None], cable.dimension, axis=2)
    return replace(cable, fixed=np.zeros_like(cable.fixed)), held


def moved_supports(state):
    """The same state, violating its supports as well."""
    rng = np.random.default_rng(1)
    noise = 0.01 * rng.standard_normal((2, *state.q.shape))
    if state.cable.closed:
        noise[:, -1] = noise[:, 0]
    return replace(state, q=state.q + noise[0], v=state.v + noise[1])


def exact_acceleration(state):
    """(n_dof,) of the saddle-point system M a + J^T lam = F, J a = gamma - 2 z C' - z^2 C."""
    c = dense_constraints(state.cable, state.q, state.v)
    force = state.external + bending_force(state.cable, state.q)
    matrix = np.block([[dense_mass(state.cable), c.jacobian.T], [c.jacobian, np.zeros((len(c.value),) * 2)]])
    right = np.append(force.ravel(), c.gamma - 2.0 * Z * c.rate - Z**2 * c.value)
    return refined_solve(matrix, right[:, None])[: state.q.size, 0]


def penalty_acceleration(state, penalty):
    """(n_dof,) of (M + k J^T J) a = F + k J^T (gamma - 2 z C' - z^2 C)."""
    cable, held = split(state.cable)
    system = build_penalty_system(cable, held, penalty, Z)
    force, mass = np.zeros(state.q.shape), np.zeros(state.q.shape * 2)
    penalty_force(system, state.external, state.q, state.v, force)
    penalty_mass(system, state.q, mass)
    size = state.q.size
    own = size - 2 * cable.dimension * cable.closed
    repeated = np.eye(own)[np.arange(size) % own]  # coordinates that belong to the same node twice
    matrix, right = repeated.T @ mass.reshape(size, size) @ repeated, repeated.T @ force.ravel()
    return repeated @ refined_solve(matrix, right[:, None])[:, 0]


STATES = {
    "free": lambda dim, measure: random_state(1, 4, dim, measure),
    "one length constraint": lambda dim, measure: random_state(2, 4, dim, measure, 1, "pinned"),
    "groups of elements": lambda dim, measure: random_state(3, 5, dim, measure, 2, "clamped"),
    "no length constraint": lambda dim, measure: random_state(4, 3, dim, measure, 0, "pinned and guided"),
    "both ends pinned": lambda dim, measure: random_state(5, 4, dim, measure, None, "both ends pinned"),
    "closed": lambda dim, measure: linked_state(6, 5, dim, measure, "closed"),
    "closed and pinned": lambda dim, measure: linked_state(7, 5, dim, measure, "closed and pinned", 1),
}


@KINDS
@pytest.mark.parametrize("name", STATES)
def test_the_acceleration_tends_to_the_exact_one_as_the_penalty_grows(dim, measure, name):
    """At random states that violate all constraints: a wrong factor of any term would remain."""
    state = moved_supports(STATES[name](dim, measure))
    exact = exact_acceleration(state)
    errors = [relative_error(penalty_acceleration(state, k), exact) for k in (1e3, 1e4, 1e5)]
    assert errors[0] < 0.02
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.1)


@KINDS
def test_the_mass_is_symmetric_and_larger_than_that_without_penalty(dim, measure):
    state = random_state(1, 4, dim, measure, None, "pinned")
    cable, held = split(state.cable)
    mass = np.zeros(state.q.shape * 2)
    penalty_mass(build_penalty_system(cable, held, 10.0, Z), state.q, mass)
    added = mass.reshape(state.q.size, -1) - dense_mass(cable)
    np.testing.assert_allclose(added, added.T, atol=1e-12)
    eigenvalues = np.linalg.eigvalsh(added)
    assert eigenvalues[0] > -1e-12
    rows = len(dense_constraints(state.cable, state.q, state.v).value)
    assert np.count_nonzero(eigenvalues > 1e-9) == rows


@KINDS
@pytest.mark.parametrize("n_bar", [0, 2, 5])
def test_rows_are_the_constraints_of_the_cable(dim, measure, n_bar):
    state = random_state(8, 5, dim, measure, n_bar, "pinned")
    cable, held = split(state.cable)
    rows = build_rows(cable, held)
    values, jacobian = np.zeros((2, rows.number)), np.zeros((rows.number, *state.q.shape))
    constraint_values(rows, state.q, state.v, values)
    constraint_jacobian(rows, state.q, jacobian)
    c = dense_constraints(cable, state.q, state.v)
    own = np.r_[c.rows["nodal inextensibility"], c.rows.get("length", slice(0, 0))]
    np.testing.assert_allclose(values, [c.value[own], c.rate[own]], atol=1e-13)
    np.testing.assert_allclose(jacobian.reshape(rows.number, -1), c.jacobian[own], atol=1e-13)


def test_rows_of_clamped_nodes_and_of_the_second_end_of_a_ring_are_left_out():
    clamped = split(random_state(8, 4, *PLANAR, None, "clamped and pinned").cable)
    assert build_rows(*clamped).nodal.tolist() == [1, 2, 3, 4]
    closed = split(linked_state(8, 4, *PLANAR, "closed").cable)
    assert build_rows(*closed).nodal.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_unconstrained_force_is_that_of_load_bending_and_damping(damping):
    state = with_section(random_state(9, 3, *PLANAR), bending_damping=damping)
    force = np.zeros(state.q.shape)
    cable, _ = split(state.cable)
    unconstrained_force(build_chain(cable), state.external, state.q, state.v, force)
    expected = state.external + bending_force(cable, state.q) + damping_force(cable, state.q, state.v)
    np.testing.assert_allclose(force, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("closed", [False, True])
def test_penalties_are_relative_to_the_elements_masses(closed):
    """k rho_A l of a length or position, k rho_A l^3 of a slope: means of neighbours, and over groups."""
    cable = straight_cable(3, 2, closed=closed, length_constraints=2)
    lengths = np.array([1.0, 2.0, 4.0])
    cable = replace(cable, element_lengths=lengths, section=replace(cable.section, mass_per_length=3.0))
    held = np.zeros((4, 2, 2), dtype=bool)
    held[1] = [[True, False], [True, True]]
    held[3] = [[True, True], [False, True]]
    system = build_penalty_system(cable, held, 10.0, 5.0)
    np.testing.assert_allclose(system.length, 30.0 * np.array([1.5, 1.5, 4.0]))
    ends = (32.5, 32.5) if closed else (1.0, 64.0)
    of_slopes = 30.0 * np.array([ends[0], 4.5, 36.0, ends[1]])
    np.testing.assert_allclose(system.nodal, of_slopes * [1.0, 0.0, 1.0, 0.0 if closed else 1.0])
    of_last = 0.0 if closed else 1.0
    expected = np.zeros((4, 2, 2))
    expected[1] = [[30.0 * 1.5, 0.0], [30.0 * 4.5, 30.0 * 4.5]]
    expected[3] = [[of_last * 120.0, of_last * 120.0], [0.0, of_last * of_slopes[3]]]
    np.testing.assert_allclose(system.held, expected)
    assert system.z == 5.0
