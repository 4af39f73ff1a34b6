"""Native cables: known accuracy at known settings, planar and spatial, and clear refusals."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from exudyn_inext.errors import DivergenceError, InputError
from reference_models.conventional.cases import native_case
from reference_models.conventional.model import build
from reference_models.conventional.settings import (
    Explicit,
    Implicit,
    number_of_steps,
    simulation_settings,
)
from reference_models.conventional.solve import solve
from reference_models.data import reference_trajectory
from reference_models.scenes import Clamp, load_scene

PENDULUM = load_scene("planar_pendulum")
SHORT = dataclasses.replace(PENDULUM, end_time=0.5)


def largest_error(trajectory):
    reference = reference_trajectory(PENDULUM)
    spline = CubicSpline(reference.times, reference.positions)
    return np.linalg.norm(trajectory.positions - spline(trajectory.times), axis=1).max()


def test_ten_elements_implicit_have_their_known_error():
    trajectory = native_case(PENDULUM, 10, Implicit(7e-3, "full")).prepare()()
    assert largest_error(trajectory) == pytest.approx(5.8e-3, rel=0.03)


def test_lobatto_quadrature_needs_half_the_elements():
    trajectory = native_case(PENDULUM, 5, Implicit(2e-3), "lobatto").prepare()()
    assert largest_error(trajectory) < 7e-3


@pytest.mark.parametrize("newton", ["full", "modified", "modifiedEachStep"])
@pytest.mark.parametrize("linear_solver", ["dense", "sparse"])
def test_newton_and_linear_solver_do_not_change_the_motion(newton, linear_solver):
    plain = solve(build(SHORT, 6), Implicit(5e-3, relative_tolerance=1e-8))
    other = solve(build(SHORT, 6), Implicit(5e-3, newton, linear_solver, 1e-8))
    np.testing.assert_allclose(other.positions, plain.positions, atol=1e-6)


def test_trapezoidal_rule_agrees_with_generalized_alpha_at_small_steps():
    alpha = solve(build(SHORT, 8), Implicit(1e-3))
    trapezoidal = solve(build(SHORT, 8), Implicit(1e-3, integrator="trapezoidal"))
    np.testing.assert_allclose(trapezoidal.positions, alpha.positions, atol=1e-4)


def test_a_spring_pin_holds_as_a_constraint_does():
    constrained = solve(build(SHORT, 6), Implicit(5e-4))
    sprung = solve(build(SHORT, 6, pin_stiffness=1e5), Implicit(5e-4))
    np.testing.assert_allclose(sprung.positions, constrained.positions, atol=5e-5)


def test_velocity_verlet_with_spring_pin_agrees_with_implicit():
    """The trap: with an eliminated CoordinateConstraint the tip is 1.8e-2 m off after 0.5 s."""
    implicit = native_case(SHORT, 6, Implicit(5e-4)).prepare()()
    explicit = native_case(SHORT, 6, Explicit(3e-5)).prepare()()
    assert abs(largest_error(explicit) - largest_error(implicit)) < 1e-4


def test_a_turned_pendulum_in_space_moves_as_the_planar_one():
    """Gravity along -z makes the scene spatial (ANCFCable), with the same motion in x-z."""
    turned = dataclasses.replace(SHORT, gravity=(0.0, 0.0, -9.81))
    assert not turned.is_planar
    spatial = solve(build(turned, 6), Implicit(2e-3)).positions
    planar = solve(build(SHORT, 6), Implicit(2e-3)).positions
    np.testing.assert_allclose(spatial[:, [0, 2, 1]], planar, atol=1e-5)


def test_initial_velocity_grows_linearly_to_the_free_end():
    moving = dataclasses.replace(SHORT, gravity=(0.0, 0.0, 0.0), end_velocity=(0.0, 3.0, 0.0), end_time=0.01)
    trajectory = solve(build(moving, 4), Implicit(1e-3))
    assert trajectory.positions[-1, 1] == pytest.approx(0.03, rel=1e-3)


def test_a_clamp_holds_the_slope():
    clamped = dataclasses.replace(SHORT, supports=(Clamp(at=0.0),), observe={"near": 0.1})
    near = solve(build(clamped, 10), Implicit(2e-3)).positions[-1]
    free = solve(build(dataclasses.replace(SHORT, observe={"near": 0.1}), 10), Implicit(2e-3))
    assert abs(near[1]) < 0.5 * abs(free.positions[-1, 1])


def test_the_tip_is_sampled_at_100_hertz():
    trajectory = solve(build(SHORT, 4), Implicit(5e-3))
    np.testing.assert_allclose(trajectory.times, np.arange(51) * 0.01, atol=1e-9)


def test_steps_fit_the_end_time():
    assert number_of_steps(7e-3, 5.0) == 714
    case = native_case(PENDULUM, 4, Implicit(7e-3))
    assert case.steps * case.step_size == pytest.approx(5.0)


@pytest.mark.parametrize("elements", [0, -3, 2.0, True])
def test_a_mesh_without_elements_is_refused(elements):
    with pytest.raises(InputError, match=r"elements = .* integer of at least 1"):
        build(PENDULUM, elements)


@pytest.mark.parametrize("step_size", [0.0, -1e-3, float("nan")])
def test_an_impossible_step_is_refused(step_size):
    with pytest.raises(InputError, match="step_size = "):
        number_of_steps(step_size, 5.0)


def test_points_between_nodes_unknown_quadratures_and_sprung_clamps_are_refused():
    with pytest.raises(InputError, match="is no node of 5 equal elements"):
        build(dataclasses.replace(PENDULUM, observe={"middle": 0.5}), 5)
    with pytest.raises(InputError, match=r"quadrature = 'best'.*lobatto"):
        build(PENDULUM, 5, "best")
    with pytest.raises(InputError, match="clamp cannot be held by the spring"):
        build(dataclasses.replace(PENDULUM, supports=(Clamp(at=0.0),)), 5, pin_stiffness=1e5)


def test_a_run_that_exudyn_gives_up_is_a_divergence(monkeypatch, capfd):
    def one_iteration_only(solver, end_time):
        settings = simulation_settings(solver, end_time)
        settings.timeIntegration.newton.maxIterations = 1
        return settings

    monkeypatch.setattr("reference_models.conventional.solve.simulation_settings", one_iteration_only)
    with pytest.raises(DivergenceError, match="use a smaller step"):
        solve(build(SHORT, 4), Implicit(5e-3))
    assert capfd.readouterr().out == ""
