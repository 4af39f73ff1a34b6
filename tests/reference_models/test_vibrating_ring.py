"""Vibrating ring: data, natural frequencies of the native ring, and its motion against the reference."""

import dataclasses
import json
from importlib.resources import files

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from exudyn_inext.errors import InputError
from reference_models.conventional.cases import native_case
from reference_models.conventional.model import build
from reference_models.conventional.settings import Explicit, Implicit
from reference_models.conventional.solve import solve
from reference_models.data import reference_trajectory
from reference_models.model import sensor_trajectory
from reference_models.scenes import Pin, load_scene

RING = load_scene("vibrating_ring")
SHORT = dataclasses.replace(RING, end_time=0.3)


def largest_error(trajectory):
    reference = reference_trajectory(RING)
    spline = CubicSpline(reference.times, reference.positions)
    return np.linalg.norm(trajectory.positions - spline(trajectory.times), axis=1).max()


def test_the_scene_is_that_of_the_reference():
    text = files("reference_models.data").joinpath("vibrating_ring.json").read_text("utf-8")
    parameters, section = json.loads(text)["parameters"], RING.cable.section
    assert RING.cable.shape.radius == parameters["ring_radius"]
    assert section.mass_per_length == pytest.approx(parameters["rhoA"], rel=1e-12)
    assert section.bending_stiffness == pytest.approx(parameters["EI"], rel=1e-12)
    assert RING.loads[0].force == (parameters["F0"], 0.0, 0.0)
    assert RING.loads[0].history.angular_frequency == pytest.approx(parameters["omega"])


def test_the_reference_starts_on_the_circle_at_the_scene_s_main_point():
    reference = reference_trajectory(RING)
    positions, _ = RING.cable.nodes(4)
    np.testing.assert_allclose(reference.positions[0], positions[0], atol=1e-12)
    assert np.all(reference.positions[:, 2] == 0.0)


def test_the_forces_balance_at_all_times():
    for time in (0.0, 0.013, 0.5):
        total = np.sum([load.value(time) for load in RING.loads], axis=0)
        np.testing.assert_allclose(total, 0.0, atol=1e-12)


def test_the_last_element_joins_the_first_node():
    model = build(RING, 8)
    assert model.nodes[0] == model.nodes[-1]
    assert len(set(model.nodes)) == 8


@pytest.mark.parametrize("stress_free, tolerance", [("shape", 2e-3), ("straight", 2e-2)])
def test_lowest_frequencies_are_those_of_an_inextensible_ring(stress_free, tolerance):
    """w^2 = n^2 (n^2 - 1)^2 / (n^2 + 1) EI / (rho_A R^4), each twice, after three rigid motions.

    Bent from straight, native elements are no longer in equilibrium on the circle, which costs accuracy.
    """
    cable = dataclasses.replace(RING.cable, stress_free=stress_free)
    model = build(dataclasses.replace(RING, cable=cable), 24, "lobatto")
    squares, _ = model.mbs.ComputeODE2Eigenvalues()
    section, radius = cable.section, cable.shape.radius
    unit = section.bending_stiffness / (section.mass_per_length * radius**4)
    exact = [n**2 * (n**2 - 1) ** 2 / (n**2 + 1) * unit for n in (2, 2, 3, 3)]
    np.testing.assert_allclose(np.sort(squares)[3:7], exact, rtol=tolerance)


def test_twenty_lobatto_elements_follow_the_reference_over_the_whole_run():
    assert largest_error(native_case(RING, 20, Implicit(1e-3), "lobatto").prepare()()) < 1e-3


def test_both_forces_act_and_the_centre_stays():
    model = build(SHORT, 8, "lobatto")
    first = solve(model, Implicit(2e-3)).positions
    second = sensor_trajectory(model, "N2").positions
    assert np.ptp(first[:, 0]) > 0.02
    np.testing.assert_allclose(first[:, :2], -second[:, :2], atol=1e-8)


def test_velocity_verlet_agrees_with_generalized_alpha():
    implicit = native_case(SHORT, 8, Implicit(5e-4), "lobatto").prepare()()
    explicit = native_case(SHORT, 8, Explicit(5e-5), "lobatto").prepare()()
    np.testing.assert_allclose(explicit.positions, implicit.positions, atol=1e-4)


def test_rings_that_do_not_close_or_have_too_few_elements_are_refused():
    with pytest.raises(InputError, match=r"length = 3\.0 m does not close a circle of radius 0\.5"):
        dataclasses.replace(RING.cable, length=3.0)
    with pytest.raises(InputError, match=r"elements = 2.*at least 3"):
        build(RING, 2)


def test_a_curved_cable_out_of_the_plane_is_refused():
    with pytest.raises(InputError, match="curved in the x-y plane only"):
        build(dataclasses.replace(RING, gravity=(0.0, 0.0, -9.81), supports=(Pin(at=0.0),)), 8)
