"""What is left out where a user function acts between steps, and that it changes nothing."""

import numpy as np
import pytest
from exudyn import OutputVariableType
from exudyn.itemInterface import (
    CoordinateSpringDamper,
    DistanceConstraint,
    GenericJoint,
    HydraulicActuatorSimple,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodeRigid,
    MassPoint2D,
    Node1D,
    NodeGenericODE1,
    NodePoint,
    NodeRigidBody2D,
    ObjectGenericODE2,
    RigidBody2D,
    SensorNode,
    SensorObject,
    SphericalJoint,
    SpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import CreateCompanionCables, DivergenceError, SceneError
from exudyn_inext.cable.support_forces import SupportedCable
from exudyn_inext.compiled import Prepared
from exudyn_inext.exudyn_binding import time_loop
from exudyn_inext.exudyn_binding.changes import follower
from exudyn_inext.exudyn_binding.scene_runs import RunBuilder
from exudyn_inext.exudyn_binding.sensors import OutputTimes
from exudyn_inext.lowered import _kinds
from exudyn_inext.run.cable_run import CableRun
from exudyn_inext.run.kept_state import KeptState
from reference_models.model import quiet_settings
from tests.exudyn_binding.test_changes_between_steps import (
    TIP,
    Model,
    deviation,
    driven_mass,
    force_on_a_node,
    moved,
    moving_end_of_a_hanger,
    moving_support,
    name_of,
    release,
    spring_and_force,
    winch,
)


def winch_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return winch(model)


def moving_end_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return moving_end_of_a_hanger(model)


def body_at_the_tip(model):
    """(node, object) of a rigid body, which a joint ties to the cable."""
    inertia = InertiaCuboid(500, [0.04, 0.05, 0.06]).Translated([0.02, 0, 0])
    body = model.mbs.CreateRigidBody(
        inertia=inertia, referencePosition=TIP, gravity=[0, -9.81, 0], returnDict=True
    )
    model.watch(body["nodeNumber"])
    ties = [model.at(model.nodes[-1]), model.at(body["nodeNumber"])]
    model.mbs.AddObject(SphericalJoint(markerNumbers=ties))
    return body["nodeNumber"], body["bodyNumber"]


def ground_that_moves(model):
    """A body slides on it, and a spring is tied to it."""
    node, _ = body_at_the_tip(model)
    ground = model.mbs.CreateGround(referencePosition=TIP)
    markers = [
        model.mbs.AddMarker(MarkerBodyRigid(bodyNumber=ground)),
        model.mbs.AddMarker(MarkerNodeRigid(nodeNumber=node)),
    ]
    model.mbs.AddObject(GenericJoint(markerNumbers=markers, constrainedAxes=[0, 1, 0, 0, 0, 0]))
    above = model.mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=[0.2, 0.5, 0]))
    ends = [above, model.at(model.nodes[4])]
    model.mbs.AddObject(SpringDamper(markerNumbers=ends, referenceLength=1.0, stiffness=5.0))
    return lambda t: model.set_object(ground, referencePosition=[1.8, 0.6 * t**2, 0])


def marker_that_moves_on_a_body(model):
    _, body = body_at_the_tip(model)
    marker = model.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
    ends = [model.at_point([1.8, 0.5, 0]), marker]
    model.mbs.AddObject(DistanceConstraint(markerNumbers=ends, distance=0.5))
    return lambda t: model.mbs.SetMarkerParameter(marker, "localPosition", [0.05 * t, 0.1 * t**2, 0])


def body_that_gets_heavier(model):
    _, body = body_at_the_tip(model)
    inertia = np.array(model.mbs.GetObjectParameter(body, "inertia"))

    def change(t):
        model.set_object(body, mass=0.06 * (1 + 4 * t), inertia=inertia * (1 + 9 * t))
        model.mbs.SetLoadParameter(weight, "loadVector", [0, -9.81, 2 * t])

    weight = model.mbs.systemData.NumberOfLoads() - 1
    return change


