"""Random scenes: ropes that are released in any direction, alone, and with bodies, springs and contact.

A scene follows from its seed. All are 1 m long and have 0.1 kg/m.
"""

from dataclasses import dataclass
from typing import Any

import exudyn
import exudyn.utilities as items
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine

from exudyn_inext import (
    AddPointMass,
    AttachToBody,
    CreateCompanionCables,
    CreateInextensibleCable,
    InextensibleCable,
)
from reference_models.trajectory import Array

LENGTH, DENSITY, GRAVITY = 1.0, 0.1, [0.0, -9.81, 0.0]  # [m], [kg/m], [m/s^2]
STRETCH = 1e4  # axial stiffness of native cables [N]: strains of 2e-3 under the largest weights at rest
LONE, MASS, BODY, SPRING, CONTACT = "lone", "mass point", "rigid body", "springs", "contact"
MIXED = (MASS, BODY, SPRING, CONTACT)


@dataclass(frozen=True)
class Rope:
    """A random rope.

    stiffness: EI [N m^2].   tip_mass: [kg].   direction: (dim,) unit vector in which it lies at the start.
    clamped: whether its slope is held, too.   partner: what else is in the scene.
    """

    seed: int
    elements: int
    stiffness: float
    tip_mass: float
    direction: tuple[float, ...]
    clamped: bool
    partner: str = LONE

    @property
    def dimension(self) -> int:
        return len(self.direction)

    @property
    def end(self) -> list[float]:
        """Its free end at the start (3,) [m]."""
        return [LENGTH * x for x in (*self.direction, 0.0)[:3]]


def lone_rope(seed: int) -> Rope:
    """A rope with or without a point mass at its end."""
    random = np.random.default_rng(seed)
    stiffness = float(10.0 ** random.uniform(-5.0, 0.0))
    elements = int(random.integers(4, 25))
    tip_mass = float(random.choice([0.0, 0.3, 2.0]))
    dimension = int(random.choice([2, 3]))
    clamped = bool(random.integers(0, 2))
    direction = random.normal(size=dimension)
    unit = tuple((direction / np.linalg.norm(direction)).tolist())
    return Rope(seed, elements, stiffness, tip_mass, unit, clamped)


def mixed_rope(seed: int) -> Rope:
    """A rope with something else; contact is planar, and below."""
    rope = lone_rope(seed)
    partner = MIXED[seed % len(MIXED)]
    direction = rope.direction
    if partner == CONTACT:
        x, y = direction[:2]
        direction = (x / np.hypot(x, y), abs(y) / np.hypot(x, y))
    return Rope(seed, rope.elements, rope.stiffness, 0.0, direction, rope.clamped, partner)


def build(rope: Rope) -> tuple[Any, Any, int]:
    """Container, assembled mbs, sensor of the free end's position."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    template = InextensibleCable(massPerLength=DENSITY, bendingStiffness=rope.stiffness)
    cable = CreateInextensibleCable(mbs, **_placed(rope), beamTemplate=template, dimension=rope.dimension)
    if rope.tip_mass:
        AddPointMass(mbs, cable, LENGTH, rope.tip_mass)
    if rope.partner in _PARTNERS:
        random = np.random.default_rng(rope.seed + 1_000_000)
        mass = float(random.choice([0.1, 0.3, 1.0]))
        _PARTNERS[rope.partner](mbs, rope, cable, mass, random)
    return container, mbs, _assembled(mbs, cable)


def build_native(rope: Rope) -> tuple[Any, Any, int]:
    """A lone rope as native cable; the same as `build` gives."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    kind = items.ObjectANCFCable2D if rope.dimension == 2 else items.ObjectANCFCable
    section = {"massPerLength": DENSITY, "bendingStiffness": rope.stiffness, "axialStiffness": STRETCH}
    template = kind(**section, useReducedOrderIntegration=2)
    cable = GenerateBeamElementsAlongLine(mbs, **_placed(rope), beamTemplate=template)
    if rope.tip_mass:
        point = mbs.CreateMassPoint(mass=rope.tip_mass, referencePosition=rope.end, gravity=GRAVITY)
        end = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        markers = [end, mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=point))]
        axes = [1, 1, int(rope.dimension == 3)]
        mbs.AddObject(items.SphericalJoint(markerNumbers=markers, constrainedAxes=axes))
    return container, mbs, _assembled(mbs, cable)


