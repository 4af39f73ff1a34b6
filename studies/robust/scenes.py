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
    cable = CreateInextensibleCable(
        mbs,
        [0.0, 0.0, 0.0],
        rope.end,
        rope.elements,
        InextensibleCable(massPerLength=DENSITY, bendingStiffness=rope.stiffness),
        gravity=GRAVITY,
        dimension=rope.dimension,
        groundConstraintsStart=_held(rope),
    )
    if rope.tip_mass:
        AddPointMass(mbs, cable, LENGTH, rope.tip_mass)
    _add_partner(mbs, rope, cable)
    sensor = _sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    return container, mbs, sensor


def build_native(rope: Rope) -> tuple[Any, Any, int]:
    """A lone rope as native cable; the same as `build` gives."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    kind = items.ObjectANCFCable2D if rope.dimension == 2 else items.ObjectANCFCable
    section = {"massPerLength": DENSITY, "bendingStiffness": rope.stiffness, "axialStiffness": STRETCH}
    cable = GenerateBeamElementsAlongLine(
        mbs,
        [0.0, 0.0, 0.0],
        rope.end,
        rope.elements,
        beamTemplate=kind(**section, useReducedOrderIntegration=2),
        gravity=GRAVITY,
        groundConstraintsStart=_held(rope),
    )
    if rope.tip_mass:
        point = mbs.CreateMassPoint(mass=rope.tip_mass, referencePosition=rope.end, gravity=GRAVITY)
        end = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        _join(mbs, rope, end, mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=point)))
    sensor = _sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    return container, mbs, sensor


def _held(rope: Rope) -> list[bool]:
    return [True] * rope.dimension + [rope.clamped] * rope.dimension


def _sensor(mbs: Any, node: Any) -> int:
    position = exudyn.OutputVariableType.Position
    return int(
        mbs.AddSensor(items.SensorNode(nodeNumber=node, outputVariableType=position, storeInternal=True))
    )


def _join(mbs: Any, rope: Rope, first: int, second: int) -> None:
    axes = [1, 1, int(rope.dimension == 3)]
    mbs.AddObject(items.SphericalJoint(markerNumbers=[first, second], constrainedAxes=axes))


def _add_partner(mbs: Any, rope: Rope, cable: Any) -> None:
    random = np.random.default_rng(rope.seed + 1_000_000)
    mass = float(random.choice([0.1, 0.3, 1.0]))
    if rope.partner == MASS:
        point = mbs.CreateMassPoint(mass=mass, referencePosition=rope.end, gravity=GRAVITY)
        AttachToBody(mbs, cable, "end", point)
        _hold_in_plane(mbs, rope, point)
    elif rope.partner == BODY and rope.dimension == 3:
        cuboid = items.InertiaCuboid(density=mass / 1e-3, sideLengths=[0.1, 0.1, 0.1])
        x, y, z = rope.end
        centre = [x, y, z + 0.05]
        body = mbs.CreateRigidBody(referencePosition=centre, inertia=cuboid, gravity=GRAVITY)
        AttachToBody(mbs, cable, "end", body, [0.0, 0.0, -0.05])
    elif rope.partner == BODY:
        _add_planar_body(mbs, rope, cable, mass)
    elif rope.partner == SPRING:
        _add_springs(mbs, cable, random)
    elif rope.partner == CONTACT:
        _add_circle(mbs, rope, cable, random)


def _hold_in_plane(mbs: Any, rope: Rope, point: Any) -> None:
    if rope.dimension == 2:
        node = mbs.GetObject(point)["nodeNumber"]
        ground = mbs.AddMarker(
            items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
        )
        out_of_plane = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))
        mbs.AddObject(items.CoordinateConstraint(markerNumbers=[ground, out_of_plane]))


def _add_planar_body(mbs: Any, rope: Rope, cable: Any, mass: float) -> None:
    x, y = rope.end[:2]
    node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[x, y - 0.05, 0.0]))
    body = mbs.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=mass * 0.1**2 / 6.0, nodeNumber=node))
    centre = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
    mbs.AddLoad(items.Force(markerNumber=centre, loadVector=[0.0, mass * GRAVITY[1], 0.0]))
    AttachToBody(mbs, cable, "end", body, [0.0, 0.05, 0.0])


def _add_springs(mbs: Any, cable: Any, random: Any) -> None:
    """Two springs to ground, one of them with a dashpot."""
    ground = mbs.CreateGround()
    stiffness = float(10.0 ** random.uniform(0.0, 3.0))
    nodes = cable["nodes"]
    for node, damping in ((nodes[len(nodes) // 2], 0.0), (nodes[-1], 0.01 * stiffness)):
        coordinates = mbs.GetNode(node)["referenceCoordinates"]
        anchor = [*coordinates[: len(coordinates) // 2], 0.0][:3]
        mbs.AddObject(
            items.CartesianSpringDamper(
                markerNumbers=[
                    mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=anchor)),
                    mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node)),
                ],
                stiffness=[stiffness] * 3,
                damping=[damping] * 3,
            )
        )


SEGMENTS = 3


def _add_circle(mbs: Any, rope: Rope, cable: Any, random: Any) -> None:
    """A circle that the rope falls onto."""
    radius, side = 0.15, 1.0 if rope.direction[0] >= 0.0 else -1.0
    circle = mbs.CreateGround(referencePosition=[0.5 * side, -0.25, 0.0])
    centre = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=circle))
    stiffness = float(10.0 ** random.uniform(2.0, 4.0))
    for element in CreateCompanionCables(mbs, cable):
        shape = mbs.AddMarker(items.MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=SEGMENTS))
        memory = [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS
        data = mbs.AddNode(
            items.NodeGenericData(initialCoordinates=memory, numberOfDataCoordinates=len(memory))
        )
        mbs.AddObject(
            items.ObjectContactFrictionCircleCable2D(
                markerNumbers=[centre, shape],
                nodeNumber=data,
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


def moved(path: Array) -> float:
    """Largest distance of a path (T, 3) from its start [m]."""
    return float(np.linalg.norm(path - path[0], axis=1).max())
