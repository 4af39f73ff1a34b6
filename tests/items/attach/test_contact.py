"""Cables on a circle with friction: against Euler-Eytelwein and native cables, and step by step."""

import numpy as np
import pytest

from exudyn_inext import AddPointMass, CableShape, CreateCompanionCables, InextensibleCable
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import native_cable, solve_native, trajectory
from tests.items.attach.contact import Circle, add_contact, add_general_contact

RADIUS, FRICTION, GRAVITY = 0.2, 0.3, 9.81
DENSITY, LENGTH, ARC, HANGING = 0.01, np.pi * 0.2 / 12, 12, 6  # of an element; elements
CIRCLE = Circle(RADIUS, 1e3, 0.1, FRICTION, friction_stiffness=1e3, friction_damping=0.05)


def draped():
    """Up on the left, over the upper half of the circle, down on the right."""
    hanging = LENGTH * np.arange(1, HANGING + 1)
    angle = np.pi * (1.0 - np.arange(ARC + 1) / ARC)
    left = np.stack([np.full(HANGING, -RADIUS), -hanging[::-1]], axis=1)
    right = np.stack([np.full(HANGING, RADIUS), -hanging], axis=1)
    around = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    tangents = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    up = np.tile([0.0, 1.0], (HANGING, 1))
    positions = np.concatenate([left, around, right])
    return CableShape(positions, np.concatenate([up, tangents, -up]), elementLengths=LENGTH)


@pytest.fixture
def wound(new_mbs, add_cable, add_sensor, solve):
    """(masses at both ends) -> times, velocities and positions of both ends."""

    def run(masses, end_time=0.3, loop_steps=1, **explicit):
        mbs = new_mbs()
        template = InextensibleCable(DENSITY, 1e-4)
        cable = add_cable(mbs, shape=draped(), beamTemplate=template, gravity=[0, -GRAVITY, 0])
        for arc_length, mass in zip((0.0, LENGTH * (ARC + 2 * HANGING)), masses, strict=True):
            AddPointMass(mbs, cable, arc_length, mass)
        add_contact(mbs, CreateCompanionCables(mbs, cable), CIRCLE)
        ends = cable["nodes"][0], cable["nodes"][-1]
        sensors = [add_sensor(mbs, node, what) for node in ends for what in ("Position", "Velocity")]
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(end_time, loop_steps), **explicit)
        return [trajectory(mbs, sensor) for sensor in sensors]

    return run


def sliding_acceleration(masses, speed, hanging):
    """Of a cable of density rho that slides over the half circle: dT/dphi = R (rho a + rho g_t + mu n)."""

    def surplus(a):
        """Tension that arrives on the right, less that which the right end needs."""
        tension = (masses[0] + DENSITY * hanging[0]) * (GRAVITY + a)
        steps = 2000
        for phi in np.pi * (np.arange(steps) + 0.5) / steps:
            n = tension / RADIUS + DENSITY * (GRAVITY * np.sin(phi) - speed**2 / RADIUS)
            rate = RADIUS * (DENSITY * (a + GRAVITY * np.cos(phi)) + FRICTION * n)
            tension += rate * np.pi / steps
        return tension - (masses[1] + DENSITY * hanging[1]) * (GRAVITY - a)

    low, high = surplus(0.0), surplus(1.0)
    return -low / (high - low)


def test_sliding_cable_accelerates_as_euler_and_eytelwein_say(wound):
    masses = (0.1, 0.4)
    left, _, right, velocity = wound(masses)
    window = slice(12, 26)
    found = -np.polyfit(velocity[window, 0], velocity[window, 2], 1)[0]
    middle = 19
    expected = sliding_acceleration(masses, -velocity[middle, 2], (-left[middle, 2], -right[middle, 2]))
    without_friction = GRAVITY * 0.3 / 0.5
    assert found == pytest.approx(expected, rel=0.015)
    assert expected < 0.4 * without_friction


def test_cable_sticks_below_the_ratio_of_euler_and_eytelwein(wound):
    """2 < exp(mu pi) = 2.57."""
    _, _, right, velocity = wound((0.1, 0.2))
    assert np.abs(right[:, 2] - right[0, 2]).max() < 2e-3
    assert np.abs(velocity[-5:, 2]).max() < 0.01


def test_what_contact_remembers_does_not_depend_on_outputs(wound):
    """Many steps within one of Exudyn's steps, or one in each."""
    step, steps = 2e-4, 500
    coarse = wound((0.1, 0.4), step * steps, stepSize=step)
    fine = wound((0.1, 0.4), step * steps, loop_steps=steps, stepSize=step)
    for ours, each in zip(coarse, fine, strict=True):
        np.testing.assert_allclose(ours[-1], each[-1], rtol=0, atol=1e-10)


def circle_contact(mbs, elements):
    circle = Circle(RADIUS, 200.0, 0.05, FRICTION, friction_damping=0.05)
    add_contact(mbs, elements, circle)


def general_contact(mbs, elements):
    add_general_contact(mbs, elements, Circle(RADIUS, 400.0, 0.1, FRICTION))


@pytest.mark.parametrize("touch", [circle_contact, general_contact])
def test_cable_that_falls_on_a_circle_moves_as_a_native_one(new_mbs, add_cable, add_sensor, solve, touch):
    """The same contact springs on the same elements."""
    section = {"massPerLength": 0.05, "bendingStiffness": 2e-3}
    ends = {"positionStart": [-0.45, 0.205, 0], "positionEnd": [0.55, 0.205, 0]}
    ours, native = new_mbs(), new_mbs()
    cable = add_cable(ours, numberOfElements=20, beamTemplate=InextensibleCable(**section), **ends)
    touch(ours, CreateCompanionCables(ours, cable))
    twin = native_cable(native, 2, 20, section=section, axial_stiffness=1e4, **ends)
    touch(native, twin["elements"])
    sensors = [
        [add_sensor(mbs, nodes[k]) for k in (0, 10, 20)]
        for mbs, nodes in ((ours, cable["nodes"]), (native, twin["nodes"]))
    ]
    for mbs in (ours, native):
        mbs.Assemble()
    solve(ours, 0.25, stepSize=5e-5)
    solve_native(native, 0.25, step=2e-4)
    found, expected = (
        np.stack([trajectory(mbs, sensor)[:, 1:] for sensor in those])
        for mbs, those in zip((ours, native), sensors, strict=True)
    )
    assert np.ptp(expected[:, :, 1]) > 0.2
    np.testing.assert_allclose(found, expected, atol=5e-3 * np.ptp(expected[:, :, 1]))


def test_automatic_step_knows_the_contact_to_come(new_mbs, add_cable, solve):
    """Apart at first; the stiffer the circle, the smaller the step, and the run stays finite."""
    steps = []
    for stiffness in (0.0, 1e3, 1e4):
        mbs = new_mbs()
        ends = {"positionStart": [-0.45, 0.202, 0], "positionEnd": [0.55, 0.202, 0]}
        cable = add_cable(mbs, numberOfElements=5, beamTemplate=InextensibleCable(0.05, 2e-3), **ends)
        elements = CreateCompanionCables(mbs, cable)
        if stiffness:
            add_contact(mbs, elements, Circle(RADIUS, stiffness, 0.01, FRICTION))
        mbs.Assemble()
        bounds = solve(mbs, 0.1)["bounds"]
        steps.append(min(bounds.bending, bounds.contact))
    assert steps[0] > 1.5 * steps[1] > 3.0 * steps[2]
    assert bounds.stability_limit == bounds.contact
