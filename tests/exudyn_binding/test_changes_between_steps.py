"""What pre- and post-step functions change acts from that step on, as with Exudyn's implicit solver."""

from contextlib import suppress
from functools import cache, partial
from types import SimpleNamespace
from unittest.mock import Mock

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    DistanceConstraint,
    GenericJoint,
    LoadCoordinate,
    LoadForceVector,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericData,
    NodeGenericODE1,
    NodePointGround,
    ObjectGenericODE1,
    ObjectGenericODE2,
    SensorNode,
    SensorUserFunction,
    SphericalJoint,
    SpringDamper,
)
from exudyn.utilities import InertiaCuboid, RotationMatrixZ

from exudyn_inext import (
    AddPointMass,
    CableShape,
    CreateCableForceSensor,
    CreateCompanionCables,
    CreateInextensibleCable,
    ExplicitSettings,
    InextensibleCable,
    InputError,
    SceneError,
    SolveExplicit,
    StepSizeError,
)
from exudyn_inext.exudyn_binding.scene_runs import RunBuilder
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import native_cable, that_remembers

TEMPLATE = InextensibleCable(massPerLength=0.0348, bendingStiffness=0.0866)
PINNED = [True, True, False, False]
STEP = 1e-3
TIP = [1.8, 0, 0]


class Model:
    """A cable of 1.8 m, for SolveExplicit or, with its own constraints as native ones, for SolveDynamic.

    ancf: a native cable that hardly stretches, with twice as many elements, in place of the latter.
    """

    def __init__(self, native, dim=2, ancf=False, **changes):
        self.container = exudyn.SystemContainer()
        self.mbs = mbs = self.container.AddSystem()
        self.native = native
        self.ground = mbs.AddMarker(
            MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
        )
        self.sensors = []
        if ancf:
            self.nodes = native_cable(mbs, dim, 16)["nodes"][::2]
            self.supports = [self.hold(self.nodes[0], axis) for axis in range(dim)]
        else:
            self.add_cable(dim, changes)
        self.watch(self.nodes[-1])
        self.watch(self.nodes[4])

    def add_cable(self, dim, changes):
        pin = {"groundConstraintsStart": [True] * dim + [False] * dim}
        line = {"positionStart": [0, 0, 0], "positionEnd": TIP, "numberOfElements": 8}
        if "shape" in changes:
            line = {}
        self.cable = CreateInextensibleCable(
            self.mbs,
            beamTemplate=TEMPLATE,
            gravity=[0, -9.81, 0],
            dimension=dim,
            enforcement="algebraic" if self.native else "projection",
            **(line | pin | changes),
        )
        self.nodes = self.cable["nodes"]
        self.supports = self.cable["constraintObjects"][: 2 if dim == 2 else 3]

    def watch(self, node):
        kind = exudyn.OutputVariableType.Position
        sensor = SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind)
        self.sensors.append(self.mbs.AddSensor(sensor))
        return self.sensors[-1]

    def at(self, node):
        return self.mbs.AddMarker(MarkerNodePosition(nodeNumber=node))

    def at_point(self, point):
        ground = self.mbs.CreateGround(referencePosition=point)
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground))

    def force(self, node, vector=(0, 0, 0), **functions):
        return self.mbs.AddLoad(
            LoadForceVector(markerNumber=self.at(node), loadVector=list(vector), **functions)
        )

    def hold(self, node, coordinate, active=True, **parameters):
        marker = self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        constraint = CoordinateConstraint(
            markerNumbers=[self.ground, marker], activeConnector=active, **parameters
        )
        return self.mbs.AddObject(constraint)

    def hang(self, node, point, length, active=True):
        markers = [self.at_point(point), self.at(node)]
        rod = DistanceConstraint(markerNumbers=markers, distance=length, activeConnector=active)
        return self.mbs.AddObject(rod)

    def mass_point(self, position, mass=0.05, **initial):
        """(node, object) of a mass point under gravity."""
        body = self.mbs.CreateMassPoint(
            mass=mass, referencePosition=position, gravity=[0, -9.81, 0], returnDict=True, **initial
        )
        self.watch(body["nodeNumber"])
        return body["nodeNumber"], body["bodyNumber"]

    def set_object(self, number, **parameters):
        for name, value in parameters.items():
            self.mbs.SetObjectParameter(number, name, value)

    def position(self, node):
        return np.array(self.mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position))

    def run(self, end_time, step=STEP, **explicit):
        settings = quiet_settings(end_time, round(end_time / step))
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
        settings.timeIntegration.newton.relativeTolerance = 1e-6
        settings.timeIntegration.reuseConstantMassMatrix = False
        self.mbs.Assemble()
        return self.run_again(settings, **explicit)

    def run_again(self, settings, **explicit):
        with silence():
            if self.native:
                self.mbs.SolveDynamic(settings)
                return None
            return SolveExplicit(self.mbs, settings, ExplicitSettings(**explicit))

    @property
    def motion(self):
        """(T, S, 3) what the sensors have stored."""
        stored = [np.asarray(self.mbs.GetSensorStoredData(sensor)) for sensor in self.sensors]
        return np.stack([rows[:, 1:4] for rows in stored], axis=1)