def centre_of_mass_that_moves(model):
    """Of a planar body that turns about the tip; its weight goes with it."""
    mbs, node = model.mbs, NodeRigidBody2D(referenceCoordinates=[1.9, 0, 0], initialVelocities=[0, 0.8, 8])
    number = mbs.AddNode(node)
    body = mbs.AddObject(RigidBody2D(nodeNumber=number, mass=0.3, inertia=8e-3))
    marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
    mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, -9.81, 0]))
    end = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[-0.1, 0, 0]))
    markers = [model.at(model.nodes[-1]), end]
    mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0]))
    model.watch(number)
    return lambda t: model.set_object(body, centerOfMass=[0.08 * np.sin(9 * t), 0.05 * np.sin(6 * t)])


def matrices_that_change(model):
    """Of two masses, one of which pulls at the tip."""
    mbs = model.mbs
    nodes = [mbs.AddNode(Node1D(referenceCoordinates=[0.0])) for _ in range(2)]
    number = mbs.AddObject(ObjectGenericODE2(nodeNumbers=nodes, massMatrix=np.eye(2)))
    ends = (nodes[0], 0), (model.nodes[-1], 1)
    markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=k)) for n, k in ends]
    mbs.AddObject(CoordinateSpringDamper(markerNumbers=markers, stiffness=20, damping=0.5))
    chain = np.array([[2.0, -1.0], [-1.0, 1.0]])

    def change(t):
        model.set_object(number, stiffnessMatrix=(20 + 60 * t) * chain, dampingMatrix=3 * t * chain)
        model.set_object(number, forceVector=[2.0 * np.sin(9 * t), 1.0])

    return change


STAY_COMPILED = [
    driven_mass,
    moving_support,
    winch,
    winch_beside_a_mass,
    moving_end_beside_a_mass,
    ground_that_moves,
    marker_that_moves_on_a_body,
    body_that_gets_heavier,
    matrices_that_change,
    centre_of_mass_that_moves,
]


def heavier_where_exudyn_gives_the_forces(model):
    tip = model.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=model.nodes[-1], coordinate=1))
    law = {"springForceUserFunction": lambda mbs, t, number, way, *others: 2.0 * way}
    model.mbs.AddObject(CoordinateSpringDamper(markerNumbers=[model.ground, tip], **law))
    return body_that_gets_heavier(model)


def heavier_where_exudyn_evaluates_all(model):
    start = {"referenceCoordinates": [0, 1, 0], "initialCoordinates": [0.1, 0, 0]}
    nodes, coupled = [model.mbs.AddNode(NodePoint(**start)) for _ in range(3)], np.eye(9) + 0.1
    model.mbs.AddObject(
        ObjectGenericODE2(nodeNumbers=nodes, massMatrix=coupled, stiffnessMatrix=10 * np.eye(9))
    )
    return body_that_gets_heavier(model)


def valve(model):
    """Of a cylinder that lifts a mass."""
    node, _ = model.mass_point([1.8, -0.4, 0], mass=2.0)
    oil = NodeGenericODE1(
        referenceCoordinates=[0, 0], initialCoordinates=[1e5, 1e5], numberOfODE1Coordinates=2
    )
    cylinder = HydraulicActuatorSimple(
        markerNumbers=[model.at_point([1.8, -1.4, 0]), model.at(node)],
        nodeNumbers=[model.mbs.AddNode(oil)],
        offsetLength=0.6,
        strokeLength=0.8,
        chamberCrossSection0=2e-4,
        chamberCrossSection1=2e-4,
        hoseVolume0=1e-3,
        hoseVolume1=1e-3,
        actuatorDamping=100,
        oilBulkModulus=1e8,
        nominalFlow=1e-7,
        systemPressure=5e5,
    )
    number = model.mbs.AddObject(cylinder)
    return lambda t: model.set_object(number, valveOpening0=np.sin(9 * t), valveOpening1=-np.sin(9 * t))


