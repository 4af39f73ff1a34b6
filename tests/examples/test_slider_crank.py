"""The slider-crank: twin, joints, energy, and the kinematics of a rigid connecting rod."""

import numpy as np
import pytest

from examples import slider_crank
from tests.examples.measures import gaps, total_energy
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

TWIN = Twin(end_time=1.0, step=1e-3, axial=1e7)


@pytest.fixture(scope="module")
def run():
    return run_inextensible(slider_crank, TWIN.end_time)


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(slider_crank, TWIN)) < 1e-3


def test_the_joints_hold_to_a_micrometre(run):
    assert max(gaps(run)) < 1e-6
    flywheel, slider = run[1].bodies
    assert np.abs(flywheel.position).max() < 1e-6
    assert np.abs(slider.position[:, 0]).max() < 1e-6
    assert np.abs(slider.rotation - np.eye(3)).max() < 1e-6


def energy_error(run):
    """Largest change of the energy over the range of the kinetic energy."""
    inertias = [slider_crank.FLYWHEEL, slider_crank.SLIDER]
    kinetic, total = total_energy(
        run, [(slider_crank.LENGTH, slider_crank.CABLE)], inertias, slider_crank.GRAVITY
    )
    return np.abs(total - total[0]).max() / np.ptp(kinetic)


def test_energy_stays_what_it_was(run):
    assert energy_error(run) < 1e-2


def test_the_taut_cable_moves_the_slider_as_a_rigid_rod_does(run):
    flywheel, slider = run[1].bodies
    x, y = slider_crank.CRANK * flywheel.rotation[:, 0, 1], slider_crank.CRANK * flywheel.rotation[:, 1, 1]
    expected = y - np.sqrt(slider_crank.LENGTH**2 - x**2)
    stroke = np.ptp(expected)
    assert stroke > 1.9 * slider_crank.CRANK
    np.testing.assert_allclose(slider.position[:, 1] + 0.05, expected, atol=5e-3 * stroke)