def deviation(ours, native):
    """Largest distance of any sensor's path to the native one, over the largest motion."""
    size = np.linalg.norm(native - native[0], axis=2).max()
    return np.linalg.norm(ours - native, axis=2).max() / size


# ------------------------------------------------------------------ kinds of changes: each adds its items to
# a model, and returns (model, t): what is done before a step that ends at t.


def force_on_a_node(model):
    load = model.force(model.nodes[-1])

    def change(t):
        model.mbs.SetLoadParameter(load, "loadVector", [0.3 * np.sin(5 * t), 0.5 * (t > 0.2), 0])

    return change


def coordinate_load(model):
    marker = model.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=model.nodes[4], coordinate=1))
    load = model.mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=0.0))
    return lambda t: model.mbs.SetLoadParameter(load, "load", 0.6 if 0.1 < t < 0.3 else 0.0)


def load_that_walks(model):
    load = model.force(model.nodes[8], [0, 0.5, 0])
    markers = [model.at(node) for node in model.nodes]
    return lambda t: model.mbs.SetLoadParameter(load, "markerNumber", markers[8 - min(8, int(10 * t))])


def load_that_leaves_a_mass(model):
    """For a node of the cable that nothing else needs."""
    node, _ = model.mass_point([1.8, -0.4, 0])
    markers = [model.at(model.nodes[-1]), model.at(node)]
    model.mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=0.4, stiffness=50))
    load, marker = model.force(node, [0, 0.5, 0]), model.at(model.nodes[3])
    return lambda t: model.mbs.SetLoadParameter(load, "markerNumber", marker if t > 0.1 else markers[1])


def user_function_replaced(model):
    load = model.force(model.nodes[-1], loadVectorUserFunction=lambda mbs, t, load: [0.2 * t, 0, 0])

    def change(t):
        if abs(t - 0.25) < 1e-9:
            model.mbs.SetLoadParameter(load, "loadVectorUserFunction", lambda mbs, t, load: [0, 3 * t, 0])

    return change


def release(model):
    def change(t):
        if t > 0.2:
            for support in model.supports:
                model.set_object(support, activeConnector=False)

    return change


def release_and_catch(model):
    """The first node is let go, and held where it is a little later; the cable swings about it."""

    def change(t):
        for axis, support in enumerate(model.supports):
            if abs(t - 0.2) < 1e-9:
                model.set_object(support, activeConnector=False)
            if abs(t - 0.3) < 1e-9:
                place = float(model.position(model.nodes[0])[axis])
                model.set_object(support, offset=place, activeConnector=True)

    return change


def moving_support(model):
    return lambda t: model.set_object(model.supports[0], offset=float(0.1 * t * np.sin(6 * t)))


def moving_support_and_force(model):
    move, pull = moving_support(model), force_on_a_node(model)

    def change(t):
        move(t)
        pull(t)

    return change


def support_that_steps(model):
    """By 0.2 mm, ten times a second."""
    return lambda t: model.set_object(model.supports[1], offset=2e-4 * int(10 * t + 1e-9))


def hanger(model):
    rod = model.hang(model.nodes[-1], [1.8, 0.5, 0], 0.5)
    return lambda t: model.set_object(rod, activeConnector=t <= 0.2)


def hanger_that_catches(model):
    """The swinging tip is caught at 0.3 s, on a rod that is as long as the tip is away from its end."""
    end = np.array([1.4, 0.3, 0])
    rod = model.hang(model.nodes[-1], end.tolist(), 0.5, active=False)

    def change(t):
        if abs(t - 0.3) < 1e-9:
            distance = float(np.linalg.norm(model.position(model.nodes[-1]) - end))
            model.set_object(rod, distance=distance, activeConnector=True)

    return change


def winch(model):
    """A hanger that gets shorter while it swings."""
    rod = model.hang(model.nodes[-1], [1.4, 0.3, 0], 0.5)
    return lambda t: model.set_object(rod, distance=0.5 - 0.3 * t)


def moving_end_of_a_hanger(model):
    rod = model.hang(model.nodes[-1], [1.4, 0.3, 0], 0.5)
    marker = model.mbs.GetObjectParameter(rod, "markerNumbers")[0]
    return lambda t: model.mbs.SetMarkerParameter(marker, "localPosition", [0.3 * t, 0.5 * t**2, 0])


def moving_ground_of_a_hanger(model):
    rod = model.hang(model.nodes[-1], [1.4, 0.3, 0], 0.5)
    marker = model.mbs.GetObjectParameter(rod, "markerNumbers")[0]
    ground = model.mbs.GetMarkerParameter(marker, "bodyNumber")
    return lambda t: model.set_object(ground, referencePosition=[1.4 + 0.3 * t, 0.3 + 0.5 * t**2, 0])