EVALUATED = [
    heavier_where_exudyn_gives_the_forces,
    heavier_where_exudyn_evaluates_all,
    valve,
]


@pytest.mark.parametrize("kind", STAY_COMPILED + EVALUATED, ids=name_of)
def test_joints_that_are_moved_masses_and_valves_change_in_one_scene(kind, monkeypatch):
    """Compiled ones stay in compiled code."""
    builds, build = [], RunBuilder.build
    monkeypatch.setattr(RunBuilder, "build", lambda *given, **more: builds.append(1) or build(*given, **more))
    ours, native = (moved(kind, is_native, end_time=0.15) for is_native in (False, True))
    assert ("Exudyn evaluates" in ours.report["path"]) == (kind in EVALUATED)
    assert deviation(ours.motion, native.motion) < 0.003
    assert len(builds) <= 2


@pytest.mark.parametrize("is_compiled", [True, False])
def test_a_mass_that_is_set_to_nothing_is_refused_by_name(is_compiled):
    model = Model(False)
    if not is_compiled:
        heavier_where_exudyn_evaluates_all(model)
    _, body = model.mass_point([1.8, -0.4, 0])
    model.mbs.SetPreStepUserFunction(
        lambda mbs, t: mbs.SetObjectParameter(body, "mass", 0.05 * (t < 0.01)) or True
    )
    said = r"\(MassPoint\) was given a mass that is none" if is_compiled else r"\(Point\) has .* without mass"
    with pytest.raises(SceneError, match=said):
        model.run(0.02, 1e-3)


def weight_that_swings(model):
    """Of a cable, and of a mass point that is part of it, by their numbers."""
    mbs = model.mbs
    if model.native:
        bodies = [
            k for k in range(mbs.systemData.NumberOfObjects()) if "ANCF" in mbs.GetObject(k)["objectType"]
        ]
    else:
        bodies = CreateCompanionCables(mbs, model.cable)
    bodies.append(mbs.AddObject(MassPoint2D(nodeNumber=model.nodes[-1], mass=0.03)))
    markers = [mbs.AddMarker(MarkerBodyMass(bodyNumber=body)) for body in bodies]
    loads = [mbs.AddLoad(LoadMassProportional(markerNumber=m, loadVector=[0, 0, 0])) for m in markers]

    def change(t):
        for number, load in enumerate(loads):
            mbs.SetLoadParameter(load, "loadVector", [9 * np.sin(9 * t), 3 * (number % 2), 0])

    return change


def weight_that_swings_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return weight_that_swings(model)


def run_with_weights(kind, native):
    model = Model(native, ancf=native)
    change = kind(model)
    model.mbs.SetPreStepUserFunction(lambda mbs, t: change(t) or True)
    model.run(0.2, 1e-3)
    return model.motion


@pytest.mark.parametrize("kind", [weight_that_swings, weight_that_swings_beside_a_mass], ids=name_of)
def test_weights_that_are_set_act_at_once_as_on_a_stiff_native_cable(kind, monkeypatch):
    reads, read = [], follower.read_scene
    monkeypatch.setattr(follower, "read_scene", lambda *given: reads.append(1) or read(*given))
    assert deviation(run_with_weights(kind, False), run_with_weights(kind, True)) < 0.01
    assert len(reads) <= 3


def stop_that_is_set_before_it_acts(model):
    """Its place is set at each step, long before it is switched on."""
    node, _ = model.mass_point([1.8, 0, 0])
    stop = model.hold(node, 1, active=False)

    def change(t):
        if t < 0.2:
            model.set_object(stop, offset=float(model.position(node)[1]))
        model.set_object(stop, activeConnector=t > 0.2)

    return change


def test_the_place_of_a_joint_may_be_set_before_it_is_switched_on():
    ours, native = (
        moved(stop_that_is_set_before_it_acts, is_native, end_time=0.3) for is_native in (False, True)
    )
    assert deviation(ours.motion, native.motion) < 0.01


