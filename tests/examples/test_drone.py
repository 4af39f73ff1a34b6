"""The drone: twin, joint and motion, energy in the drone's frame, how far the load swings."""

from types import SimpleNamespace

import numpy as np
import pytest

from examples import drone
from tests.examples.measures import History, gaps, total_energy
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

EFFECTIVE_GRAVITY = np.array(drone.GRAVITY) - drone.ACCELERATION

TWIN = Twin(end_time=1.4, step=1e-3, axial=1e7)


@pytest.fixture(scope="module")
def run():
    return run_inextensible(drone, TWIN.end_time)


def seen_from_the_drone(history):
    """The same run in the frame of the drone, where gravity is the effective one."""
    x = np.stack([drone.drone_position(t) for t in history.t])
    v = np.stack([drone.drone_velocity(t) for t in history.t])
    (q, rates), body = history.cables[0], history.bodies[0]
    q, rates = q.copy(), rates.copy()
    q[:, :, 0] -= x[:, None]
    rates[:, :, 0] -= v[:, None]
    moved = {"position": body.position - x, "velocity": body.velocity - v}
    return History(history.t, [(q, rates)], [SimpleNamespace(**vars(body) | moved)])


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(drone, TWIN)) < 1e-3


def test_joint_and_motion_hold_to_a_micrometre(run):
    assert max(gaps(run)) < 1e-6
    first_node = run[1].cables[0][0][:, 0, 0]
    path = np.stack([drone.drone_position(t) for t in run[1].t])
    np.testing.assert_allclose(first_node, path, atol=1e-6)


def energy_error(run):
    """Largest change of the energy in the frame of the drone, over the largest kinetic energy."""
    seen = (run[0], seen_from_the_drone(run[1]))
    kinetic, total = total_energy(seen, [(drone.LENGTH, drone.CABLE)], [drone.LOAD], EFFECTIVE_GRAVITY)
    return np.abs(total - total[0]).max() / kinetic.max()


def test_energy_in_the_frame_of_the_drone_stays_what_it_was(run):
    assert energy_error(run) < 1e-2


def test_the_load_swings_out_to_twice_the_angle_of_the_effective_gravity(run):
    x, y, z = seen_from_the_drone(run[1]).bodies[0].position.T
    angle = np.arctan2(np.hypot(x, y), -z)
    balance = np.arctan2(np.hypot(*EFFECTIVE_GRAVITY[:2]), -EFFECTIVE_GRAVITY[2])
    assert 0 < np.argmax(angle) < len(angle) - 1
    assert angle.max() == pytest.approx(2 * balance, rel=0.005)