def moving_ground_node_of_a_hanger(model):
    ground, place = ground_node(model, [1.4, 0.3, 0])
    ends = [ground, model.at(model.nodes[-1])]
    model.mbs.AddObject(DistanceConstraint(markerNumbers=ends, distance=0.5))
    return lambda t: place([1.4 + 0.3 * t, 0.3 + 0.5 * t**2, 0])


def moving_ground_node_of_a_spring(model):
    """A mass on it draws at the tip."""
    ground, place = ground_node(model, [1.8, -0.5, 0])
    node, _ = model.mass_point([1.8, -0.1, 0])
    for end, length in ((ground, 0.4), (model.at(model.nodes[-1]), 0.1)):
        ends = [end, model.at(node)]
        model.mbs.AddObject(SpringDamper(markerNumbers=ends, referenceLength=length, stiffness=20.0))
    return lambda t: place([1.8 - 0.5 * t, -0.5 - t, 0])


def ground_node(model, position):
    """A marker there, and what gives it another place."""
    node = model.mbs.AddNode(NodePointGround(referenceCoordinates=position))
    return model.at(node), lambda x: model.mbs.SetNodeParameter(node, "referenceCoordinates", x)


def weight(model):
    """On companions: kernels evaluate it, also among others."""
    markers = [
        model.mbs.AddMarker(MarkerBodyMass(bodyNumber=companion))
        for companion in CreateCompanionCables(model.mbs, model.cable)
    ]
    loads = [model.mbs.AddLoad(LoadMassProportional(markerNumber=m, loadVector=[0, 0, 0])) for m in markers]

    def change(t):
        for load in loads:
            model.mbs.SetLoadParameter(load, "loadVector", [9.0 * (t > 0.2), 0, 0])

    return change


def weight_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return weight(model)


def release_beside_a_mass(model):
    node, _ = model.mass_point([1.8, -0.4, 0])
    spring = SpringDamper(
        markerNumbers=[model.at(model.nodes[-1]), model.at(node)], referenceLength=0.4, stiffness=50
    )
    model.mbs.AddObject(spring)
    return release(model)


def joint_released_and_caught(model):
    """A mass at the tip is let go; a joint to the ground stops it."""
    node, _ = model.mass_point([1.8, 0, 0])
    joint = SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)])
    number = model.mbs.AddObject(joint)
    stop = model.hold(node, 1, active=False)

    def change(t):
        model.set_object(number, activeConnector=t < 0.3)
        if abs(t - 0.4) < 1e-9:
            model.set_object(stop, offset=float(model.position(node)[1]), activeConnector=True)

    return change


def spring_and_force(model):
    """Stiffness of a spring and a force on the mass behind it."""
    node, _ = model.mass_point([1.8, -0.4, 0])
    load = model.force(node)
    markers = [model.at(model.nodes[-1]), model.at(node)]
    spring = model.mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=0.4, stiffness=20))

    def change(t):
        model.set_object(spring, stiffness=20 + 40 * t, force=0.3 * (t > 0.1))
        model.mbs.SetLoadParameter(load, "loadVector", [np.sin(8 * t), 0, 0])

    return change


def spring_that_grabs(model):
    """For a while; the cable is alone before and after."""
    markers = [model.at_point([1.8, 0.3, 0]), model.at(model.nodes[-1])]
    spring = SpringDamper(markerNumbers=markers, referenceLength=0.3, stiffness=60, activeConnector=False)
    number = model.mbs.AddObject(spring)
    return lambda t: model.set_object(number, activeConnector=bool(0.1 < t < 0.25))


def spring_that_grabs_beside_a_mass(model):
    model.mass_point([0, 1, 0])
    return spring_that_grabs(model)


def driven_mass(model):
    """The coordinate of a mass, which a joint ties to the cable, is set step by step."""
    node, _ = model.mass_point([1.8, 0, 0])
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)]))
    drive = model.hold(node, 1)
    return lambda t: model.set_object(drive, offset=float(-0.8 * t**2))


def mass_driven_at_a_speed(model):
    node, _ = model.mass_point([1.8, 0, 0])
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)]))
    drive = model.hold(node, 1, velocityLevel=True)
    return lambda t: model.set_object(drive, offset=float(-1.6 * t))


def ground_that_turns(model):
    """A spring hangs at the end of its arm."""
    ground = model.mbs.CreateGround(referencePosition=[1.6, 0.3, 0])
    arm = model.mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground, localPosition=[0.2, 0, 0]))
    node, _ = model.mass_point([1.8, -0.1, 0])
    for marker, length in ((arm, 0.4), (model.at(model.nodes[-1]), 0.1)):
        markers = [marker, model.at(node)]
        model.mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=length, stiffness=20.0))
    return lambda t: model.set_object(ground, referenceRotation=RotationMatrixZ(3.0 * t))


