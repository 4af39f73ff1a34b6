"""The crane: twin, joints, energy, and the momentum that the driving force gives."""

import numpy as np
import pytest

from examples import crane
from tests.examples.measures import cable_momentum, gaps, integral, total_energy
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

TWIN = Twin(end_time=1.0, step=1e-3, axial=1e7)


@pytest.fixture(scope="module")
def run():
    return run_inextensible(crane, TWIN.end_time)


def force_and_velocity(history):
    return np.array([crane.driving_force(None, t, None)[0] for t in history.t]), history.bodies[0].velocity


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(crane, TWIN)) < 1e-3


def test_the_joints_hold_to_a_micrometre(run):
    assert max(gaps(run)) < 1e-6
    guide = run[1].bodies[0]
    assert np.abs(guide.position[:, 1:]).max() < 1e-6
    assert np.abs(guide.rotation - np.eye(3)).max() < 1e-6


def energy_error(run):
    """Largest change of the energy that the force did not put in, over the range of the kinetic energy."""
    kinetic, total = total_energy(
        run, [(crane.LENGTH, crane.CABLE)], [crane.TROLLEY, crane.LOAD], crane.GRAVITY
    )
    force, velocity = force_and_velocity(run[1])
    work = integral(run[1].t, force * velocity[:, 0])
    return np.abs(total - total[0] - work).max() / np.ptp(kinetic)


def test_energy_is_what_the_driving_force_put_in(run):
    assert energy_error(run) < 1e-2


def test_momentum_along_the_guide_is_the_impulse_of_the_driving_force(run):
    history = run[1]
    force, velocity = force_and_velocity(history)
    cable, _ = cable_momentum(*history.cables[0], crane.LENGTH, crane.CABLE)
    momentum = crane.TROLLEY.mass * velocity + crane.LOAD.mass * history.bodies[1].velocity + cable
    impulse = integral(history.t, force)
    np.testing.assert_allclose(momentum[:, 0], impulse, atol=1e-3 * impulse.max())
