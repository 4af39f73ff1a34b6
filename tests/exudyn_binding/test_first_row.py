"""Sensors and solution files begin with the accelerations at the start, on all paths."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    NodePointGround,
    SensorBody,
    SphericalJoint,
)
from exudyn.utilities import CoordinateConstraint, InertiaCuboid

from exudyn_inext import AttachToBody, CreatePrescribedMotion
from exudyn_inext.integrators import INTEGRATORS
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import load_node, native_cable, trajectory

G = 9.81
GRAVITY = [0, -G, 0]


def initial(mbs):
    return [np.asarray(part) for part in mbs.systemData.GetSystemState(exudyn.ConfigurationType.Initial)]


def first_rows(mbs, sensors):
    return [trajectory(mbs, sensor)[0, 1:] for sensor in sensors]


def native_first_rows(mbs, sensors):
    """As generalized-alpha computes them before its first step."""
    settings = quiet_settings(1e-3, 10)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
    with silence():
        mbs.SolveDynamic(settings)
    return first_rows(mbs, sensors)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cable_in_free_fall_begins_with_g(mbs, add_cable, add_sensor, solve, integrator, dimension):
    nodes = add_cable(mbs, dimension=dimension)["nodes"]
    sensors = [add_sensor(mbs, node, "Acceleration") for node in nodes]
    mbs.Assemble()
    before = initial(mbs)
    solve(mbs, 0.02, integrator=integrator)
    for row in first_rows(mbs, sensors):
        np.testing.assert_allclose(row, GRAVITY, atol=1e-9)
    for now, then in zip(initial(mbs), before, strict=True):
        np.testing.assert_array_equal(now, then)


def test_it_does_so_whatever_is_set_for_generalized_alpha(mbs, add_cable, add_sensor, solve):
    sensor = add_sensor(mbs, add_cable(mbs)["nodes"][0], "Acceleration")
    mbs.Assemble()
    settings = quiet_settings(0.01, 10)
    native = settings.timeIntegration.generalizedAlpha
    native.resetAccelerations = native.useIndex2Constraints = True
    solve(mbs, settings=settings)
    np.testing.assert_allclose(first_rows(mbs, [sensor])[0], GRAVITY, atol=1e-9)


def test_a_pinned_cable_begins_as_a_native_one(mbs, new_mbs, add_pendulum, add_sensor, solve):
    """Horizontal and at rest, with a force: nothing is stretched, the accelerations are the same."""
    native = new_mbs()
    nodes = native_cable(native, 2, 5, groundConstraintsStart=[True, True, False, False])["nodes"]
    ours = add_pendulum(mbs)["nodes"]
    rows = []
    for system, of_cable in ((native, nodes), (mbs, ours)):
        load_node(system, of_cable[3], [0, 0.2, 0])
        sensors = [add_sensor(system, node, "Acceleration") for node in of_cable]
        system.Assemble()
        rows.append((system, sensors))
    solve(mbs, 0.02)
    expected = native_first_rows(*rows[0])
    np.testing.assert_allclose(first_rows(*rows[1]), expected, atol=1e-6)  # native: round-off of EA
    assert np.abs(expected).max() > G


def test_a_moved_node_begins_with_the_acceleration_of_its_motion(mbs, add_cable, add_sensor, solve):
    nodes = add_cable(mbs)["nodes"]
    CreatePrescribedMotion(mbs, nodes[0], lambda t: [0.0, 0.1 * (1.0 - np.cos(5.0 * t))])
    sensor = add_sensor(mbs, nodes[0], "Acceleration")
    mbs.Assemble()
    solve(mbs, 0.02)
    np.testing.assert_allclose(first_rows(mbs, [sensor])[0], [0.0, 2.5, 0.0], atol=1e-5)


def add_arm(mbs):
    """A cuboid of 0.4 m along x that turns about its end; sensor of its centre."""
    arm = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.4, 0.02, 0.03]),
        referencePosition=[0.2, 1, 0],
        initialAngularVelocity=[0, 0, 2],
        initialVelocity=[0, 0.4, 0],
        gravity=GRAVITY,
        returnDict=True,
    )["bodyNumber"]
    at = {mbs.CreateGround(referencePosition=[0, 1, 0]): [0, 0, 0], arm: [-0.2, 0, 0]}
    markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=b, localPosition=x)) for b, x in at.items()]
    mbs.AddObject(SphericalJoint(markerNumbers=markers))
    kind = exudyn.OutputVariableType.Acceleration
    return mbs.AddSensor(SensorBody(bodyNumber=arm, storeInternal=True, outputVariableType=kind))


def test_bodies_on_joints_begin_as_under_generalized_alpha(mbs, new_mbs, solve):
    """And as a physical pendulum."""
    native = new_mbs()
    theirs, ours = add_arm(native), add_arm(mbs)
    native.Assemble()
    mbs.Assemble()
    solve(mbs, 0.02)
    inertia = (0.4**2 + 0.02**2) / 12.0 + 0.2**2  # about the joint, over the mass
    expected = [-0.2 * 2.0**2, -0.2 * G * 0.2 / inertia, 0.0]
    np.testing.assert_allclose(first_rows(mbs, [ours])[0], expected, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(native_first_rows(native, [theirs])[0], expected, rtol=1e-4)


def test_a_cable_with_a_body_begins_as_its_next_steps_go_on(mbs, add_pendulum, add_sensor, solve):
    """In tiny steps; with a body, a joint and a cable that already turns."""
    cable = add_pendulum(mbs)
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]),
        referencePosition=[1.85, 0, 0],
        gravity=GRAVITY,
        returnDict=True,
    )
    AttachToBody(mbs, cable, "end", body["bodyNumber"], [-0.05, 0, 0])
    sensors = [add_sensor(mbs, node, "Acceleration") for node in (cable["nodes"][2], body["nodeNumber"])]
    mbs.Assemble()
    settings = quiet_settings(1e-4, 10)
    settings.solution.sensors.writePeriod = 1e-5
    solve(mbs, settings=settings)
    for sensor in sensors:
        rows = trajectory(mbs, sensor)[:, 1:]
        np.testing.assert_allclose(rows[0], rows[1], atol=1e-3 * np.abs(rows).max())
        assert np.abs(rows[0]).max() > 1.0


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_native_items_begin_as_under_generalized_alpha(new_mbs, add_sensor, solve, integrator):
    rows = []
    for _ in range(2):
        system = new_mbs()
        nodes = native_cable(system, 2, 4)["nodes"]
        ground = system.AddMarker(
            MarkerNodeCoordinate(nodeNumber=system.AddNode(NodePointGround()), coordinate=0)
        )
        for coordinate in (0, 1):
            marker = system.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
            system.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))
        sensors = [add_sensor(system, node, "Acceleration") for node in nodes]
        system.Assemble()
        rows.append((system, sensors))
    report = solve(rows[1][0], 1e-3, integrator=integrator)
    assert "native items" in report["path"]
    np.testing.assert_allclose(first_rows(*rows[1]), native_first_rows(*rows[0]), atol=1e-7)


def test_the_solution_file_begins_with_accelerations(mbs, add_cable, solve, tmp_path):
    add_cable(mbs)
    mbs.Assemble()
    settings = quiet_settings(0.02, 1)
    settings.solution.file.write = True
    settings.solution.file.name = str(tmp_path / "solution.txt")
    solve(mbs, settings=settings)
    first = np.loadtxt(settings.solution.file.name, delimiter=",")[0]
    number = mbs.systemData.ODE2Size()
    np.testing.assert_allclose(first[1 + 2 * number :].reshape(-1, 4)[:, :2], [[0, -G]] * 6, atol=1e-9)