def steered_joint(model):
    """It turns the body at the tip by an angle that its function takes from its parameters."""
    body = model.mbs.CreateRigidBody(
        inertia=InertiaCuboid(500, [0.1, 0.1, 0.02]), referencePosition=[1.8, 0, 0], returnDict=True
    )
    model.watch(body["nodeNumber"])
    bodies = model.mbs.CreateGround(), body["bodyNumber"]
    markers = [model.mbs.AddMarker(MarkerBodyRigid(bodyNumber=number)) for number in bodies]
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), markers[1]]))
    joint = model.mbs.AddObject(
        GenericJoint(
            markerNumbers=markers,
            constrainedAxes=[0, 0, 0, 1, 1, 1],
            offsetUserFunctionParameters=[0.0] * 6,
            offsetUserFunction=lambda mbs, t, itemNumber, parameters: parameters,
        )
    )
    return lambda t: model.set_object(joint, offsetUserFunctionParameters=[0.0] * 5 + [t**2])


def mass_that_grows(model):
    node, body = model.mass_point([1.8, 0, 0])
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)]))
    return lambda t: model.set_object(body, mass=0.05 if t < 0.3 else 0.2)


def matrix_that_is_set(model):
    """The stiffness of an object that ties the tip to where it is."""
    tie = model.mbs.AddObject(
        ObjectGenericODE2(nodeNumbers=[model.nodes[-1]], stiffnessMatrix=np.diag([5.0, 5.0, 0.0, 0.0]))
    )

    def change(t):
        stiffness = 50.0 if t > 0.02 else 5.0
        model.set_object(tie, stiffnessMatrix=np.diag([stiffness, stiffness, 0.0, 0.0]))

    return change


def feedback_of_a_sensor(model):
    load, sensor = model.force(model.nodes[-1]), model.sensors[0]

    def change(t):
        x, y, _ = model.mbs.GetSensorValues(sensor)
        model.mbs.SetLoadParameter(load, "loadVector", [-2.0 * (x - 1.2), -1.0 * (y + 1.0), 0])

    return change


ALONE = [
    force_on_a_node,
    coordinate_load,
    load_that_walks,
    user_function_replaced,
    release,
    release_and_catch,
    moving_support,
    moving_support_and_force,
    support_that_steps,
    hanger,
    hanger_that_catches,
    winch,
    moving_end_of_a_hanger,
    moving_ground_of_a_hanger,
    moving_ground_node_of_a_hanger,
    feedback_of_a_sensor,
]
AMONG_OTHERS = [
    load_that_leaves_a_mass,
    spring_that_grabs,
    release_beside_a_mass,
    joint_released_and_caught,
    spring_and_force,
    driven_mass,
    mass_driven_at_a_speed,
    ground_that_turns,
    moving_ground_node_of_a_spring,
    mass_that_grows,
]
IN_SPACE = [  # the others are tried in the plane, as these are in other tests
    load_that_walks,
    release_and_catch,
    moving_support_and_force,
    hanger_that_catches,
    winch,
    moving_end_of_a_hanger,
    joint_released_and_caught,
    mass_driven_at_a_speed,
    ground_that_turns,
]
KINDS = [(kind, 3 if kind in IN_SPACE else 2) for kind in [*ALONE, *AMONG_OTHERS]]


SMALL_STEPS = {hanger_that_catches: STEP / 2}  # with longer ones the implicit solver ends there


def moved(kind, native, register="SetPreStepUserFunction", end_time=0.6, step=None, dim=2, **explicit):
    """The model after a run with that kind of changes."""
    model = Model(native, dim)
    change = kind(model)
    getattr(model.mbs, register)(lambda mbs, t: change(t) or True)
    report = model.run(end_time, step or SMALL_STEPS.get(kind, STEP), **explicit)
    return SimpleNamespace(model=model, motion=model.motion, report=report)


@cache
def native_motion(kind, dim):
    """Under the implicit solver; several tests compare with it."""
    return moved(kind, True, dim=dim).motion


def name_of(kind):
    return kind.__name__


@pytest.mark.parametrize(("kind", "dim"), KINDS, ids=lambda value: getattr(value, "__name__", str(value)))
def test_a_pre_step_function_changes_the_motion_as_under_the_implicit_solver(kind, dim):
    ours = moved(kind, False, dim=dim)
    assert deviation(ours.motion, native_motion(kind, dim)) < 0.01
    assert ours.report["drift"]["energyGain"] < 0.003


@pytest.mark.parametrize("dim", [2, 3])
def test_so_does_one_that_steers_a_joint(dim):
    ours, native = (
        moved(steered_joint, native, end_time=0.2, step=2e-3, dim=dim) for native in (False, True)
    )
    assert deviation(ours.motion, native.motion) < 0.01
    assert ours.report["drift"]["energyGain"] < 0.003


@pytest.mark.parametrize(
    "kind",
    [
        driven_mass,
        mass_driven_at_a_speed,
        ground_that_turns,
        moving_ground_node_of_a_spring,
        steered_joint,
    ],
    ids=name_of,
)
def test_runs_go_on_with_what_is_set_step_by_step(kind, monkeypatch):
    """Each step took 10 to 60 ms where they were built again."""
    build = Mock(side_effect=RunBuilder.build, autospec=True)
    monkeypatch.setattr(RunBuilder, "build", lambda *given, **named: build(*given, **named))
    moved(kind, False, end_time=0.01)
    assert build.call_count <= 2


