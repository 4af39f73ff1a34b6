"""Tethered bodies: twin, joints, energy, momentum."""

import numpy as np
import pytest

from examples import tethered_bodies as scene
from tests.examples.measures import cable_momentum, gaps, spin_momentum, total_energy
from tests.examples.twins import disagreement, run_inextensible, run_native


@pytest.fixture(scope="module")
def run():
    return run_inextensible(scene, 1.0)


def test_it_agrees_with_stiff_native_cables_and_implicit_steps(run):
    assert disagreement(run, run_native(scene, 1.0, step=1e-3, axial=1e7)) < 1e-3


def test_the_joints_hold_to_a_micrometre(run):
    assert max(gaps(run)) < 1e-6


def test_energy_stays_what_it_was(run):
    kinetic, total = total_energy(run, [(scene.LENGTH, scene.CABLE)], scene.INERTIAS, [0, 0, 0])
    assert np.abs(total - total[0]).max() < 1e-2 * kinetic[0]


def test_linear_and_angular_momentum_stay_what_they_were(run):
    history = run[1]
    linear, angular = cable_momentum(*history.cables[0], scene.LENGTH, scene.CABLE)
    for body, inertia in zip(history.bodies, scene.INERTIAS, strict=True):
        momentum = inertia.mass * body.velocity
        linear = linear + momentum
        angular = angular + np.cross(body.position, momentum) + spin_momentum(body, inertia)
    size = sum(
        i.mass * np.linalg.norm(b.velocity[0]) for i, b in zip(scene.INERTIAS, history.bodies, strict=True)
    )
    assert np.abs(linear - linear[0]).max() < 1e-6 * size
    assert np.abs(angular - angular[0]).max() < 1e-4 * np.linalg.norm(angular[0])
