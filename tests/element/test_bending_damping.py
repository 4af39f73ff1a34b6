"""Bending damping dissipates D int kappa_t^2 dx, and leaves rigid motions alone."""

import numpy as np
import pytest

from exudyn_inext.element.bending_damping import (
    add_damping_force,
    add_stretched_damping_force,
    damping_table,
    set_curvature_row,
)
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    arc,
    curvature_rates,
    damping_force,
    dense_form,
    opening_arc,
    random_state,
    relative_error,
    stiffness_matrix,
    straight_cable,
    with_section,
)

pytestmark = pytest.mark.kernel

DAMPING = 0.3

both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def found_force(cable, q, v):
    """(n, 2, dim) of the package, element by element."""
    force = np.zeros(q.shape)
    axes = tuple(range(cable.dimension))
    memory = np.zeros((8, 3))
    for k, length in enumerate(cable.element_lengths):
        table = damping_table(length)
        table[:, 0] *= cable.section.bending_damping
        e, e_t = (np.array([x[k + 1, 0] - x[k, 0], x[k, 1], x[k + 1, 1]]) for x in (q, v))
        element = np.zeros((3, cable.dimension))
        add_damping_force(axes, table, e, e_t, memory, element)
        force[k] += [-element[0], element[1]]
        force[k + 1] += [element[0], element[2]]
    return force


def damped_state(seed, dim):
    return with_section(random_state(seed, 4, dim, MEASURES[0]), bending_damping=DAMPING)


@both_dimensions
@pytest.mark.parametrize("seed", range(3))
def test_force_is_the_quadrature_of_the_virtual_work(dim, seed):
    state = damped_state(seed, dim)
    expected = damping_force(state.cable, state.q, state.v)
    assert relative_error(found_force(state.cable, state.q, state.v), expected) < 1e-9


@both_dimensions
@pytest.mark.parametrize("seed", range(3))
def test_power_is_minus_the_integral_of_the_squared_rate_of_curvature(dim, seed):
    state = damped_state(seed, dim)
    rate, weight = curvature_rates(state.cable, state.q, state.v)
    power = (found_force(state.cable, state.q, state.v) * state.v).sum()
    assert power == pytest.approx(-DAMPING * weight @ (rate**2).sum(axis=1), rel=1e-9)


def test_rigid_motions_in_the_plane_are_not_damped():
    state = damped_state(4, 2)
    v = state.q @ np.array([[0.0, 1.3], [-1.3, 0.0]])
    v[:, 0] += [1.0, 2.0]
    bending = np.abs(found_force(state.cable, state.q, state.v)).max()
    assert np.abs(found_force(state.cable, state.q, v)).max() < 1e-13 * bending


def test_rigid_motions_in_space_are_damped_as_their_curvature_turns():
    """As in the native cable: kappa_t = w x kappa, of an arc that spins about w."""
    length, radius, number = 1.6, 0.8, 16
    cable = straight_cable(number, 3, length=length, section=damped_state(0, 3).cable.section)
    q = arc(length, number, radius, 3)
    for w, expected in (([0.0, 0.0, 2.0], 0.0), ([2.0, 0.0, 0.0], 4.0), ([0.0, 1.0, 2.0], 1.0)):
        v = np.cross(w, q)
        v[:, 0] += [1.0, 2.0, 3.0]
        power = (found_force(cable, q, v) * v).sum()
        assert power == pytest.approx(-DAMPING * length / radius**2 * expected, rel=1e-3, abs=1e-12)


def test_straight_planar_cable_is_damped_as_a_beam_is():
    state = with_section(random_state(5, 4, 2, MEASURES[0]), bending_damping=DAMPING)
    cable = straight_cable(4, 2, section=state.cable.section)
    force = found_force(cable, cable.reference, state.v)
    expected = -DAMPING * (dense_form(cable, stiffness_matrix) @ state.v.ravel()).reshape(state.v.shape)
    np.testing.assert_allclose(force[..., 1], expected[..., 1], atol=1e-12)
    np.testing.assert_allclose(force[..., 0], 0.0, atol=1e-12)


def test_straight_spatial_cable_gives_finite_values():
    state = damped_state(6, 3)
    cable = straight_cable(4, 3, section=state.cable.section)
    assert np.isfinite(found_force(cable, cable.reference, state.v)).all()


def test_planar_motion_in_space_is_damped_as_in_the_plane():
    state = damped_state(7, 2)
    q, v = (np.pad(x, ((0, 0), (0, 0), (0, 1))) for x in (state.q, state.v))
    cable = straight_cable(4, 3, section=state.cable.section, element_lengths=state.cable.element_lengths)
    force = found_force(cable, q, v)
    assert relative_error(force[..., :2], found_force(state.cable, state.q, state.v)) < 1e-12
    assert not force[..., 2].any()


@both_dimensions
def test_power_of_an_opening_arc_converges_to_the_exact_one(dim):
    length, radius = 1.6, 0.8
    exact = -DAMPING * length / radius**4  # -D L kappa_t^2 at R_t = 1
    errors = []
    for number in (4, 8, 16):
        opening = opening_arc(length, number, radius, dim)
        cable = straight_cable(number, dim, length=length, section=damped_state(0, dim).cable.section)
        power = (found_force(cable, arc(length, number, radius, dim), opening) * opening).sum()
        errors.append(abs(power / exact - 1.0))
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > 1.9
    assert errors[-1] < 1e-2


@both_dimensions
def test_rows_of_the_curvature_give_the_force_of_a_stretched_element(dim):
    """F = -sum over points of w b (b . e_t), with a row b for each component of kappa."""
    random, table, memory = np.random.default_rng(dim), damping_table(0.4), np.zeros((7, 3))
    axes, row, force, expected = tuple(range(dim)), np.zeros((3, dim)), np.zeros((3, dim)), np.zeros((3, dim))
    e, e_t = random.normal(size=(2, 3, dim))
    e[:, 0] += 2.0
    add_stretched_damping_force(axes, table, e, e_t, memory, force)
    for point in table:
        for component in range(2 if dim == 2 else 0, 3):
            set_curvature_row(axes, point, component, e, memory, row)
            expected -= point[0] * row * (row * e_t).sum()
    np.testing.assert_allclose(force, expected, rtol=1e-12)