@pytest.mark.parametrize(
    "kind",
    [moving_support, moving_support_and_force, moving_end_of_a_hanger, moving_ground_of_a_hanger],
    ids=name_of,
)
def test_a_cable_whose_supports_move_has_no_joints(kind):
    assert moved(kind, False, end_time=0.05).report["path"].startswith("cable 'object0': ")


def test_compiled_code_goes_on_with_a_spring_that_is_switched():
    report = moved(spring_that_grabs_beside_a_mass, False, end_time=0.3).report
    assert "right-hand side of Exudyn" not in report["path"]


@pytest.mark.parametrize("kind", [force_on_a_node, release, moving_support, hanger, driven_mass], ids=name_of)
def test_a_post_step_function_does_so_too(kind):
    ours, native = (moved(kind, is_native, "SetPostStepUserFunction", 0.4) for is_native in (False, True))
    assert deviation(ours.motion, native.motion) < 0.01


@pytest.mark.parametrize("kind", [None, Model.mass_point], ids=["alone", "among others"])
def test_what_is_set_before_the_first_step_is_there_from_the_beginning(kind):
    """A force that never acts leaves no trace, however large it was."""

    def motion(force):
        model = Model(native=False)
        if kind:
            kind(model, [3, 0, 0])
        load = model.force(model.nodes[-1], [0, force, 0])

        def change(mbs, t):
            mbs.SetLoadParameter(load, "loadVector", [0.3 * np.sin(5 * t), 0, 0])
            return True

        model.mbs.SetPreStepUserFunction(change)
        model.run(0.1, stepSize=STEP, massScaling=0.3)
        return model.motion

    assert np.array_equal(motion(10.0), motion(0.0))


def beside_a_function(kind, model):
    """Which Exudyn evaluates: cables and a mass are compiled parts of that scene."""
    _, mass = model.mass_point([0, 1, 0])
    markers = [model.at_point([0, 1, 0]), model.mbs.AddMarker(MarkerBodyPosition(bodyNumber=mass))]
    spring = CartesianSpringDamper(
        markerNumbers=markers,
        stiffness=[5.0, 5.0, 5.0],
        springForceUserFunction=that_remembers(lambda mbs, t, number, u, v, k, *_: [k[0] * x for x in u]),
    )
    model.mbs.AddObject(spring)
    return kind(model)


def weight_beside_a_function(model):
    return beside_a_function(weight, model)


@pytest.mark.parametrize("kind", [ground_that_turns, moving_ground_node_of_a_spring], ids=name_of)
def test_places_at_springs_change_in_the_same_way_where_exudyn_evaluates_them(kind):
    """They jumped in each step."""
    compiled = moved(kind, False, end_time=0.1, stepSize=STEP)
    evaluated = moved(partial(beside_a_function, kind), False, end_time=0.1, stepSize=STEP)
    without_the_mass = np.delete(evaluated.motion, 2, axis=1)
    np.testing.assert_allclose(without_the_mass, compiled.motion, rtol=0, atol=1e-9)
    assert "(bodies and joints are compiled)" in evaluated.report["path"]


@pytest.mark.parametrize("others", [weight_beside_a_mass, weight_beside_a_function], ids=name_of)
def test_a_weight_that_changes_acts_alone_and_among_others(others):
    alone, beside = moved(weight, False).motion, moved(others, False).motion[:, :2]
    without = moved(lambda model: lambda t: None, False).motion
    assert deviation(beside, alone) < 1e-3
    assert deviation(without, alone) > 0.05


@pytest.mark.parametrize("integrator", ["Zhai", "RK4"])
@pytest.mark.parametrize("kind", [force_on_a_node, release, moving_support, driven_mass], ids=name_of)
def test_every_scheme_follows_changes(kind, integrator):
    ours = moved(kind, False, integrator=integrator, stepSize=2.5e-4)
    assert deviation(ours.motion, native_motion(kind, 2)) < 0.01


@pytest.mark.parametrize("options", [{"adaptiveStep": True}, {"stepSize": 5e-4, "massScaling": 0.3}], ids=str)
@pytest.mark.parametrize("kind", [force_on_a_node, release, moving_support], ids=name_of)
def test_changes_act_with_steps_that_adapt_and_with_mass_scaling(kind, options):
    ours = moved(kind, False, **options)
    assert deviation(ours.motion, native_motion(kind, 2)) < 0.01
    assert ours.report["steps"] >= 600


@pytest.mark.parametrize("kind", [force_on_a_node, release, moving_support, hanger], ids=name_of)
def test_the_motion_is_that_of_a_stiff_native_cable(kind):
    ours = moved(kind, False, step=1e-3)
    native = Model(True, ancf=True)
    change = kind(native)
    native.mbs.SetPreStepUserFunction(lambda mbs, t: change(t) or True)
    native.run(0.6, 1e-3)
    assert deviation(ours.motion, native.motion) < 0.01