def _placed(rope: Rope) -> dict[str, Any]:
    """What both kinds of cables are told."""
    held = [True] * rope.dimension + [rope.clamped] * rope.dimension
    return {
        "positionStart": [0.0, 0.0, 0.0],
        "positionEnd": rope.end,
        "numberOfElements": rope.elements,
        "gravity": GRAVITY,
        "groundConstraintsStart": held,
    }


def _assembled(mbs: Any, cable: Any) -> int:
    """The sensor of the free end."""
    position, node = exudyn.OutputVariableType.Position, cable["nodes"][-1]
    sensor = mbs.AddSensor(items.SensorNode(nodeNumber=node, outputVariableType=position, storeInternal=True))
    mbs.Assemble()
    return int(sensor)


def _add_point(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """A mass point, held in the plane of a planar rope."""
    point = mbs.CreateMassPoint(mass=mass, referencePosition=rope.end, gravity=GRAVITY)
    AttachToBody(mbs, cable, "end", point)
    if rope.dimension == 2:
        ends = ((mbs.AddNode(items.NodePointGround()), 0), (mbs.GetObject(point)["nodeNumber"], 2))
        markers = [
            mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))
            for node, number in ends
        ]
        mbs.AddObject(items.CoordinateConstraint(markerNumbers=markers))


def _add_body(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """A cube."""
    x, y, z = rope.end
    if rope.dimension == 3:
        cuboid = items.InertiaCuboid(density=mass / 1e-3, sideLengths=[0.1, 0.1, 0.1])
        centre = [x, y, z + 0.05]
        body = mbs.CreateRigidBody(referencePosition=centre, inertia=cuboid, gravity=GRAVITY)
        AttachToBody(mbs, cable, "end", body, [0.0, 0.0, -0.05])
        return
    node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[x, y - 0.05, 0.0]))
    body = mbs.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=mass * 0.1**2 / 6.0, nodeNumber=node))
    marker = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
    mbs.AddLoad(items.Force(markerNumber=marker, loadVector=[0.0, mass * GRAVITY[1], 0.0]))
    AttachToBody(mbs, cable, "end", body, [0.0, 0.05, 0.0])


def _add_springs(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """Two springs to ground, one of them with a dashpot."""
    ground = mbs.CreateGround()
    stiffness = float(10.0 ** random.uniform(0.0, 3.0))
    nodes = cable["nodes"]
    for node, damping in ((nodes[len(nodes) // 2], 0.0), (nodes[-1], 0.01 * stiffness)):
        coordinates = mbs.GetNode(node)["referenceCoordinates"]
        anchor = [*coordinates[: len(coordinates) // 2], 0.0][:3]
        markers = [
            mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=anchor)),
            mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node)),
        ]
        law = {"stiffness": [stiffness] * 3, "damping": [damping] * 3}
        mbs.AddObject(items.CartesianSpringDamper(markerNumbers=markers, **law))


SEGMENTS = 3


def _add_circle(mbs: Any, rope: Rope, cable: Any, mass: float, random: Any) -> None:
    """A circle that the rope falls onto."""
    radius, side = 0.15, 1.0 if rope.direction[0] >= 0.0 else -1.0
    circle = mbs.CreateGround(referencePosition=[0.5 * side, -0.25, 0.0])
    centre = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=circle))
    stiffness = float(10.0 ** random.uniform(2.0, 4.0))
    memory = [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS
    for element in CreateCompanionCables(mbs, cable):
        shape = mbs.AddMarker(items.MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=SEGMENTS))
        data = items.NodeGenericData(initialCoordinates=memory, numberOfDataCoordinates=len(memory))
        mbs.AddObject(
            items.ObjectContactFrictionCircleCable2D(
                markerNumbers=[centre, shape],
                nodeNumber=mbs.AddNode(data),
                numberOfContactSegments=SEGMENTS,
                circleRadius=radius,
                contactStiffness=stiffness,
                contactDamping=1e-3 * stiffness,
                frictionCoefficient=float(random.choice([0.0, 0.3])),
                frictionStiffness=0.1 * stiffness,
                frictionVelocityPenalty=1e-3 * stiffness,
                useSegmentNormals=False,
            )
        )


_PARTNERS = {MASS: _add_point, BODY: _add_body, SPRING: _add_springs, CONTACT: _add_circle}


def moved(path: Array) -> float:
    """Largest distance of a path (T, 3) from its start [m]."""
    return float(np.linalg.norm(path - path[0], axis=1).max())
