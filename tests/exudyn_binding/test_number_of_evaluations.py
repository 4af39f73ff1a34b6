"""A run asks Exudyn to evaluate its items no more often than the motion needs; user functions are counted."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    NodeGenericODE2,
    ObjectKinematicTree,
    SensorNode,
    SpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    AddMarkerOnCable,
    AttachToBody,
    CableForces,
    CreateCableForceSensor,
    CreateCompanionCables,
    InextensibleCable,
)
from exudyn_inext.exudyn_binding import cable_forces
from exudyn_inext.exudyn_binding.scene import read_scene
from exudyn_inext.run.coupled_run import CoupledRun
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import SECTION, load_node

STEPS = 50  # of Exudyn's loop


def driven_arm(mbs, calls):
    """A link on a hinge with a controller, whose wanted angle is set before each step."""
    node = mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0],
            initialCoordinates=[0.0],
            initialCoordinates_t=[0.0],
            numberOfODE2Coordinates=1,
        )
    )
    link = InertiaCuboid(1000, [0.3, 0.05, 0.05]).Translated([0.15, 0, 0])

    def count(mbs, t, itemNumber, q, q_t):
        calls.append(t)
        return [0.0]

    tree = mbs.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exudyn.JointType.RevoluteZ],
            linkParents=[-1],
            jointTransformations=exudyn.Matrix3DList([np.eye(3)]),
            jointOffsets=exudyn.Vector3DList([[0, 0, 0]]),
            linkInertiasCOM=exudyn.Matrix3DList([link.InertiaCOM()]),
            linkCOMs=exudyn.Vector3DList([link.COM()]),
            linkMasses=[link.Mass()],
            gravity=[0, -9.81, 0],
            baseOffset=[0, 0, 0],
            jointPControlVector=[50.0],
            jointDControlVector=[2.0],
            jointPositionOffsetVector=[0.0],
            jointVelocityOffsetVector=[0.0],
            forceUserFunction=count,
        )
    )

    def drive(mbs, t):
        mbs.SetObjectParameter(tree, "jointPositionOffsetVector", [np.sin(9 * t)])
        mbs.SetObjectParameter(tree, "jointVelocityOffsetVector", [9 * np.cos(9 * t)])
        return True

    mbs.SetPreStepUserFunction(drive)
    return node


def test_the_drive_of_an_arm_acts_without_another_look_at_the_limit_of_the_step(new_mbs, add_pendulum, solve):
    turned = []
    for beside_a_cable in (True, False):
        mbs, calls = new_mbs(), []
        node = driven_arm(mbs, calls)
        if beside_a_cable:
            add_pendulum(mbs, numberOfElements=2)
        mbs.Assemble()
        settings = quiet_settings(0.3, 400)
        if beside_a_cable:
            report = solve(mbs, settings=settings)
            assert len(calls) < 10 * report["steps"]
        else:
            with silence():
                mbs.SolveDynamic(settings)
        turned.append(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates))
    assert abs(turned[1]) > 0.1
    np.testing.assert_allclose(*turned, rtol=0.01)


def pulled_cable(mbs, add_pendulum, points, calls):
    """With a mass at its end, on a spring that Exudyn evaluates; returns cable, and sensors at the points."""
    cable = add_pendulum(mbs, numberOfElements=4)
    mass = mbs.CreateMassPoint(referencePosition=[1.8, 0, 0], mass=0.1, gravity=[0, -9.81, 0], create2D=True)
    AttachToBody(mbs, cable, "end", mass)

    def pull(mbs, t, itemNumber, change, rate, stiffness, damping, force):
        calls.append(t)
        return 5.0 * change

    ends = mbs.CreateGround(referencePosition=[1.8, 0.5, 0]), mass
    markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=end)) for end in ends]
    mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=0.5, springForceUserFunction=pull))
    return cable, [CreateCableForceSensor(mbs, cable, x) for x in points]


def test_sensors_of_section_forces_take_what_the_run_has_evaluated(new_mbs, add_pendulum, solve):
    counted = []
    for points in ([], [0.9], [0.1, 0.9, 1.0, 1.7]):
        mbs, calls = new_mbs(), []
        cable, sensors = pulled_cable(mbs, add_pendulum, points, calls)
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.1, STEPS, 0.1 / STEPS))
        counted.append(len(calls))
    shown = [mbs.GetSensorStoredData(sensor)[-1, 1] for sensor in sensors]
    np.testing.assert_allclose(shown, CableForces(mbs, cable, points)["tension"], rtol=1e-5)
    assert counted[0] + STEPS // 2 < counted[1] == counted[2] < counted[0] + STEPS + 4


def test_accelerations_that_are_written_ask_a_spring_once(new_mbs, add_pendulum, solve):
    counted = []
    for is_written in (False, True):
        mbs, calls = new_mbs(), []
        cable, _ = pulled_cable(mbs, add_pendulum, [], calls)
        acceleration = exudyn.OutputVariableType.Acceleration
        if is_written:
            mbs.AddSensor(SensorNode(nodeNumber=cable["nodes"][-1], outputVariableType=acceleration))
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.1, STEPS, 0.1 / STEPS), massScaling=0.25)
        counted.append(len(calls))
    assert counted[0] + STEPS // 2 < counted[1] < counted[0] + STEPS + 4


@pytest.mark.parametrize("end", [1.0, 0.137], ids=["whole", "stopped"])
def test_forces_that_no_step_function_looks_at_are_solved_for_where_they_are_written(
    new_mbs, add_pendulum, solve, monkeypatch, end
):
    """States of several steps at once; the last one is complete, too, wherever a function stops the run."""
    solved, complete = [], CoupledRun.complete
    monkeypatch.setattr(
        CoupledRun, "complete", lambda run, times, *rest: solved.extend(times) or complete(run, times, *rest)
    )
    kinds = exudyn.OutputVariableType

    def shown(look):
        mbs = new_mbs()
        cable = add_pendulum(mbs, numberOfElements=4)
        gravity = [0, -9.81, 0]
        mass = mbs.CreateMassPoint(referencePosition=[1.8, 0, 0], mass=0.1, gravity=gravity, create2D=True)
        AttachToBody(mbs, cable, "end", mass)
        sensor = SensorNode(
            nodeNumber=cable["nodes"][-1], outputVariableType=kinds.Acceleration, storeInternal=True
        )
        number = mbs.AddSensor(sensor)
        mbs.SetPreStepUserFunction(lambda mbs, t: look(mbs) and t < end)
        mbs.Assemble()
        solve(mbs, settings=quiet_settings(0.4, 400, 0.023))
        data = mbs.systemData
        return [
            mbs.GetSensorStoredData(number).tolist(),
            data.GetODE2Coordinates_tt().tolist(),
            data.GetAECoordinates().tolist(),
        ]

    every = shown(lambda mbs: mbs.GetNodeOutput(0, kinds.Acceleration) is not None)
    number = len(solved)
    assert shown(lambda mbs: mbs.GetNodeOutput(0, kinds.Position) is not None) == every
    assert 4 * (len(solved) - number) < number


def test_a_sensor_of_section_forces_shows_what_is_changed_after_a_step(mbs, add_pendulum, solve):
    cable, (sensor,) = pulled_cable(mbs, add_pendulum, [1.7], [])
    weight = AddMarkerOnCable(mbs, cable, 1.8)
    load = mbs.AddLoad(LoadForceVector(markerNumber=weight, loadVector=[0, 0, 0]))
    mbs.SetPostStepUserFunction(
        lambda mbs, t: t < 0.0999 or mbs.SetLoadParameter(load, "loadVector", [50, 0, 0]) or True
    )
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.1, STEPS, 0.1 / STEPS))
    before, after = mbs.GetSensorStoredData(sensor)[-2:, 1]
    assert after > before + 10
    np.testing.assert_allclose(after, CableForces(mbs, cable, [1.7])["tension"], rtol=1e-9)


def test_a_controller_reads_the_tension_of_the_state_that_it_sees(mbs, add_pendulum, solve):
    calls, read = [], []
    cable, (sensor,) = pulled_cable(mbs, add_pendulum, [1.7], calls)
    weight = AddMarkerOnCable(mbs, cable, 1.8)
    load = mbs.AddLoad(LoadForceVector(markerNumber=weight, loadVector=[0, 0, 0]))

    def control(mbs, t):
        before = len(calls)
        tension = mbs.GetSensorValues(sensor)[0]
        asked = len(calls) - before
        read.append([tension, CableForces(mbs, cable, [1.7])["tension"][0], asked])
        mbs.SetLoadParameter(load, "loadVector", [0.2 * (3.0 - tension), 0, 0])
        return True

    mbs.SetPreStepUserFunction(control)
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.02, 10, 0.004))
    shown, fresh, asked = np.transpose(read)
    assert np.ptp(shown) > 0.1
    np.testing.assert_allclose(shown, fresh, rtol=1e-5)
    assert not asked[1:].any()


def test_a_sensor_of_section_forces_follows_what_is_changed_after_a_run(mbs, add_pendulum, solve):
    cable, sensors = pulled_cable(mbs, add_pendulum, [0.1, 1.7], [])
    weight = AddMarkerOnCable(mbs, cable, 1.8)
    load = mbs.AddLoad(LoadForceVector(markerNumber=weight, loadVector=[0, 0, 0]))
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.1, STEPS))
    before = evaluated(mbs, sensors[0])
    mbs.SetLoadParameter(load, "loadVector", [50, 0, 0])
    after = [evaluated(mbs, sensor) for sensor in sensors]
    assert after[0] > before + 10
    np.testing.assert_allclose(after, CableForces(mbs, cable, [0.1, 1.7])["tension"], rtol=1e-9)


def evaluated(mbs, sensor):
    """The tension that it shows of the present state."""
    function = mbs.GetSensor(sensor)["sensorUserFunction"]["function"]
    return function(mbs, mbs.systemData.GetTime(), [], [], exudyn.ConfigurationType.Current)[0]


def loaded(mbs, cable):
    """What sets a force on a node in each step."""
    load = load_node(mbs, cable["nodes"][-1], [0.0, 0.0, 0.0])
    return lambda t: mbs.SetLoadParameter(load, "loadVector", [0.0, 2 * np.sin(9 * t), 0.0])


def weighed(mbs, cable):
    """What sets the weight of the elements."""
    masses = [MarkerBodyMass(bodyNumber=element) for element in CreateCompanionCables(mbs, cable)]
    loads = [mbs.AddLoad(LoadMassProportional(markerNumber=mbs.AddMarker(one))) for one in masses]
    return lambda t: [mbs.SetLoadParameter(one, "loadVector", [0.0, 50 * t, 0.0]) for one in loads]


def sprung(mbs, cable):
    """What sets the stiffness of a spring at a body at the end of the cable."""
    ground = mbs.CreateGround(referencePosition=[1.8, 0.5, 0])
    mass = mbs.CreateMassPoint(referencePosition=[1.8, 0, 0], mass=0.1, create2D=True)
    AttachToBody(mbs, cable, "end", mass)
    spring = mbs.CreateSpringDamper(itemNumbers=[ground, mass], referenceLength=0.3)
    return lambda t: mbs.SetObjectParameter(spring, "stiffness", 5 + 40 * t)


@pytest.mark.parametrize("stretch", [{}, {"axialStiffness": 1e4}])
@pytest.mark.parametrize("add", [loaded, weighed, sprung])
def test_a_sensor_of_section_forces_does_not_read_the_scene_again_where_forces_are_set(
    mbs, add_pendulum, solve, monkeypatch, add, stretch
):
    template = InextensibleCable(**SECTION, **stretch)
    cable = add_pendulum(mbs, numberOfElements=4, beamTemplate=template)
    change, read = add(mbs, cable), []
    sensor = CreateCableForceSensor(mbs, cable, 0.7)
    mbs.SetPreStepUserFunction(lambda mbs, t: change(t) is None or True)
    mbs.Assemble()
    monkeypatch.setattr(cable_forces, "read_scene", lambda mbs: read.append(mbs) or read_scene(mbs))
    solve(mbs, settings=quiet_settings(0.1, STEPS, 0.1 / STEPS))
    assert len(read) < STEPS // 5
    tension = CableForces(mbs, cable, [0.7])["tension"]
    assert mbs.GetSensorStoredData(sensor)[-1, 1] == pytest.approx(tension[0], rel=1e-6)
    change(0.0)
    assert abs(CableForces(mbs, cable, [0.7])["tension"] - tension) > 1e-3 * abs(tension)
