"""What pre- and post-step functions change acts from that step on, as with Exudyn's implicit solver."""

from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    DistanceConstraint,
    LoadCoordinate,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SensorNode,
    SphericalJoint,
    SpringDamper,
)

from exudyn_inext import CreateInextensibleCable, ExplicitSettings, InextensibleCable, SolveExplicit
from reference_models.model import quiet_settings, silence

TEMPLATE = InextensibleCable(massPerLength=0.0348, bendingStiffness=0.0866)
PINNED = [True, True, False, False]
STEP = 1e-3
TIP = [1.8, 0, 0]


class Model:
    """A cable of 1.8 m, for SolveExplicit or, with its own constraints as native ones, for SolveDynamic."""

    def __init__(self, native, dim=2, **changes):
        self.container = exudyn.SystemContainer()
        self.mbs = mbs = self.container.AddSystem()
        self.native = native
        pin = {"groundConstraintsStart": [True] * dim + [False] * dim}
        line = {"positionStart": [0, 0, 0], "positionEnd": TIP, "numberOfElements": 8}
        self.cable = CreateInextensibleCable(
            mbs,
            beamTemplate=TEMPLATE,
            gravity=[0, -9.81, 0],
            dimension=dim,
            enforcement="algebraic" if native else "projection",
            **(line | pin | changes),
        )
        self.nodes = self.cable["nodes"]
        self.supports = self.cable["constraintObjects"][: 2 if dim == 2 else 3]
        self.ground = mbs.AddMarker(
            MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0)
        )
        self.sensors = []
        self.watch(self.nodes[-1])
        self.watch(self.nodes[4])

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


def driven_mass(model):
    """The coordinate of a mass, which a joint ties to the cable, is set step by step."""
    node, _ = model.mass_point([1.8, 0, 0])
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)]))
    drive = model.hold(node, 1)
    return lambda t: model.set_object(drive, offset=float(-0.8 * t**2))


def mass_that_grows(model):
    node, body = model.mass_point([1.8, 0, 0])
    model.mbs.AddObject(SphericalJoint(markerNumbers=[model.at(model.nodes[-1]), model.at(node)]))
    return lambda t: model.set_object(body, mass=0.05 if t < 0.3 else 0.2)


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
    support_that_steps,
    hanger,
    hanger_that_catches,
    winch,
    moving_end_of_a_hanger,
    feedback_of_a_sensor,
]
AMONG_OTHERS = [
    release_beside_a_mass,
    joint_released_and_caught,
    spring_and_force,
    driven_mass,
    mass_that_grows,
]
KINDS = [*ALONE, *AMONG_OTHERS]


def moved(kind, native, register="SetPreStepUserFunction", end_time=0.6, step=STEP, dim=2, **explicit):
    """The model after a run with that kind of changes."""
    model = Model(native, dim)
    change = kind(model)

    def step_user_function(mbs, t):
        change(t)
        return True

    getattr(model.mbs, register)(step_user_function)
    report = model.run(end_time, step, **explicit)
    return SimpleNamespace(model=model, motion=model.motion, report=report)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_pre_step_function_changes_the_motion_as_under_the_implicit_solver(kind, dim):
    ours, native = moved(kind, False, dim=dim), moved(kind, True, dim=dim)
    print("DEV", kind.__name__, dim, deviation(ours.motion, native.motion), ours.report["drift"])
    assert deviation(ours.motion, native.motion) < 0.01