@pytest.mark.parametrize("kind", [force_on_a_node, spring_and_force, driven_mass], ids=name_of)
def test_kernels_are_called_with_the_types_that_they_are_prepared_for(kind, monkeypatch):
    call, first, calls = Prepared.__call__, {}, []

    def checked(self, *arguments):
        kinds = _kinds(arguments)
        assert first.setdefault(self, kinds) == kinds
        calls.append(self)
        return call(self, *arguments)

    monkeypatch.setattr(Prepared, "__call__", checked)
    moved(kind, False, end_time=0.05)
    assert len(calls) >= 50  # as many as steps


def force_that_is_switched_on(model):
    load = model.force(model.nodes[-1])
    return lambda t: model.mbs.SetLoadParameter(load, "loadVector", [0, 0.5 * (t > 0.2), 0])


def force_on_a_mass_that_is_switched_on(model):
    node, _ = model.mass_point([1.8, 0, 0])
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)]))
    load = model.force(node)
    return lambda t: model.mbs.SetLoadParameter(load, "loadVector", [0, 0.5 * (t > 0.2), 0])


def velocities_that_are_halved(model):
    data = model.mbs.systemData

    def change(t):
        if abs(t - 0.2) < 1e-9:
            data.SetODE2Coordinates_t(0.5 * np.asarray(data.GetODE2Coordinates_t()))

    return change


def number_that_a_load_reads(model):
    """The load seems to be of the time alone, and is not."""
    height = 0.0
    model.force(model.nodes[-1], loadVectorUserFunction=lambda mbs, t, load: [0, height * t, 0])

    def change(t):
        nonlocal height
        height = 3.0 * (t > 0.2)

    return change


JUMPS = [
    force_that_is_switched_on,
    force_on_a_mass_that_is_switched_on,
    velocities_that_are_halved,
    number_that_a_load_reads,
    release,
]


@pytest.mark.parametrize("kind", JUMPS, ids=name_of)
def test_a_change_after_many_steps_without_one_acts_in_the_next_step(kind, monkeypatch):
    together = moved(kind, False, end_time=0.4, step=1e-3).motion
    monkeypatch.setattr(time_loop, "UNSEEN", 1)
    one_by_one = moved(kind, False, end_time=0.4, step=1e-3).motion
    np.testing.assert_allclose(together, one_by_one, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "kind", [force_that_is_switched_on, force_on_a_mass_that_is_switched_on], ids=name_of
)
def test_a_force_that_is_switched_on_late_acts_as_under_the_implicit_solver(kind):
    ours, native = (moved(kind, is_native, end_time=0.4, step=5e-4) for is_native in (False, True))
    assert deviation(ours.motion, native.motion) < 0.003


def test_a_function_that_only_looks_sees_each_of_the_steps_that_are_computed_together(monkeypatch):
    model, record, seen, calls = Model(False), CableRun.record, [], []

    def look(mbs, t):
        seen.append(mbs.GetSensorValues(model.sensors[0]))
        return True

    def counted(*arguments):
        calls.append(1)
        return record(*arguments)

    monkeypatch.setattr(CableRun, "record", counted)
    model.mbs.SetPreStepUserFunction(look)
    model.run(0.3, 1e-3)
    np.testing.assert_array_equal(seen[::10], model.motion[:-1, 0])
    assert 10 * len(calls) < len(seen)


def test_a_run_that_diverges_while_a_function_looks_ends_in_its_last_good_step(monkeypatch):
    ends = []
    for unseen in (time_loop.UNSEEN, 1):
        monkeypatch.setattr(time_loop, "UNSEEN", unseen)
        model = Model(False)
        model.mbs.SetPreStepUserFunction(lambda mbs, t: True)
        with pytest.warns(UserWarning, match="stability limit"), pytest.raises(DivergenceError):
            model.run(1.1, 1.1e-3, stepSize=1.1e-3, allowUnstableStep=True, rejectSteps=False)
        assert model.mbs.systemData.GetTime() > 0.02
        ends.append([model.mbs.systemData.GetTime(), *model.mbs.systemData.GetODE2Coordinates()])
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-12)


