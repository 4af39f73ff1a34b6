"""Cables among springs, mass points, rigid bodies and each other: scenes of any size, to be timed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import exudyn
import exudyn.utilities as items

from exudyn_inext import CreateInextensibleCable, InextensibleCable
from reference_models.scenes import load_scene

CABLE = load_scene("planar_pendulum").cable
GRAVITY = [0.0, -9.81, 0.0]
SIZE = 0.05  # of a body [m]


@dataclass(frozen=True)
class Contents:
    """Of a scene: hanging cables of so many elements each, and what is joined to them.

    springs: from nodes of the first cable to ground.   points: mass points on its nodes.
    bodies: rigid bodies on its nodes.   links: joints between neighbouring cables.
    watched: whether a user function looks at each step.   enforcement: of the cables' length.
    damping: of bending [N m^2 s].   dimension: of space.   pinned: whether the cables are, at their starts.
    length: of each [m].
    also: adds what else there is; mbs, what CreateInextensibleCable returned, dimension -> None.
    """

    cables: int = 1
    elements: int = 10
    springs: int = 0
    points: int = 0
    bodies: int = 0
    links: int = 0
    watched: bool = False
    enforcement: str = "projection"
    damping: float = 0.0
    dimension: int = 2
    pinned: bool = True
    length: float = CABLE.length
    also: Callable[[Any, dict[str, Any], int], None] | None = None

    @property
    def joints(self) -> int:
        return self.points + self.bodies + self.links


def joined_scene(contents: Contents) -> Any:
    """The assembled mbs; its cables start straight along x and fall."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    cables = [_cable(mbs, contents, 0.1 * row) for row in range(contents.cables)]
    nodes = cables[0]["nodes"]
    for add, number in ((_spring, contents.springs), (_point, contents.points), (_body, contents.bodies)):
        for node in nodes[: -1 - number : -1]:
            add(mbs, node)
    for k in range(contents.links):
        above, below = cables[k]["nodes"][-1], cables[k + 1]["nodes"][-1]
        mbs.CreateDistanceConstraint(itemNumbers=[above, below], distance=0.1)
    if contents.also:
        contents.also(mbs, cables[0], contents.dimension)
    if contents.watched:
        mbs.SetPreStepUserFunction(lambda mbs, t: True)
    mbs.Assemble()
    mbs.variables["container"] = container
    return mbs


def _cable(mbs: Any, contents: Contents, height: float) -> dict[str, Any]:
    section, dim = CABLE.section, contents.dimension
    return CreateInextensibleCable(
        mbs,
        [0.0, height, 0.0],
        [contents.length, height, 0.0],
        contents.elements,
        InextensibleCable(
            section.mass_per_length, section.bending_stiffness, bendingDamping=contents.damping
        ),
        gravity=GRAVITY,
        groundConstraintsStart=[True] * dim + [False] * dim if contents.pinned else None,
        dimension=dim,
        enforcement=contents.enforcement,
    )


def _spring(mbs: Any, node: Any) -> None:
    mbs.CreateCartesianSpringDamper(itemNumbers=[mbs.CreateGround(), node], stiffness=[1.0, 1.0, 0.0])


def _tie(mbs: Any, node: Any, marker: Any) -> None:
    tip = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
    mbs.AddObject(items.SphericalJoint(markerNumbers=[tip, marker], constrainedAxes=[1, 1, 0]))


def _point(mbs: Any, node: Any) -> None:
    x, y = mbs.GetNode(node)["referenceCoordinates"][:2]
    point = mbs.CreateMassPoint(mass=0.01, referencePosition=[x, y, 0.0], gravity=GRAVITY)
    _tie(mbs, node, mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=point)))


def _body(mbs: Any, node: Any) -> None:
    x, y = mbs.GetNode(node)["referenceCoordinates"][:2]
    inertia, position = items.InertiaCuboid(80.0, [SIZE] * 3), [x, y - SIZE, 0.0]
    body = mbs.CreateRigidBody(inertia=inertia, referencePosition=position, gravity=GRAVITY)
    _tie(mbs, node, mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[0.0, SIZE, 0.0])))
