"""Joints that step functions move show the forces and accelerations of native joints."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateVectorConstraint,
    GenericJoint,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodeCoordinates,
    MarkerNodePosition,
    NodePointGround,
    SensorBody,
    SensorNode,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import CreateCableForceSensor, ExplicitStepper, SceneError, SolveExplicit
from exudyn_inext.exudyn_binding.changes.follower import ChangeFollower
from exudyn_inext.run.coupled_watch import CoupledWatch
from exudyn_inext.run.steered import Steered
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import SECTION, either_cable, solve_native

END, STEPS = 0.3, 300
GRAVITY = [0, -9.81, 0]


def way(t):
    return 0.2 * np.sin(6.0 * t) ** 2


def speed(t):
    return 1.2 * np.sin(12.0 * t)


class Driven:
    """A body with a cable at it, which is driven along x by a joint.

    acceleration: sensor of the body.   read: by a function of the user [m].
    """

    def __init__(self, mbs, native):
        self.mbs, self.read = mbs, 0.0
        self.ground = mbs.CreateGround()
        self.body = mbs.CreateRigidBody(
            inertia=InertiaCuboid(density=1000, sideLengths=[0.1, 0.1, 0.1]), gravity=GRAVITY, create2D=True
        )
        line = {"positionStart": [0, 0, 0], "positionEnd": [0, -1, 0], "numberOfElements": 3}
        nodes, self.cable = either_cable(mbs, native, 2, SECTION, 8e4, gravity=GRAVITY, **line)
        ends = MarkerBodyPosition(bodyNumber=self.body), MarkerNodePosition(nodeNumber=nodes[0])
        self.hinge = self._join(SphericalJoint, ends, constrainedAxes=[1, 1, 0])
        kind = exudyn.OutputVariableType.Acceleration
        self.acceleration = mbs.AddSensor(
            SensorBody(bodyNumber=self.body, outputVariableType=kind, storeInternal=True)
        )

    def _join(self, joint, markers, **options):
        return self.mbs.AddObject(joint(markerNumbers=[self.mbs.AddMarker(m) for m in markers], **options))

    def hold(self, axes, **options):
        """A GenericJoint on ground, and the number of its marker there."""
        markers = MarkerBodyRigid(bodyNumber=self.ground), MarkerBodyRigid(bodyNumber=self.body)
        joint = self._join(GenericJoint, markers, constrainedAxes=axes, **options)
        return joint, int(self.mbs.GetObject(joint)["markerNumbers"][0])

    def rail(self, **options):
        """A CoordinateConstraint on the place along a rail."""
        self.hold([0, 1, 0, 0, 0, 1])
        node = self.mbs.GetObject(self.body)["nodeNumber"]
        ground = MarkerNodeCoordinate(nodeNumber=self.mbs.AddNode(NodePointGround()), coordinate=0)
        markers = ground, MarkerNodeCoordinate(nodeNumber=node, coordinate=0)
        return self._join(CoordinateConstraint, markers, **options)


def by_its_offset(scene):
    joint = scene.rail()
    return joint, lambda t: scene.mbs.SetObjectParameter(joint, "offset", way(t))


def by_what_its_function_reads(scene):
    joint = scene.rail(offsetUserFunction=lambda mbs, t, i, offset: scene.read)
    return joint, lambda t: setattr(scene, "read", way(t))


def by_what_its_frame_reads(scene):
    joint, _ = scene.hold(
        [1, 1, 0, 0, 0, 1], offsetUserFunction=lambda mbs, t, i, p: [scene.read, *[0.0] * 5]
    )
    return joint, lambda t: setattr(scene, "read", way(t))


def by_parameters_of_its_frame(scene):
    joint, _ = scene.hold([1, 1, 0, 0, 0, 1], offsetUserFunction=lambda mbs, t, i, offsets: offsets)
    name = "offsetUserFunctionParameters"
    return joint, lambda t: scene.mbs.SetObjectParameter(joint, name, [way(t), *[0.0] * 5])


def by_its_velocity(scene):
    joint = scene.rail(velocityLevel=True)
    return joint, lambda t: scene.mbs.SetObjectParameter(joint, "offset", speed(t))


def by_the_ground(scene):
    joint, _ = scene.hold([1, 1, 0, 0, 0, 1])
    return joint, lambda t: scene.mbs.SetObjectParameter(scene.ground, "referencePosition", [way(t), 0, 0])


def by_a_marker(scene):
    joint, marker = scene.hold([1, 1, 0, 0, 0, 1])
    return joint, lambda t: scene.mbs.SetMarkerParameter(marker, "localPosition", [way(t), 0, 0])


def by_a_length(scene):
    scene.hold([0, 1, 0, 0, 0, 1])
    other = scene.mbs.CreateGround(referencePosition=[-1, 0, 0])
    joint = scene.mbs.CreateDistanceConstraint(itemNumbers=[other, scene.body], distance=1.0)
    return joint, lambda t: scene.mbs.SetObjectParameter(joint, "distance", 1.0 + way(t))


def by_an_offset_of_coordinates(scene):
    scene.hold([0, 1, 0, 0, 0, 1])
    node, ground = scene.mbs.GetObject(scene.body)["nodeNumber"], scene.mbs.AddNode(NodePointGround())
    markers = [MarkerNodeCoordinates(nodeNumber=one) for one in (ground, node)]
    joint = scene._join(CoordinateVectorConstraint, markers, scalingMarker1=[[1.0, 0.0, 0.0]], offset=[0.0])
    return joint, lambda t: scene.mbs.SetObjectParameter(joint, "offset", [way(t)])


FUNCTIONS = by_what_its_function_reads, by_what_its_frame_reads, by_parameters_of_its_frame
KINDS = (
    by_its_offset,
    *FUNCTIONS,
    by_its_velocity,
    by_the_ground,
    by_a_marker,
    by_a_length,
    by_an_offset_of_coordinates,
)


def steered(new_mbs, kind, native):
    """(T, 2) size of the force of the joint, and acceleration of the body along x."""
    mbs = new_mbs()
    scene = Driven(mbs, native)
    joint, drive = kind(scene)
    outputs = exudyn.OutputVariableType
    is_generic = mbs.GetObject(joint)["objectType"] == "JointGeneric"
    force = outputs.ForceLocal if is_generic else outputs.Force
    sensor = mbs.AddSensor(SensorObject(objectNumber=joint, outputVariableType=force, storeInternal=True))

    def step(mbs, t):
        drive(t)
        return True

    mbs.SetPreStepUserFunction(step)
    mbs.Assemble()
    if native:
        solve_native(mbs, END)
    else:
        SolveExplicit(mbs, quiet_settings(END, STEPS))
    forces = np.linalg.norm(mbs.GetSensorStoredData(sensor)[:, 1:], axis=1)
    return np.column_stack([forces, mbs.GetSensorStoredData(scene.acceleration)[:, 1]])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_what_step_functions_drive_has_forces_and_accelerations_as_natively(new_mbs, kind):
    """They are those of the motion: on straight ways, bodies seemed to have no acceleration."""
    ours, native = (steered(new_mbs, kind, native) for native in (False, True))
    is_later = slice(10, None)  # native forces swing at the start
    largest = np.abs(ours - native)[is_later].max(axis=0)
    assert (largest / np.ptp(native[is_later], axis=0)).max() < 0.03


LOG = []


class Carriage:
    """Ground leads a body with a cable along, and turns it, by a function that reads `place` and `angle`.

    is_compiled: whether compiled code asks that function, which stores nothing then.
    """

    def __init__(self, mbs, dim, is_compiled, drive):
        self.mbs, self.place, self.angle = mbs, 0.0, 0.0
        body = mbs.CreateRigidBody(
            inertia=InertiaCuboid(density=1000, sideLengths=[0.1, 0.1, 0.2]),
            gravity=GRAVITY,
            create2D=dim == 2,
        )
        line = {"positionStart": [0, 0, 0], "positionEnd": [0, -1, 0], "numberOfElements": 3}
        nodes, self.cable = either_cable(mbs, False, dim, SECTION, 8e4, gravity=GRAVITY, **line)
        markers = [MarkerBodyPosition(bodyNumber=body), MarkerNodePosition(nodeNumber=nodes[0])]
        axes = [1, 1, dim - 2]
        mbs.AddObject(SphericalJoint(markerNumbers=list(map(mbs.AddMarker, markers)), constrainedAxes=axes))
        markers = [MarkerBodyRigid(bodyNumber=one) for one in (mbs.CreateGround(), body)]

        def offsets(mbs, t, i, parameters):
            turns = [0.5 * self.angle * (dim - 2), 0.3 * t**2 * (dim - 2), self.angle]
            return [self.place, 0.1 * t**2, 0.0, *turns]

        def stored(mbs, t, i, parameters):
            LOG.append(t)
            return offsets(mbs, t, i, parameters)

        free = dim - 2  # out of the plane
        mbs.AddObject(
            GenericJoint(
                markerNumbers=list(map(mbs.AddMarker, markers)),
                constrainedAxes=[1, 1, free, free, free, 1],
                offsetUserFunction=offsets if is_compiled else stored,
            )
        )

        def step(mbs, t):
            drive(self, t)
            return True

        mbs.SetPreStepUserFunction(step)
        mbs.Assemble()


def test_sections_feel_how_step_functions_move_joints(mbs):
    """At the end of a cable, the tension is the force of the joint there, along the slope."""
    scene = Driven(mbs, False)
    _, drive = by_a_length(scene)
    kind, node = exudyn.OutputVariableType, scene.cable["nodes"][0]
    force = {"outputVariableType": kind.Force, "storeInternal": True}
    shape = {"outputVariableType": kind.Coordinates, "storeInternal": True}
    of_joint = mbs.AddSensor(SensorObject(objectNumber=scene.hinge, **force))
    of_node = mbs.AddSensor(SensorNode(nodeNumber=node, **shape))
    of_section = CreateCableForceSensor(mbs, scene.cable, 0.0)
    mbs.SetPreStepUserFunction(lambda mbs, t: drive(t) or True)
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(END, STEPS))
    slope = mbs.GetSensorStoredData(of_node)[1:, 3:5] + [0.0, -1.0]
    along = np.sum(mbs.GetSensorStoredData(of_joint)[1:, 1:3] * slope, axis=1)
    tension = mbs.GetSensorStoredData(of_section)[1:, 1]
    np.testing.assert_allclose(np.abs(along), np.abs(tension), rtol=0.0, atol=1e-8 * np.abs(along).max())


def smoothly(scene, t):
    scene.place, scene.angle = way(t), 0.5 * way(t)


def at_once(scene, t):
    scene.place, scene.angle = 0.01 * (t > 0.02) - 0.01 * (t > 0.04), 0.02 * (t > 0.03)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("drive", [smoothly, at_once])
def test_functions_that_step_functions_steer_are_asked_by_compiled_code(new_mbs, dim, drive):
    """The motion is that which Exudyn's evaluations give."""
    found = []
    for is_compiled in (True, False):
        mbs = new_mbs()
        Carriage(mbs, dim, is_compiled, drive)
        path = SolveExplicit(mbs, quiet_settings(0.06, 60))["path"]
        assert ("reads what step functions may change" in path) == is_compiled
        found.append(mbs.systemData.GetODE2Coordinates())
    np.testing.assert_allclose(*found, rtol=0, atol=1e-9)


