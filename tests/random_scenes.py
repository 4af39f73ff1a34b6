"""Random trees of cables, bodies, springs and loads; the same by one seed for both kinds of cables."""

from dataclasses import dataclass, field

import exudyn
import numpy as np
from exudyn.itemInterface import (
    CartesianSpringDamper,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodePosition,
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
    sensors: of positions at all ends and bodies.
    """

    seed: int
    native: bool = False
    elements: int = 8
    sensors: list = field(default_factory=list)

    def __post_init__(self):
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
        nodes, _ = either_cable(self.mbs, self.native, self.dimension, SECTION, AXIAL, **line)
        first, last = nodes[0], nodes[-1]
        if hangs:
            self._tie(marker, self.mbs.AddMarker(MarkerNodePosition(nodeNumber=first)))
        self.tips.append((end, self.mbs.AddMarker(MarkerNodePosition(nodeNumber=last))))
        self._sense(SensorNode, nodeNumber=last)

    def _sense(self, kind, **of):
        position = exudyn.OutputVariableType.Position
        self.sensors.append(self.mbs.AddSensor(kind(storeInternal=True, outputVariableType=position, **of)))

    def _mass_point(self, place, marker):
        mass = self.random.uniform(0.05, 0.5)
        body = self.mbs.CreateMassPoint(mass=mass, referencePosition=list(place), gravity=self.gravity)
        self._tie(marker, self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body)))

    def _body(self, place, marker):
        """Held at a point off its centre."""
        arm = self.vector(0.1)
        body = self.mbs.CreateRigidBody(
            inertia=InertiaCuboid(500, [0.12, 0.1, 0.08]),
            referencePosition=list(place - arm),
            gravity=self.gravity,
            create2D=self.dimension == 2,
        )
        self._tie(marker, self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=list(arm))))
        self._sense(SensorBody, bodyNumber=body)

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
