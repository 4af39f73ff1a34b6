"""Tethered bodies: twin, joints, energy, momentum."""

import numpy as np
import pytest

from examples import tethered_bodies
from tests.examples.measures import cable_momentum, gaps, spin_momentum, total_energy
from tests.examples.twins import Twin, disagreement, run_inextensible, run_native

TWIN = Twin(end_time=1.0, step=1e-3, axial=1e7)


@pytest.fixture(scope="module")
def run():
    return run_inextensible(tethered_bodies, TWIN.end_time)


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(tethered_bodies, TWIN)) < 1e-3


def test_the_joints_hold_to_a_micrometre(run):
    assert max(gaps(run)) < 1e-6


def energy_error(run):
    """Largest change of the energy over the kinetic energy."""
    kinetic, total = total_energy(
        run, [(tethered_bodies.LENGTH, tethered_bodies.CABLE)], tethered_bodies.INERTIAS, [0, 0, 0]
    )
    return np.abs(total - total[0]).max() / kinetic[0]


def test_energy_stays_what_it_was(run):
    assert energy_error(run) < 1e-2


def test_linear_and_angular_momentum_stay_what_they_were(run):
    history = run[1]
    linear, angular = cable_momentum(*history.cables[0], tethered_bodies.LENGTH, tethered_bodies.CABLE)
    for body, inertia in zip(history.bodies, tethered_bodies.INERTIAS, strict=True):
        momentum = inertia.mass * body.velocity
        linear = linear + momentum
        angular = angular + np.cross(body.position, momentum) + spin_momentum(body, inertia)
    size = sum(
        i.mass * np.linalg.norm(b.velocity[0])
        for i, b in zip(tethered_bodies.INERTIAS, history.bodies, strict=True)
    )
    assert np.abs(linear - linear[0]).max() < 1e-6 * size
    assert np.abs(angular - angular[0]).max() < 1e-4 * np.linalg.norm(angular[0])
