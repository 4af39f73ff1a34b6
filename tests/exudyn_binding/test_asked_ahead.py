"""Where only items ask for the state, several steps of the loop are taken at once: nobody notices."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodeGenericData,
    NodePointGround,
    ObjectContactCoordinate,
    RevoluteJoint2D,
    SensorNode,
    SensorObject,
    SensorUserFunction,
    SpringDamper,
)
from exudyn.rigidBodyUtilities import InertiaSphere

from exudyn_inext import SolveExplicit
from exudyn_inext.run.coupled_run import CoupledRun
from reference_models.model import quiet_settings, silence

RADIUS = 0.1  # [m]
STEPS, PERIOD = 100, 0.015  # of the loop in 0.5 s, each third of which is an output
AT_ONCE = "up to 32 steps at once"


@pytest.fixture
def swing(new_mbs, add_pendulum):
    """(force, by_spring) -> mbs with a mass on a cable, sensors, times at which the force was asked for."""

    def build(force, by_spring=False):
        mbs, asked = new_mbs(), []
        cable = add_pendulum(mbs)
        tip = cable["nodes"][-1]
        body = mbs.CreateMassPoint(
            referencePosition=[1.8, 0, 0], mass=0.1, gravity=[0, -9.81, 0], create2D=True
        )
        on_both = MarkerNodePosition(nodeNumber=tip), MarkerBodyPosition(bodyNumber=body)
        markers = [mbs.AddMarker(marker) for marker in on_both]
        joint = mbs.AddObject(RevoluteJoint2D(markerNumbers=markers))

        def pull(mbs, t, load):
            asked.append(t)
            return force(mbs, t, tip)

        def spring(mbs, t, number, u, v, k, d, f):
            asked.append(t)
            return k * u + force(mbs, t, tip)[1]

        if by_spring:
            ground = MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[1.8, 1, 0])
            held = {"markerNumbers": [mbs.AddMarker(ground), markers[1]], "referenceLength": 1}
            mbs.AddObject(SpringDamper(**held, stiffness=5, springForceUserFunction=spring))
        else:
            mbs.AddLoad(LoadForceVector(markerNumber=markers[1], loadVectorUserFunction=pull))
        kept, kinds = {"storeInternal": True}, exudyn.OutputVariableType
        of_tip = SensorNode(nodeNumber=tip, outputVariableType=kinds.Position, **kept)
        of_joint = SensorObject(objectNumber=joint, outputVariableType=kinds.Force, **kept)
        of_time = SensorUserFunction(
            sensorUserFunction=lambda mbs, t, *_: [mbs.systemData.GetTime() - t], **kept
        )
        sensors = [mbs.AddSensor(sensor) for sensor in (of_tip, of_joint, of_time)]
        mbs.Assemble()
        return mbs, sensors, asked

    return build


def solved(mbs, sensors):
    """Rows of the sensors, and the path that the steps took."""
    with silence():
        report = SolveExplicit(mbs, quiet_settings(0.5, STEPS, PERIOD))
    return [np.array(mbs.GetSensorStoredData(sensor)) for sensor in sensors], report["path"]


def at_once_and_seen(build):
    """mbs, rows and path of a run that takes steps at once, and of one whose steps a function sees."""
    mbs, sensors = build()
    own = mbs, *solved(mbs, sensors)
    mbs, sensors = build()
    mbs.SetPreStepUserFunction(lambda mbs, t: True)
    seen = mbs, *solved(mbs, sensors)
    assert (AT_ONCE in own[2], AT_ONCE in seen[2]) == (True, False)
    return own, seen


def brake(mbs, t, tip):
    velocity = mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Velocity)
    return [-0.2 * velocity[0], -0.2 * velocity[1], 0]


def pull_back(mbs, t, tip):
    x, y, _ = mbs.GetSensorValues(0)
    return [-0.2 * x, -0.2 * y, 0]


def follow_joint(mbs, t, tip):
    return (0.1 * mbs.GetSensorValues(1)).tolist()


def brake_and_release(mbs, t, tip):
    """It lets the weight of the mass go at 0.2 s."""
    if t > 0.2:
        mbs.SetLoadParameter(0, "loadVector", [0, 0, 0])
    return brake(mbs, t, tip)


@pytest.mark.parametrize("by_spring", [False, True])
@pytest.mark.parametrize(
    ("force", "are_at_once"),
    [(brake, True), (pull_back, True), (brake_and_release, False), (follow_joint, False)],
)
def test_outputs_are_those_of_a_run_whose_steps_a_function_sees(swing, force, by_spring, are_at_once):
    mbs, sensors, asked = swing(force, by_spring)
    found, path = solved(mbs, sensors)
    seen_mbs, sensors, expected_asked = swing(force, by_spring)
    seen_mbs.SetPreStepUserFunction(lambda mbs, t: True)
    expected, seen_path = solved(seen_mbs, sensors)
    assert (AT_ONCE in path, AT_ONCE in seen_path) == (are_at_once, False)
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(own, other)
    assert len(found[0]) > 0.5 / PERIOD
    assert np.abs(found[1][:, 1:]).max() > 0.5  # forces
    assert not found[2][:, 1].any()  # mbs has the time of the output
    assert asked == expected_asked


@pytest.mark.parametrize("by_spring", [False, True])
def test_outputs_until_a_function_fails_are_kept(swing, by_spring):
    def fail(mbs, t, tip):
        if t > 0.31:
            raise ValueError("no force")
        return brake(mbs, t, tip)

    mbs, sensors, _ = swing(fail, by_spring)
    with pytest.raises(Exception, match="no force"):
        solved(mbs, sensors)
    kept = np.array(mbs.GetSensorStoredData(sensors[0]))
    assert kept[-1, 0] == pytest.approx(0.3)
    assert mbs.systemData.GetTime() == pytest.approx(0.31)


@pytest.fixture
def bounce(new_mbs, add_pendulum):
    """mbs with a cable whose tip falls on a spring, and sensors of the tip and of its gap."""

    def build():
        mbs = new_mbs()
        tip = add_pendulum(mbs)["nodes"][-1]
        data = mbs.AddNode(NodeGenericData(initialCoordinates=[1], numberOfDataCoordinates=1))
        ground = MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
        markers = [mbs.AddMarker(one) for one in (ground, MarkerNodeCoordinate(nodeNumber=tip, coordinate=1))]
        spring = {"contactStiffness": 20, "contactDamping": 0.1, "offset": -0.3}
        mbs.AddObject(ObjectContactCoordinate(markerNumbers=markers, nodeNumber=data, **spring))
        kinds = exudyn.OutputVariableType
        of_both = [
            SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True)
            for node, kind in ((tip, kinds.Position), (data, kinds.Coordinates))
        ]
        sensors = [mbs.AddSensor(sensor) for sensor in of_both]
        mbs.Assemble()
        return mbs, sensors

    return build


def test_contact_acts_and_is_shown_as_in_a_run_whose_steps_a_function_sees(bounce):
    (mbs, found, _), (seen_mbs, expected, _) = at_once_and_seen(bounce)
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(own, other)
    assert found[1][-1, 1] < 0 < found[1][1, 1]  # it has closed
    assert mbs.systemData.GetDataCoordinates() == seen_mbs.systemData.GetDataCoordinates()


@pytest.fixture
def ball(new_mbs, add_pendulum):
    """mbs with a ball that falls on triangles beside a cable; sensors of its distance and place."""

    def build():
        mbs = new_mbs()
        add_pendulum(mbs)
        inertia = InertiaSphere(1.0, RADIUS)
        number = mbs.CreateRigidBody(
            referencePosition=[1, 0, -0.5],
            initialVelocity=[0.3, 0, 0],
            inertia=inertia,
            nodeType=exudyn.NodeType.RotationEulerParameters,
            gravity=[0, 0, -9.81],
        )
        node = mbs.GetObject(number)["nodeNumber"]
        contact = mbs.AddGeneralContact()
        contact.SetFrictionPairings(np.full((1, 1), 0.3))
        contact.SetSearchTreeCellSize(numberOfCells=[4, 4, 4])
        surface = {"contactStiffness": 1e4, "contactDamping": 5, "frictionMaterialIndex": 0}
        contact.AddSphereWithMarker(mbs.AddMarker(MarkerNodeRigid(nodeNumber=node)), radius=RADIUS, **surface)
        corners = [[0, -1, -1], [2, -1, -1], [2, 1, -1], [0, 1, -1]]
        plate = mbs.AddMarker(MarkerBodyRigid(bodyNumber=mbs.CreateGround()))
        contact.AddTrianglesRigidBodyBased(
            plate, pointList=corners, triangleList=[[0, 1, 2], [0, 2, 3]], **surface
        )
        beam = {"positionOrMarker": [1, 0, 0.5], "dirSensor": [0, 0, -1], "maxDistance": 5}
        spheres = exudyn.ContactTypeIndex.IndexSpheresMarkerBased
        distance = mbs.CreateDistanceSensor(
            0, **beam, cylinderRadius=0.5, selectedTypeIndex=spheres, storeInternal=True
        )
        place = SensorNode(
            nodeNumber=node, outputVariableType=exudyn.OutputVariableType.Position, storeInternal=True
        )
        sensors = [distance, mbs.AddSensor(place)]
        mbs.Assemble()
        return mbs, sensors

    return build


def test_distances_of_a_general_contact_are_those_of_a_run_whose_steps_a_function_sees(ball):
    (_, found, path), (_, expected, _) = at_once_and_seen(ball)
    assert "GeneralContact with triangles" in path
    for own, other in zip(found, expected, strict=True):  # forces of steps taken again have other round-off
        np.testing.assert_allclose(own, other, rtol=0, atol=1e-13)
    distance, (_, _, height) = found[0][:, 1], found[1][:, 1:].T
    assert height.min() < RADIUS - 1 < height[-1] - 0.01  # it has touched the plate, and come back
    np.testing.assert_allclose(distance, 0.5 - height - RADIUS, rtol=0, atol=1e-9)


def test_the_limit_of_the_step_is_found_again_only_after_contact_has_closed(bounce, monkeypatch):
    times, find = [], CoupledRun._limit_of_motion
    monkeypatch.setattr(
        CoupledRun, "_limit_of_motion", lambda run, time: times.append(round(time, 6)) or find(run, time)
    )
    mbs, sensors = bounce()
    (_, gap), _ = solved(mbs, sensors)
    closed = gap[gap[:, 1] < 0, 0][0]
    assert max(time for time in times if time < closed - PERIOD) < PERIOD
    assert max(times) > closed - PERIOD
