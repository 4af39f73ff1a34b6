"""Sensors of joints and constraints show the forces of their row: the first, the last, and those between."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadCoordinate,
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    NodeRigidBody2D,
    ObjectRigidBody2D,
    SensorBody,
    SensorNode,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import (
    CoordinateConstraint,
    DistanceConstraint,
    GenericJoint,
    InertiaCuboid,
    LoadSolutionFile,
    ObjectJointRevolute2D,
    RevoluteJointZ,
)

from exudyn_inext import AttachToBody
from exudyn_inext.integrators import INTEGRATORS
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import load_node, native_cable, trajectory
from tests.exudyn_binding.test_restart import restarting

G = 9.81
GRAVITY = [0, -G, 0]
LENGTH, MASS = 0.4, 2.0
DENSITY = MASS / (LENGTH * 0.02 * 0.03)
INERTIA = MASS * ((LENGTH**2 + 0.02**2) / 12.0 + 0.25 * LENGTH**2)  # of the arm about its end


def add_force(mbs, number, output="ForceLocal"):
    kind = getattr(exudyn.OutputVariableType, output)
    return mbs.AddSensor(SensorObject(objectNumber=number, storeInternal=True, outputVariableType=kind))


def ends(mbs, arm, marker=MarkerBodyRigid):
    """Markers of the ground and of the arm's end."""
    at = {mbs.CreateGround(referencePosition=[0, 1, 0]): [0, 0, 0], arm: [-0.5 * LENGTH, 0, 0]}
    return [mbs.AddMarker(marker(bodyNumber=body, localPosition=x)) for body, x in at.items()]


JOINTS = {
    "revolute": lambda mbs, arm: RevoluteJointZ(markerNumbers=ends(mbs, arm)),
    "generic": lambda mbs, arm: GenericJoint(
        markerNumbers=ends(mbs, arm), constrainedAxes=[1, 1, 1, 1, 1, 0]
    ),
    "spherical": lambda mbs, arm: SphericalJoint(markerNumbers=ends(mbs, arm, MarkerBodyPosition)),
}


def add_arm(mbs, angle=0.0, **changes):
    """A cuboid that turns about its end in (0, 1, 0), `angle` [rad] from x."""
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    turned = [[along[0], -along[1], 0], [along[1], along[0], 0], [0, 0, 1]]
    place = {"referencePosition": [0, 1, 0] + 0.5 * LENGTH * along, "referenceRotationMatrix": turned}
    inertia = InertiaCuboid(DENSITY, [LENGTH, 0.02, 0.03])
    return mbs.CreateRigidBody(inertia=inertia, gravity=GRAVITY, **(place | changes))


def add_hinged_arm(mbs, joint="revolute", **changes):
    """Sensors of the force in its hinge, and of its torque."""
    arm = add_arm(mbs, **changes)
    hinge = mbs.AddObject(JOINTS[joint](mbs, arm))
    outputs = ["Force"] if joint == "spherical" else ["ForceLocal", "TorqueLocal"]
    return [add_force(mbs, hinge, output) for output in outputs]


def rows(mbs, sensors):
    return np.hstack([trajectory(mbs, sensor)[:, 1:] for sensor in sensors])


def run_natively(mbs, end=1e-5, steps=10):
    """As generalized-alpha computes multipliers before its first step."""
    settings = quiet_settings(end, steps)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
    settings.timeIntegration.newton.relativeTolerance = 1e-8
    with silence():
        mbs.SolveDynamic(settings)


def twins(new_mbs, solve, build, **explicit):
    """First rows of a native run and ours.   build: (mbs) -> sensors."""
    native, ours = new_mbs(), new_mbs()
    expected, sensors = build(native), build(ours)
    native.Assemble()
    ours.Assemble()
    run_natively(native)
    solve(ours, 1e-3, **explicit)
    return rows(native, expected)[0], rows(ours, sensors)[0]


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("joint", JOINTS)
def test_the_hinge_of_an_arm_that_is_released_begins_with_a_quarter_of_its_weight(
    new_mbs, solve, joint, integrator
):
    """Of a slender one: the others less by what they are thick."""
    expected, found = twins(new_mbs, solve, lambda mbs: add_hinged_arm(mbs, joint), integrator=integrator)
    held = MASS * G * (1.0 - MASS * 0.25 * LENGTH**2 / INERTIA)
    assert held == pytest.approx(0.25 * MASS * G, rel=0.01)
    np.testing.assert_allclose(np.abs(found[:3]), [0.0, held, 0.0], atol=1e-8)
    np.testing.assert_allclose(found, expected, atol=1e-4)