def begun_anew(kind, native):
    """Motion in the second of two runs of the same mbs: parameters stay, the state is the initial one."""
    run = moved(kind, native, end_time=0.4)
    settings = quiet_settings(0.4, round(0.4 / STEP))
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    first = run.motion
    run.model.mbs.SetPreStepUserFunction(lambda mbs, t: True)
    run.model.run_again(settings)
    return first, run.model.motion


@pytest.mark.parametrize("kind", [force_on_a_node, release], ids=name_of)
def test_a_second_run_starts_with_what_the_first_one_left(kind):
    (first, second), (_, native) = (begun_anew(kind, is_native) for is_native in (False, True))
    assert deviation(second, native) < 0.01
    assert deviation(first, native) > 0.05


def swinging(change=None, **explicit):
    """A pendulum whose pre-step function calls `change`; (model, report)."""
    model = Model(False)
    if change is not None:
        model.mbs.SetPreStepUserFunction(lambda mbs, t: change(model, t) or True)
    return model, model.run(0.3, 1e-3, **explicit)


def test_a_function_that_changes_nothing_changes_no_bit():
    def set_the_same(model, t):
        model.set_object(model.supports[0], offset=0.0, activeConnector=True)

    motions = [swinging(change)[0].motion for change in (None, lambda model, t: None, set_the_same)]
    np.testing.assert_array_equal(motions[1], motions[0])
    np.testing.assert_array_equal(motions[2], motions[0])


def test_what_is_changed_and_changed_back_within_a_step_changes_no_bit():
    def blink(model, t):
        for active in (False, True):
            model.set_object(model.supports[0], activeConnector=active)

    np.testing.assert_array_equal(swinging(blink)[0].motion, swinging()[0].motion)


def wound_up(is_careless):
    """A mass point on a spring that gets shorter, until mbs refuses its length, under a force that is set.

    is_careless: whether it is set all the same, and the vector of the force is used for something else.
    """
    model, vector = Model(False), [0.0, 0.0, 0.0]
    body = model.mass_point([2, -0.5, 0])[1]
    markers = [model.at_point([2, 0, 0]), model.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))]
    spring = model.mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=0.5, stiffness=20.0))
    load = model.force(model.nodes[-1])

    def wind(mbs, t):
        if is_careless or t < 0.0455:
            with suppress(exudyn.ExudynValueError):
                mbs.SetObjectParameter(spring, "referenceLength", 0.5 - 11 * t)
        vector[0] = np.sin(5 * t)
        mbs.SetLoadParameter(load, "loadVector", vector if is_careless else vector.copy())
        vector[0] = 1e3 if is_careless else vector[0]
        return True

    model.mbs.SetPreStepUserFunction(wind)
    model.run(0.1, 1e-3)
    return model.motion


def test_what_mbs_holds_acts_and_not_what_it_was_given():
    np.testing.assert_array_equal(wound_up(True), wound_up(False))


def test_a_matrix_of_a_generic_object_acts_at_once():
    ours, native = (moved(matrix_that_is_set, is_native, end_time=0.1) for is_native in (False, True))
    assert deviation(ours.motion, native.motion) < 0.01


def by_a_bound_load(model):
    load, setter = model.force(model.nodes[-1]), model.mbs.SetLoadParameter
    return lambda t: setter(load, "loadVector", [t, 0, 0])


def by_a_bound_support(model):
    setter = model.mbs.SetObjectParameter
    return lambda t: setter(model.supports[0], "activeConnector", t < 0.1)


def by_a_point_mass(model):
    return lambda t: AddPointMass(model.mbs, model.cable, 0.9, 0.01) if abs(t - 0.1) < 1e-9 else None


def by_a_bound_mass(model):
    """It has no weight, which would be another force."""
    body = model.mbs.CreateMassPoint(mass=0.05, referencePosition=TIP, returnDict=True)
    ties = [model.at(model.nodes[-1]), model.at(body["nodeNumber"])]
    model.mbs.AddObject(SphericalJoint(markerNumbers=ties))
    setter = model.mbs.SetObjectParameter
    return lambda t: setter(body["bodyNumber"], "mass", 0.05 if t < 0.1 else 0.2)


WITHOUT_NOTICE = [by_a_bound_load, by_a_bound_support, by_a_bound_mass, by_a_point_mass]


@pytest.mark.parametrize("kind", WITHOUT_NOTICE, ids=name_of)
def test_changes_without_notice_are_not_silent(kind):
    with pytest.raises(SceneError, match="changed during the run without its notice"):
        moved(kind, False, end_time=0.2, step=1e-3)


def test_the_methods_of_exudyn_are_as_before_after_a_run():
    before = dict(vars(exudyn.MainSystem))
    moved(force_on_a_node, False, end_time=0.1)
    with pytest.raises(SceneError):
        moved(lambda model: lambda t: model.mbs.CreateGround(), False, end_time=0.1)
    assert dict(vars(exudyn.MainSystem)) == before