def test_a_state_is_kept_whatever_the_gaps_between_its_numbers():
    whole = np.arange(60.0).reshape(3, 4, 5)
    records = np.zeros(4, [("a", np.int64), ("b", np.float64, (2,))])
    records["b"] = np.arange(8.0).reshape(4, 2)
    arrays = {
        "gaps": whole[:, ::2, 1:3],
        "whole": np.arange(3),
        "part": {"b": records["b"], "none": whole[:0]},
    }
    kept, before = KeptState(arrays), whole.copy()
    whole[:], records["b"] = -1.0, -1.0
    arrays["whole"][:] = -1
    kept.restore()
    np.testing.assert_array_equal(whole[:, ::2, 1:3], before[:, ::2, 1:3])
    assert (whole[:, 1::2] == -1.0).all()
    np.testing.assert_array_equal(records["b"].ravel(), np.arange(8.0))
    np.testing.assert_array_equal(arrays["whole"], np.arange(3))
    records["b"] = 5.0
    kept.keep()
    records["b"] = 6.0
    kept.restore()
    assert (records["b"] == 5.0).all()


def load_that_is_set(model):
    load = model.force(model.nodes[-1])
    return lambda mbs, t: mbs.SetLoadParameter(load, "loadVector", [np.sin(9 * t), 0, 0]) or True


def support_that_is_set(model):
    support = model.supports[0]
    return lambda mbs, t: mbs.SetObjectParameter(support, "offset", float(0.1 * np.sin(9 * t))) or True


def support_that_is_set_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return support_that_is_set(model)


def load_that_follows_the_state(model):
    node = model.nodes[-1]

    def drag(mbs, t, load):
        v = np.array(mbs.GetNodeOutput(node, OutputVariableType.Velocity))
        return (-0.1 * np.linalg.norm(v) * v).tolist()

    model.force(node, loadVectorUserFunction=drag)


def spring_that_follows_the_state(model):
    node = model.nodes[-1]

    def force(mbs, t, number, length, rate, stiffness, damping, initial):
        return 5.0 * length - 0.1 * mbs.GetNodeOutput(node, OutputVariableType.Velocity)[1]

    ends = [model.at_point([2, 1, 0]), model.at(model.nodes[-1])]
    model.mbs.AddObject(SpringDamper(markerNumbers=ends, referenceLength=1.0, springForceUserFunction=force))


SEEN_TO_SET = [load_that_is_set, support_that_is_set, support_that_is_set_beside_a_mass]  # and to do no more
SEEN_TO_FOLLOW = [load_that_follows_the_state, spring_that_follows_the_state]


def written_rows(kind, folder, period, monkeypatch, each_step=False):
    """Of the solution file, and of a sensor, and how often reactions of supports were solved for."""
    calls, solve = [], SupportedCable.solve
    monkeypatch.setattr(SupportedCable, "solve", lambda *given: calls.append(1) or solve(*given))
    monkeypatch.setattr(OutputTimes, "due", lambda *_: -np.inf) if each_step else None
    model = Model(False)
    model.mbs.SetPreStepUserFunction(kind(model) or 0)
    force = SensorObject(
        objectNumber=model.supports[1], storeInternal=True, outputVariableType=OutputVariableType.Force
    )
    sensor = model.mbs.AddSensor(force)
    model.mbs.Assemble()
    settings = quiet_settings(0.05, 50, 0.013)
    settings.solution.file.write, settings.solution.file.writePeriod = True, period
    settings.solution.file.name = str(folder / f"rows{each_step}")
    model.run_again(settings)
    monkeypatch.undo()
    (path,) = folder.glob(f"rows{each_step}*")
    rows = np.loadtxt(path, comments="#", delimiter=","), np.array(model.mbs.GetSensorStoredData(sensor))
    return rows, len(calls)