def test_an_arm_that_turns_in_space_begins_as_under_generalized_alpha(new_mbs, solve):
    """With the moment of its joint, which holds it in its plane."""
    axis = np.array([1.0, 2.0, -3.0]) / np.sqrt(14.0)
    spin = {"initialAngularVelocity": 4.0 * np.array([0, 0, 1.0]), "initialVelocity": [0, 0.8, 0]}

    def build(mbs):
        sensors = add_hinged_arm(mbs, **spin)
        mbs.AddLoad(
            LoadForceVector(
                markerNumber=mbs.AddMarker(MarkerBodyPosition(bodyNumber=0, localPosition=[0.1, 0, 0])),
                loadVector=3.0 * axis,
            )
        )
        return sensors

    expected, found = twins(new_mbs, solve, build)
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())
    assert np.abs(expected[3:]).max() > 0.1


def add_planar_arm(mbs):
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[0.5 * LENGTH, 1, 0]))
    arm = mbs.AddObject(
        ObjectRigidBody2D(nodeNumber=node, mass=MASS, inertia=INERTIA - MASS * 0.25 * LENGTH**2)
    )
    weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=arm))
    mbs.AddLoad(LoadMassProportional(markerNumber=weight, loadVector=GRAVITY))
    return [add_force(mbs, mbs.AddObject(ObjectJointRevolute2D(markerNumbers=ends(mbs, arm))), "Force")]


def add_hanging_mass(mbs):
    """On a rod, held to its vertical plane by a coordinate that is left out of the equations."""
    point = mbs.CreateMassPoint(mass=MASS, referencePosition=[0, 0.6, 0], gravity=GRAVITY, returnDict=True)
    markers = [
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround(referencePosition=[0, 1, 0]))),
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=point["bodyNumber"])),
    ]
    rod = mbs.AddObject(DistanceConstraint(markerNumbers=markers, distance=0.4))
    mbs.AddLoad(
        LoadCoordinate(
            markerNumber=mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=point["nodeNumber"], coordinate=2)),
            load=3.0,
        )
    )
    return [add_force(mbs, rod, "Force"), add_force(mbs, hold(mbs, point["nodeNumber"], 2), "Force")]


def hold(mbs, node, coordinate):
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
    return mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))


def add_native_cable(mbs):
    """Bent by its weight's beginning; all coordinates of its first node are left out of the equations."""
    nodes = native_cable(mbs, 2, 4, axial_stiffness=1e3)["nodes"]
    return [add_force(mbs, hold(mbs, nodes[0], coordinate), "Force") for coordinate in range(2)]


@pytest.mark.parametrize("build", [add_planar_arm, add_hanging_mass, add_native_cable])
def test_native_items_begin_as_under_generalized_alpha(new_mbs, solve, build):
    expected, found = twins(new_mbs, solve, build)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
    assert np.abs(expected).max() > 0.01


def test_a_mass_that_hangs_at_rest_begins_with_its_weight(mbs, solve):
    sensors = add_hanging_mass(mbs)
    mbs.Assemble()
    solve(mbs, 0.01)
    np.testing.assert_allclose(
        np.abs(rows(mbs, sensors)), [[MASS * G, 3.0]] * len(trajectory(mbs, 0)), rtol=1e-9
    )


def add_cable_with_body(mbs, add_pendulum):
    """A cable with a body at its end, and a mass on a joint in its middle that gravity does not see."""
    cable = add_pendulum(mbs)
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]), referencePosition=[1.85, 0, 0], gravity=GRAVITY
    )
    AttachToBody(mbs, cable, "end", body, [-0.05, 0, 0])
    point = mbs.CreateMassPoint(mass=0.5, referencePosition=[0.72, 0, 0], returnDict=True)
    pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (cable["nodes"][2], point["nodeNumber"])]
    hinge = mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
    return [add_force(mbs, hinge, "Force"), add_force(mbs, hold(mbs, point["nodeNumber"], 2), "Force")]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_joints_of_cables_begin_as_their_next_steps_go_on(mbs, add_pendulum, solve, integrator):
    sensors = add_cable_with_body(mbs, add_pendulum)
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(1e-4, 10, 1e-5), integrator=integrator)
    found = rows(mbs, sensors)
    assert np.abs(found[0]).max() > 0.05
    np.testing.assert_allclose(found[0], found[1], atol=1e-3 * np.abs(found[0]).max())