def add_a_node(model):
    model.mbs.AddNode(NodePointGround())


def add_a_ground(model):
    model.mbs.CreateGround()


def move_a_reference(model):
    model.mbs.SetNodeParameter(model.nodes[-1], "referenceCoordinates", [2.0, 0, 1, 0])


def change_nodes(model):
    model.set_object(model.cable["elements"][0], nodeNumbers=model.nodes[:-1])


def change_markers(model):
    model.set_object(model.supports[0], markerNumbers=[0, 0])


def change_the_level(model):
    model.set_object(model.supports[0], velocityLevel=True)


def change_the_cable(model):
    model.set_object(model.cable["elements"][0], forceUserFunction=lambda mbs, t, n, q, v: [0] * 36)


BEYOND = [
    add_a_node,
    add_a_ground,
    move_a_reference,
    change_nodes,
    change_markers,
    change_the_level,
    change_the_cable,
]


@pytest.mark.parametrize("beside_a_mass", [False, True])
@pytest.mark.parametrize("change", BEYOND, ids=name_of)
def test_what_a_run_cannot_follow_is_refused_with_the_state_before(change, beside_a_mass, fault):
    model = Model(False)
    if beside_a_mass:
        model.mass_point([0, 1, 0])
    seen = []

    def step_user_function(mbs, t):
        seen.append(mbs.systemData.GetODE2Coordinates())
        if abs(t - 0.1) < 1e-9:
            change(model)
        return True

    model.mbs.SetPreStepUserFunction(step_user_function)
    with pytest.raises(
        SceneError, match=r"in the step to t = 0\.1 s, .*cannot follow: .*activeConnector|use loads"
    ):
        model.run(0.2, 1e-3)
    data = model.mbs.systemData
    assert data.GetTime() == pytest.approx(0.099)
    np.testing.assert_array_equal(data.GetODE2Coordinates(), seen[-1])
    model.mbs.SetPreStepUserFunction(lambda mbs, t: True)
    assert model.run_again(quiet_settings(0.2, 200))["success"]
    where = "among bodies" if beside_a_mass else "cables alone"
    tried = name_of(change).replace("_", " ")
    fault(f"a pre-step function tries to {tried} ({where})", "refused by name; mbs as before that step")


def test_a_parameter_that_does_not_exist_is_named_as_it_was_set():
    """The message was of a parameter that cannot be read, which the step function had not tried."""
    model = Model(False)

    def step_user_function(mbs, t):
        mbs.SetObjectParameter(model.supports[0], "ofset", 0.1)
        return True

    model.mbs.SetPreStepUserFunction(step_user_function)
    with pytest.raises(exudyn.ModelError, match=r"SetParameter.*ofset cannot be modified"):
        model.run(0.2, 1e-3)


@pytest.mark.parametrize("time", [0.1, 0.2])
def test_refusals_that_a_step_function_catches_end_the_run(time):
    model = Model(False)

    def step_user_function(mbs, t):
        if abs(t - time) < 1e-9:
            with suppress(Exception):
                change_nodes(model)
        return True

    model.mbs.SetPreStepUserFunction(step_user_function)
    with pytest.raises(SceneError, match=rf"in the step to t = {time} s, 'nodeNumbers' of object"):
        model.run(0.2, 1e-3)
    model.mbs.SetPreStepUserFunction(lambda mbs, t: True)
    assert model.run_again(quiet_settings(0.2, 200))["success"]


def test_a_change_while_steps_are_computed_ahead_is_refused():
    """By a sensor, say: nobody would look at it."""
    model = Model(False)
    load = model.force(model.nodes[-1])

    def push(mbs, t, sensors, factors, configuration):
        mbs.SetLoadParameter(load, "loadVector", [t, 0, 0])
        return [t]

    model.mbs.AddSensor(SensorUserFunction(sensorUserFunction=push, storeInternal=True))
    with pytest.raises(SceneError, match="register a pre-step user function"):
        model.run(0.2, 1e-3)


def stiffened():
    """A cable, whose end a spring holds that becomes stiff."""
    model = Model(False)
    node, _ = model.mass_point([1.8, -0.4, 0])
    markers = [model.at(model.nodes[-1]), model.at(node)]
    spring = model.mbs.AddObject(SpringDamper(markerNumbers=markers, referenceLength=0.4, stiffness=20))

    def stiffen(mbs, t):
        model.set_object(spring, stiffness=20 if t < 0.1 else 1e6)
        return True

    model.mbs.SetPreStepUserFunction(stiffen)
    return model, int(spring)


def test_a_change_that_makes_a_given_step_too_long_is_refused_with_its_cause():
    model, spring = stiffened()
    with pytest.raises(
        StepSizeError, match=rf"after the change of 'stiffness' of object {spring} at t = 0\.0"
    ):
        model.run(0.2, 1e-3, stepSize=1e-3)
    assert model.mbs.systemData.GetTime() == pytest.approx(0.099, abs=2e-3)


