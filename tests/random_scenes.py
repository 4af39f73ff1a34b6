"""Random trees of cables, bodies, springs, joints, loads; by one seed the same for both kinds of cables."""

from dataclasses import dataclass, field

import exudyn
import numpy as np
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    DistanceConstraint,
    LoadForceVector,
    LoadTorqueVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    RigidBodySpringDamper,
    SensorBody,
    SensorNode,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid

from tests.exudyn_binding.items import either_cable

PERIOD = 0.02  # of sensors [s]
SECTION = {"massPerLength": 0.3, "bendingStiffness": 0.02}
AXIAL = 2e5  # of native cables [N]


@dataclass
class RandomScene:
    """One to four cables that hang from the ground or from each other, with what hangs on them.

    seed: of all choices.   native: whether the cables are.   elements: of each.
    stretches: whether they do; native ones always do.
    sensors: of positions at all ends and bodies.
    """

    seed: int
    native: bool = False
    elements: int = 8
    stretches: bool = False
    sensors: list = field(default_factory=list)

    def __post_init__(self):
        self.is_driven = False
        self.random = np.random.default_rng(self.seed)
        self.dimension = 2 + self.seed % 2
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.CreateGround()
        self.gravity = [0, -9.81, 0] if self.dimension == 2 else [0, 0, -9.81]
        self.tips = []  # (place, marker)
        for _ in range(self.random.integers(1, 5)):
            self._cable()
        for _ in range(self.random.integers(1, 4)):
            add = (self._mass_point, self._body, self._spring, self._load)[self.random.integers(4)]
            add(*self.tips[self.random.integers(len(self.tips))])
        if self.random.integers(2):
            self._changing_load(*self.tips[-1])
        self.mbs.Assemble()

    def vector(self, size):
        values = self.random.uniform(-size, size, 3)
        values[self.dimension :] = 0.0
        return values

    def _tie(self, *markers):
        axes = [1] * self.dimension + [0] * (3 - self.dimension)
        self.mbs.AddObject(SphericalJoint(markerNumbers=list(markers), constrainedAxes=axes))

    def _cable(self):
        """From a point of the ground, or from the tip of another one."""
        hangs = bool(self.tips) and self.random.uniform() < 0.6
        start, marker = self.tips[self.random.integers(len(self.tips))] if hangs else (self.vector(0.5), None)
        way = self.vector(1.0)
        end = start + self.random.uniform(0.5, 1.0) * way / np.linalg.norm(way)
        line = {"positionStart": list(start), "positionEnd": list(end), "numberOfElements": self.elements}
        line["gravity"] = self.gravity
        if not hangs:
            line["groundConstraintsStart"] = [True] * self.dimension + [False] * self.dimension
        section = SECTION | ({"axialStiffness": AXIAL} if self.stretches else {})
        nodes, _ = either_cable(self.mbs, self.native, self.dimension, section, AXIAL, **line)
        first, last = nodes[0], nodes[-1]
        if hangs:
            self._tie(marker, self.mbs.AddMarker(MarkerNodePosition(nodeNumber=first)))
        self.tips.append((end, self.mbs.AddMarker(MarkerNodePosition(nodeNumber=last))))
        self._sense(SensorNode, nodeNumber=last)

    def _sense(self, kind, **of):
        position = exudyn.OutputVariableType.Position
        self.sensors.append(self.mbs.AddSensor(kind(storeInternal=True, outputVariableType=position, **of)))

    def _mass_point(self, place, marker):
        """Tied to the place, tied and driven, or on a rod."""
        kind = self.random.integers(4)
        rod = self.vector(0.3) if kind == 1 else np.zeros(3)
        mass = {"mass": self.random.uniform(0.05, 0.5), "gravity": self.gravity}
        planar = {"create2D": self.dimension == 2, "returnDict": True}
        body = self.mbs.CreateMassPoint(referencePosition=list(place + rod), **mass, **planar)
        pair = [marker, self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body["bodyNumber"]))]
        self._sense(SensorNode, nodeNumber=body["nodeNumber"])
        if kind == 1:
            length = float(np.linalg.norm(rod))
            self.mbs.AddObject(DistanceConstraint(markerNumbers=pair, distance=length))
            return
        self._tie(*pair)
        if kind > 1 and not self.is_driven:  # straight cables between two drives would be redundant
            self.is_driven = True
            self._drive(body["nodeNumber"], at_velocity_level=kind == 2)

    def _drive(self, node, at_velocity_level):
        """The height follows a function of time."""
        size, rate = self.random.uniform(-0.4, 0.4), self.random.uniform(3, 9)

        def speed(mbs, t, number, offset):
            return size * np.sin(rate * t)

        def way(mbs, t, number, offset):
            return size / rate * (1.0 - np.cos(rate * t))

        places = (self.mbs.AddNode(NodePointGround()), 0), (node, self.dimension - 1)
        pair = [self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=c)) for n, c in places]
        given = {"velocityLevel": True} if at_velocity_level else {"offsetUserFunction": way}
        self.mbs.AddObject(CoordinateConstraint(markerNumbers=pair, offsetUserFunction_t=speed, **given))

    def _body(self, place, marker):
        """Held at a point off its centre, and up to two others that are joined to it."""
        arm = self.vector(0.1)
        body = self._box(place - arm)
        self._tie(marker, self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=list(arm))))
        for _ in range(self.random.integers(0, 3)):
            other_arm = self.vector(0.15)
            other = self._box(place - arm + 2 * other_arm)
            self._joint([body, other], place - arm + other_arm)
            (self._torsion if self.random.integers(2) else self._torque)(body, other)

    def _box(self, place):
        inertia, planar = InertiaCuboid(500, [0.12, 0.1, 0.08]), self.dimension == 2
        body = self.mbs.CreateRigidBody(
            inertia=inertia, referencePosition=list(place), gravity=self.gravity, create2D=planar
        )
        self._sense(SensorBody, bodyNumber=body)
        return body

    def _joint(self, bodies, place):
        """A hinge, a ball, or a joint that locks one turn."""
        kind, where = self.random.integers(3), {"itemNumbers": bodies, "position": list(place)}
        if self.dimension == 2:
            self.mbs.CreateGenericJoint(**where, constrainedAxes=[1, 1, 0, 0, 0, 0])
        elif kind == 0:
            self.mbs.CreateRevoluteJoint(**where, axis=list(self.vector(1.0)))
        else:
            self.mbs.CreateGenericJoint(**where, constrainedAxes=[1, 1, 1, 0, int(kind == 1), 0])

    def _torsion(self, *bodies):
        markers = [self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body)) for body in bodies]
        turns = np.diag([0, 0, 0, self.dimension - 2, self.dimension - 2, 1])
        law = {"stiffness": self.random.uniform(0.05, 0.5) * turns, "damping": 0.005 * turns}
        self.mbs.AddObject(RigidBodySpringDamper(markerNumbers=markers, **law))

    def _torque(self, _, body):
        size, rate = self.random.uniform(0.01, 0.1), self.random.uniform(2, 10)

        def swinging(mbs, t, load):
            return [0, 0, size * np.sin(rate * t)]

        marker = self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))
        self.mbs.AddLoad(
            LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=swinging)
        )

    def _spring(self, place, marker):
        anchor = MarkerBodyPosition(bodyNumber=self.ground, localPosition=list(place + self.vector(0.3)))
        stiffness, damping = self.random.uniform(5, 50), self.random.uniform(0, 0.5)
        used = [1.0] * self.dimension + [0.0] * (3 - self.dimension)
        self.mbs.AddObject(
            CartesianSpringDamper(
                markerNumbers=[self.mbs.AddMarker(anchor), marker],
                stiffness=[stiffness * x for x in used],
                damping=[damping * x for x in used],
            )
        )

    def _load(self, place, marker):
        """A force that follows a function of time."""
        force, rate = self.vector(1.5), self.random.uniform(2, 10)

        def swinging(mbs, t, load):
            return (force * np.sin(rate * t)).tolist()

        self.mbs.AddLoad(
            LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=swinging)
        )

    def _changing_load(self, place, marker):
        """A force that a function changes before each step."""
        force, rate = self.vector(1.0), self.random.uniform(2, 6)
        number = self.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0]))

        def change(mbs, t):
            mbs.SetLoadParameter(number, "loadVector", (force * np.sin(rate * t)).tolist())
            return True

        self.mbs.SetPreStepUserFunction(change)

    def paths(self):
        """(T, sensors, 3) [m]."""
        return np.stack([np.array(self.mbs.GetSensorStoredData(k))[:, 1:4] for k in self.sensors], axis=1)