def test_the_extent_of_a_motion_counts_from_its_start(mbs, monkeypatch):
    """Errors of the step are compared with it; the way of one step would ask for much shorter ones."""
    starts, look = [], CoupledWatch.is_well_at

    def seen(watch, *given):
        starts.append(watch.memory()["start"].copy())
        return look(watch, *given)

    monkeypatch.setattr(CoupledWatch, "is_well_at", seen)
    _, drive = by_its_offset(Driven(mbs, False))
    mbs.SetPreStepUserFunction(lambda mbs, t: drive(t) or True)
    mbs.Assemble()
    SolveExplicit(mbs, quiet_settings(END, STEPS))
    np.testing.assert_array_equal(starts[STEPS // 10], starts[-1])


def test_joints_that_move_on_need_no_new_reading(mbs, monkeypatch):
    readings, read = [], ChangeFollower._followed
    monkeypatch.setattr(ChangeFollower, "_followed", lambda *given: readings.append(1) or read(*given))
    Carriage(mbs, 2, True, smoothly)
    SolveExplicit(mbs, quiet_settings(0.06, 60))
    assert 1 <= len(readings) <= 2


def test_who_does_without_step_functions_refuses_what_they_steer(mbs):
    Carriage(mbs, 2, True, smoothly)
    mbs.SetPreStepUserFunction(0)
    message = r"ExplicitStepper cannot ask the function of object 4 .*\(JointGeneric\).*use SolveExplicit"
    with pytest.raises(SceneError, match=message):
        ExplicitStepper(mbs)


def places_after(places):
    """(3, 1) place, velocity, acceleration at the end of the last of these steps of 0.1 s."""
    one, steps = Steered(1), np.diff(places)
    for k, step in enumerate(steps):
        one.aim(np.array([step]), 0.1 * k, 0.1 * (k + 1))
    return one, 0.1 * len(steps)


def test_a_steady_acceleration_is_kept():
    one, end = places_after([0.0, 0.5, 2.0, 4.5])
    np.testing.assert_allclose(one.left_at([end])[0], [[0.0], [-30.0], [-100.0]], atol=1e-9)
    np.testing.assert_allclose(one.left_at([end - 0.05])[0], [[1.375], [-25.0], [-100.0]])
    np.testing.assert_allclose(one.left_at([end - 0.1])[0, 0], [2.5])


@pytest.mark.parametrize("places", [[0, 0, 1], [0, 0, 1, 1, 2], [0, 1, 0, 1]], ids=str)
def test_jumps_are_straight(places):
    one, end = places_after(np.array(places, dtype=float))
    np.testing.assert_allclose(one.left_at([end - 0.05])[0], [[0.5], [-10.0], [0.0]], atol=1e-12)


def test_a_way_after_a_rest_begins_straight():
    one, end = places_after([0.0, 0.5, 2.0])
    one.rest()
    assert not one.left_at([end])[0].any()
    one.aim(np.ones(1), end + 0.1, end + 0.2)
    np.testing.assert_allclose(one.left_at([end + 0.2])[0], [[0.0], [-10.0], [0.0]], atol=1e-9)