def test_a_change_that_makes_an_automatic_step_too_long_shortens_it():
    model, _ = stiffened()
    report = model.run(0.2, 1e-3)
    model, _ = stiffened()
    fine = model.run(0.2, 1e-3, stepSize=report["stepSize"] / 4)
    assert report["stepSize"] < 5e-4 and report["rejections"] == 0 == fine["rejections"]


def test_a_section_force_follows_a_changed_load_at_once():
    """A hanging cable at rest is pulled: its tension there grows by the force."""
    model = Model(False, shape=CableShape.Line([0, 0], [0, -1.8], 8))
    load = model.force(model.nodes[-1])
    sensor = CreateCableForceSensor(model.mbs, model.cable, 0.9)

    def pull(mbs, t):
        mbs.SetLoadParameter(load, "loadVector", [0, -5.0 * (t > 0.05), 0])
        return True

    model.mbs.SetPreStepUserFunction(pull)
    model.run(0.1, 1e-3)
    tension = np.asarray(model.mbs.GetSensorStoredData(sensor))[:, 1]
    weight = 0.9 * 0.0348 * 9.81
    np.testing.assert_allclose([tension[0], tension[-1]], [weight, weight + 5.0], rtol=1e-6)


def first_order_state(model):
    """A force follows y with y' = -2 y, which is set to 3 at 0.2 s."""
    node = model.mbs.AddNode(
        NodeGenericODE1(referenceCoordinates=[0.0], initialCoordinates=[1.0], numberOfODE1Coordinates=1)
    )
    model.mbs.AddObject(ObjectGenericODE1(nodeNumbers=[node], systemMatrix=[[-2.0]], rhsVector=[0.0]))
    state = model.mbs.systemData.GetODE1Coordinates
    model.force(model.nodes[-1], loadVectorUserFunction=lambda mbs, t, load: [0.5 * state()[0], 0, 0])

    def change(t):
        if abs(t - 0.2) < 1e-9:
            model.mbs.systemData.SetODE1Coordinates([3.0])

    return change


def data_coordinate(model):
    """A force is what a data coordinate says."""
    model.mbs.AddNode(NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1))
    value = model.mbs.systemData.GetDataCoordinates
    model.force(model.nodes[-1], loadVectorUserFunction=lambda mbs, t, load: [0, value()[0], 0])
    return lambda t: model.mbs.systemData.SetDataCoordinates([0.5 * (t > 0.1)])


def velocities(model):
    """Beside a first order state."""
    first_order_state(model)

    def change(t):
        if abs(t - 0.2) < 1e-9:
            rates = np.array(model.mbs.systemData.GetODE2Coordinates_t())
            model.mbs.systemData.SetODE2Coordinates_t(0.5 * rates)

    return change


@pytest.mark.parametrize("kind", [first_order_state, data_coordinate, velocities], ids=name_of)
def test_states_that_a_step_function_sets_act_too(kind):
    assert deviation(moved(kind, False).motion, native_motion(kind, 2)) < 0.01


STORED = [load_that_walks, release, moving_support, hanger, winch, moving_end_of_a_hanger, driven_mass]
STORED += [joint_released_and_caught, spring_and_force, mass_that_grows]
STORED += [spring_that_grabs, spring_that_grabs_beside_a_mass]


@pytest.mark.parametrize("kind", STORED, ids=name_of)
def test_a_run_that_is_continued_begins_with_what_had_been_changed(kind, tmp_path):
    """To round-off: Exudyn adds up the time that the functions are given. Automatic steps know the end."""

    def state(end_time, name):
        model = Model(False)
        change = kind(model)
        model.mbs.SetPreStepUserFunction(lambda mbs, t: change(t) or True)
        model.mbs.Assemble()
        settings = quiet_settings(end_time, round(end_time / 1e-3))
        restart = settings.solution.restart
        restart.write, restart.continueIfAvailable, restart.writePeriod = True, True, 0.1
        restart.name = str(tmp_path / name)
        resumed = model.run_again(settings, stepSize=2.5e-4, massScaling=0.3)["resumedAt"]
        data = model.mbs.systemData
        return resumed, np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t()])

    _, whole = state(0.45, "whole")
    state(0.4, "parts")
    resumed, continued = state(0.45, "parts")
    assert resumed == pytest.approx(0.4)
    np.testing.assert_allclose(continued, whole, atol=1e-8)


def test_a_run_whose_functions_were_replaced_is_not_continued(tmp_path):
    model = Model(False)
    change = user_function_replaced(model)
    model.mbs.SetPreStepUserFunction(lambda mbs, t: change(t) or True)
    model.mbs.Assemble()
    settings = quiet_settings(0.4, 400)
    restart = settings.solution.restart
    restart.write, restart.continueIfAvailable, restart.writePeriod = True, True, 0.1
    restart.name = str(tmp_path / "replaced")
    model.run_again(settings)
    settings.timeIntegration.endTime = 0.5
    with pytest.raises(InputError, match="'loadVectorUserFunction' of load 0 was replaced"):
        model.run_again(settings)