def test_scaled_masses_do_not_change_the_first_row(new_mbs, add_pendulum, solve):
    found = []
    for scaling in (None, 0.3):
        mbs = new_mbs()
        sensors = add_cable_with_body(mbs, add_pendulum)
        mbs.Assemble()
        solve(mbs, 0.02, stepSize=1e-3, massScaling=scaling)
        found.append(rows(mbs, sensors))
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=1e-7, atol=1e-10)
    assert np.abs(found[0][-1] - found[1][-1]).max() > 1e-6


def test_a_run_goes_on_from_its_restart_file_with_the_forces_there(new_mbs, add_pendulum, solve, tmp_path):
    found = []
    for end, restarts in ((0.2, False), (0.1, True), (0.2, True)):
        mbs = new_mbs()
        sensors = add_cable_with_body(mbs, add_pendulum)
        mbs.Assemble()
        settings = quiet_settings(end, 1, 0.02)
        solve(mbs, settings=restarting(settings, tmp_path) if restarts else settings, stepSize=1e-3)
        found.append(rows(mbs, sensors))
    whole, _, rest = found
    np.testing.assert_array_equal(rest, whole[-len(rest) :])
    assert len(rest) > 3


def continue_from_the_end(mbs):
    data = mbs.systemData
    data.SetSystemState(data.GetSystemState(), exudyn.ConfigurationType.Initial)


@pytest.mark.parametrize("goes_on", [False, True])
def test_a_second_run_begins_with_the_forces_of_its_start(mbs, solve, goes_on):
    sensors = add_hinged_arm(mbs)
    mbs.Assemble()
    solve(mbs, 0.1, stepSize=1e-4)
    first = rows(mbs, sensors)
    if goes_on:
        continue_from_the_end(mbs)
    before = np.array(mbs.systemData.GetAECoordinates(exudyn.ConfigurationType.Initial))
    solve(mbs, 0.1, stepSize=1e-4)
    second = rows(mbs, sensors)
    np.testing.assert_allclose(second[0], first[-1 if goes_on else 0], rtol=1e-8, atol=1e-8)
    assert np.abs(first[-1] - first[0]).max() > 1.0
    after = mbs.systemData.GetAECoordinates(exudyn.ConfigurationType.Initial)
    np.testing.assert_array_equal(after, before)


def test_a_start_that_was_corrected_begins_with_its_forces(new_mbs, solve):
    """Turning at 3 rad/s about its centre, with the momentum that the hinge takes: 3 I_centre / I_end."""
    inertia_of_centre = INERTIA - MASS * 0.25 * LENGTH**2
    omega = 3.0 * inertia_of_centre / INERTIA
    at = {"angle": -0.5 * np.pi, "initialAngularVelocity": [0, 0, 3.0]}
    mbs = new_mbs()
    sensors = add_hinged_arm(mbs, **at)
    mbs.Assemble()
    with pytest.warns(UserWarning, match="velocities"):
        solve(mbs, 0.01)
    weight_and_swing = MASS * (G + 0.5 * LENGTH * omega**2)
    np.testing.assert_allclose(np.abs(rows(mbs, sensors)[0, :3]), [0, weight_and_swing, 0], atol=1e-6)


def swing_force(angle, rate):
    """In the hinge of the arm at an angle from x, turning at `rate` [rad/s], (T, 2), on the arm [N]."""
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    turning = -0.5 * MASS * G * LENGTH * np.cos(angle) / INERTIA
    acceleration = 0.5 * LENGTH * (turning * across - rate**2 * along)
    return (MASS * (acceleration + np.array([[0.0], [G]]))).T


def swing(mbs, solve, period, **explicit):
    """Forces in the hinge of the arm, (T, 2), and those that follow from the rows' places and rates."""
    force = add_hinged_arm(mbs, "spherical")[0]
    place, rate = (
        mbs.AddSensor(SensorBody(bodyNumber=0, storeInternal=True, outputVariableType=kind))
        for kind in (exudyn.OutputVariableType.Position, exudyn.OutputVariableType.AngularVelocity)
    )
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(0.6, 1, period), **explicit)
    times = trajectory(mbs, force)[:, 0]
    np.testing.assert_allclose(times, period * np.arange(round(0.6 / period) + 1), atol=1e-9)
    x, y = (trajectory(mbs, place)[:, 1:3] - [0, 1]).T
    expected = swing_force(np.arctan2(y, x), trajectory(mbs, rate)[:, 3])
    return trajectory(mbs, force)[:, 1:3], -expected, report


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("step", [1e-3, 5e-3])
def test_all_rows_hold_the_forces_of_their_state(mbs, solve, integrator, step):
    found, expected, report = swing(mbs, solve, 0.02, integrator=integrator, stepSize=step)
    assert report["rejections"] == 0
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_rows_after_halved_steps_hold_the_forces_of_their_state(mbs, solve):
    found, expected, report = swing(mbs, solve, 0.2, stepSize=0.2)
    assert report["rejections"] > 0
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def forces_of_support(mbs, add_pendulum):
    """Of the cable's own pin, and accelerations of its end."""
    cable = add_pendulum(mbs)
    constraints = [
        k for k in range(mbs.systemData.NumberOfObjects()) if "Coordinate" in mbs.GetObject(k)["objectType"]
    ]
    end = SensorNode(
        nodeNumber=cable["nodes"][-1],
        storeInternal=True,
        outputVariableType=exudyn.OutputVariableType.Acceleration,
    )
    return [add_force(mbs, number, "Force") for number in constraints] + [mbs.AddSensor(end)]


