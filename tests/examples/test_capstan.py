"""The capstan: twin, joints, the angle that Euler and Eytelwein would need, sticking."""

import numpy as np
import pytest

from examples import capstan
from tests.examples.measures import History, gaps, total_energy
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

TWIN = Twin(end_time=0.3, step=5e-4, axial=1e6)


@pytest.fixture(scope="module")
def run():
    return run_inextensible(capstan, TWIN.end_time)


def tensions(run, start, end):
    """Mean tension on both sides of the cylinder [N], from the accelerations of what hangs there.

    Half of the cable on the cylinder is counted with each side.
    """
    t, bodies = run[1].t, run[1].bodies
    k, last = np.searchsorted(t, [start, end])
    rho, half_arc = capstan.CABLE.massPerLength, 0.5 * np.pi * capstan.RADIUS
    result = []
    for body, mass in zip(bodies, capstan.MASSES, strict=True):
        velocity, hanging = body.velocity[:, 1], -body.position[k : last + 1, 1].mean()
        acceleration = np.polyfit(t[k : last + 1], velocity[k : last + 1], 1)[0]
        result.append((mass + rho * hanging) * (9.81 + acceleration) + rho * half_arc * acceleration)
    return result


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(capstan, TWIN)) < 1e-2


def test_the_joints_hold_to_a_micrometre(run):
    assert max(gaps(run)) < 1e-6


def test_the_cable_stays_on_the_cylinder(run):
    middle = run[1].cables[0][0][:, capstan.ELEMENTS // 2, 0]
    assert np.abs(np.linalg.norm(middle, axis=1) - capstan.RADIUS).max() < 1e-3 * capstan.RADIUS


def test_tensions_have_the_ratio_of_euler_and_eytelwein(run):
    light, heavy = tensions(run, 0.05, 0.3)
    assert np.log(heavy / light) / capstan.FRICTION == pytest.approx(np.pi, rel=0.02)


def test_friction_takes_the_energy_that_is_lost(run):
    run_without_bodies = (run[0], History(run[1].t, run[1].cables))
    _, energy = total_energy(run_without_bodies, [(capstan.LENGTH, capstan.CABLE)], [], capstan.GRAVITY)
    for body, mass in zip(run[1].bodies, capstan.MASSES, strict=True):
        energy = energy + mass * (0.5 * np.sum(body.velocity**2, axis=1) + 9.81 * body.position[:, 1])
    slid = np.ptp(run[1].bodies[0].position[:, 1])
    light, heavy = tensions(run, 0.05, 0.3)
    assert energy[0] - energy[-1] == pytest.approx((heavy - light) * slid, rel=0.02)


def test_three_times_the_friction_holds_the_heavier_mass():
    history = run_inextensible(capstan, 0.2, friction=0.6)[1]
    assert np.exp(0.6 * np.pi) > capstan.MASSES[1] / capstan.MASSES[0]
    heavier = history.bodies[1].position[:, 1]
    assert np.abs(heavier - heavier[0]).max() < 2e-3