@pytest.mark.parametrize("kind", SEEN_TO_SET + SEEN_TO_FOLLOW, ids=name_of)
@pytest.mark.parametrize("period", [0.01, 0.007])
def test_forces_are_solved_for_where_they_are_written_or_sensed_alone(kind, period, tmp_path, monkeypatch):
    found, few = written_rows(kind, tmp_path, period, monkeypatch)
    wanted, many = written_rows(kind, tmp_path, period, monkeypatch, each_step=True)
    for rows, wanted_rows in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(rows, wanted_rows)
    assert len(found[1]) < 6 and few < 15 < 50 <= many


def load_that_follows_a_force(model):
    support = model.supports[1]

    def pull(mbs, t, load):
        return [0, -0.1 * float(np.max(mbs.GetObjectOutput(support, OutputVariableType.Force))), 0]

    model.force(model.nodes[-1], loadVectorUserFunction=pull)


def test_forces_are_solved_for_at_each_step_where_a_load_looks_at_them(tmp_path, monkeypatch):
    _, calls = written_rows(load_that_follows_a_force, tmp_path, 0.01, monkeypatch)
    assert calls >= 50


def controller_beside_a_sensor_of_forces(model):
    """Sensors of a support are there, and the function reads another one."""
    place = SensorNode(nodeNumber=model.nodes[-1], outputVariableType=OutputVariableType.Position)
    sensor, load = model.mbs.AddSensor(place), model.force(model.nodes[-1])

    def pull(mbs, t):
        x = mbs.GetSensorValues(sensor).reshape(3)
        return mbs.SetLoadParameter(load, "loadVector", [0, float(-x[1].round(9)), 0]) or True

    return pull


def test_forces_are_not_solved_for_because_a_function_reads_other_sensors(tmp_path, monkeypatch):
    found, few = written_rows(controller_beside_a_sensor_of_forces, tmp_path, 0.01, monkeypatch)
    wanted, _ = written_rows(controller_beside_a_sensor_of_forces, tmp_path, 0.01, monkeypatch, True)
    for rows, wanted_rows in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(rows, wanted_rows)
    assert few < 15


def seen_by_a_controller(kind, monkeypatch, each_step):
    """Forces of a support and accelerations that a function reads at some steps, and then acts on."""
    monkeypatch.setattr(OutputTimes, "due", lambda *_: -np.inf) if each_step else None
    model, seen = Model(False), []
    kind(model)
    reaction = SensorObject(objectNumber=model.supports[1], outputVariableType=OutputVariableType.Force)
    motion = SensorNode(nodeNumber=model.nodes[-1], outputVariableType=OutputVariableType.Acceleration)
    sensors, load = [model.mbs.AddSensor(one) for one in (reaction, motion)], model.force(model.nodes[-1])

    def follow(mbs, t):
        mbs.SetLoadParameter(load, "loadVector", [np.sin(9 * t), 0, 0])
        if round(t / 1e-3) % 3 == 1:
            seen.append(np.append(*(mbs.GetSensorValues(one) for one in sensors)))
            mbs.SetLoadParameter(load, "loadVector", [0, 1e-3 * seen[-1][0], 0])
        return True

    model.mbs.SetPreStepUserFunction(follow)
    model.mbs.Assemble()
    model.run_again(quiet_settings(0.03, 30))
    monkeypatch.undo()
    return np.array(seen)


@pytest.mark.parametrize("kind", [lambda model: None, body_at_the_tip], ids=["alone", "a body"])
def test_forces_that_a_function_asks_for_are_those_of_the_state_before_it(kind, monkeypatch):
    seen = seen_by_a_controller(kind, monkeypatch, each_step=False)
    np.testing.assert_array_equal(seen, seen_by_a_controller(kind, monkeypatch, each_step=True))
    assert len(np.unique(seen[:, 0])) == len(seen) == 10