@pytest.mark.parametrize("build", [forces_of_support, add_cable_with_body])
@pytest.mark.parametrize("period", [0.0035, 0.01])
def test_rows_that_are_written_now_and_then_are_those_of_each_step(
    new_mbs, add_pendulum, solve, build, period, tmp_path
):
    """Sensors and solution file at periods of their own, which are no multiples of the step."""
    found = []
    for own in (0.0, period):
        mbs = new_mbs()
        sensors = build(mbs, add_pendulum)
        if not own:  # these steps are computed one by one
            mbs.SetPostStepUserFunction(lambda mbs, t: True)
        mbs.Assemble()
        settings = quiet_settings(0.1, 100, own)
        settings.solution.file.write = True
        settings.solution.file.name = str(tmp_path / "solution.txt")
        settings.solution.file.writePeriod = 1.3 * own
        solve(mbs, settings=settings, stepSize=1e-3)
        file = LoadSolutionFile(settings.solution.file.name, verbose=False)["data"]
        found.append([np.hstack([trajectory(mbs, 0)[:, :1], rows(mbs, sensors)]), file])
    for all_rows, some_rows in zip(*found, strict=True):
        steps = np.rint(some_rows[:, 0] / 1e-3).astype(int)
        assert 5 < len(steps) < 40
        np.testing.assert_allclose(some_rows, all_rows[steps], rtol=1e-7, atol=1e-8)


def test_after_a_run_the_joint_has_the_force_of_its_last_row(mbs, solve):
    found, _, _ = swing(mbs, solve, 0.1)
    at_the_end = mbs.GetObjectOutput(2, exudyn.OutputVariableType.Force)
    np.testing.assert_array_equal(at_the_end[:2], found[-1])


def test_forces_in_joints_of_cables_are_those_of_small_steps(new_mbs, add_pendulum, solve):
    found = []
    for step in (1e-3, 5e-4, 6.25e-5):
        mbs = new_mbs()
        sensors = add_cable_with_body(mbs, add_pendulum)
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.1, 1, 0.02), stepSize=step)
        found.append(rows(mbs, sensors))
    coarse, middle, exact = found
    errors = [np.abs(rows - exact).max() for rows in (coarse, middle)]
    assert errors[1] < 0.4 * errors[0] and errors[1] < 0.02 * np.abs(exact).max()


def run_with_load(mbs, add_pendulum, solve, is_looked_at):
    """Last coordinates, and how often a load of a cable with a body was asked for."""
    times = []

    def force(mbs, t, load):
        times.append(t)
        return load

    cable = add_pendulum(mbs)
    hinge = JOINTS["revolute"](mbs, add_arm(mbs))
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.05, 0.02, 0.03]), referencePosition=[1.85, 0, 0], gravity=GRAVITY
    )
    AttachToBody(mbs, cable, "end", body, [-0.05, 0, 0])
    load_node(mbs, cable["nodes"][3], [0, 0.1, 0], loadVectorUserFunction=force)
    number = mbs.AddObject(hinge)
    kind = exudyn.OutputVariableType.Position
    mbs.AddSensor(SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=kind))
    if is_looked_at:
        add_force(mbs, number)
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.1, 1, 0.01), stepSize=1e-3)
    return mbs.systemData.GetODE2Coordinates(), sum(0.005 < t < 0.0995 for t in times)


def test_who_looks_at_forces_pays_for_them_and_does_not_change_the_motion(new_mbs, add_pendulum, solve):
    (seen, calls), (unseen, fewer) = (
        run_with_load(new_mbs(), add_pendulum, solve, is_looked_at) for is_looked_at in (True, False)
    )
    np.testing.assert_array_equal(seen, unseen)
    assert calls == fewer + 9  # one for each row
