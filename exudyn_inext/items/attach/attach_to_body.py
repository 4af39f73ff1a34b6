"""AttachToBody: hinge or clamp between an end of a cable and a body."""

from typing import Any

import numpy as np
from exudyn.itemInterface import MarkerBodyPosition, MarkerNodePosition, SphericalJoint

from ...arrays import Array
from ...checks import require_choice, require_vector
from ...errors import InputError
from ...scene.model import CableItem
from ..cable_data import require_cable
from ..cable_item import _add_ground_constraints
from .body_frame import BodyFrame, body_frame
from .clamp_to_body import add_clamp

POSITION_TOLERANCE = 1e-6  # distance of the joined points, relative to the length of the cable [-]
DIRECTION_TOLERANCE = 1e-6  # of unit length, and angle between slope and direction [-]
_ENDS = {"start": 0, "end": -1}
_KINDS = ("hinge", "clamp")


def AttachToBody(
    mbs: Any,
    cable: Any,
    end: str,
    bodyNumber: Any,
    localPosition: Any = (0, 0, 0),
    kind: str = "hinge",
    localDirection: Any = None,
) -> dict[str, list[int]]:
    """Attach an end of a cable to a rigid body, mass point, native beam, or to ground.

    A hinge joins the two points: a SphericalJoint, in the plane without its z axis. A clamp also keeps the
    slope along a direction that is fixed to the body: a CoordinateVectorConstraint with user functions, one
    equation in the plane, two in space. On ground, both are CoordinateConstraints of the node.

    Args:
        mbs: the system; call mbs.Assemble() afterwards.
        cable: what CreateInextensibleCable returned, or the number of its object; not a closed one.
        end: 'start' or 'end'.
        bodyNumber: object number of the body.
        localPosition: point of the body, in its frame [m]; where the end of the cable is initially.
        kind: 'hinge' or 'clamp'.
        localDirection: unit vector of the body's frame along the initial slope (towards growing arc
            length) of a clamped end; None: the one that fits.

    Returns:
        dict with 'markers' and 'constraintObjects'.

    Raises:
        InputError: an argument out of its limits, or end and body are apart; mbs is unchanged then.

    Example:
        AttachToBody(mbs, cable, 'end', drone, localPosition=[0, 0, -0.1])
        AttachToBody(mbs, rod, 'start', hub, [0.2, 0, 0], kind='clamp', localDirection=[1, 0, 0])
    """
    _, item = require_cable(mbs, cable)
    place = _place(item, end, kind)
    frame = body_frame(mbs, bodyNumber)
    local = require_vector("localPosition", localPosition)
    node = item.given_nodes[place]
    position, slope = _initial_end(mbs, item, node)
    _require_meeting(item, node, position, frame, frame.point(mbs, local))
    direction = _direction(frame, slope, kind, localDirection, node)
    dim = item.cable.dimension
    if frame.is_ground:
        held = np.zeros(item.cable.reference.shape, dtype=bool)
        held[place] = [[True] * dim, [kind == "clamp"] * dim]
        return {
            "markers": [],
            "constraintObjects": _add_ground_constraints(mbs, list(item.given_nodes), held),
        }
    markers = [
        int(mbs.AddMarker(MarkerBodyPosition(bodyNumber=frame.number, localPosition=local.tolist()))),
        int(mbs.AddMarker(MarkerNodePosition(nodeNumber=node))),
    ]
    axes = [1, 1, dim - 2]
    joint = int(mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=axes)))
    attached = {"markers": markers, "constraintObjects": [joint]}
    if direction is not None:
        for name, numbers in add_clamp(mbs, frame, node, direction, dim).items():
            attached[name] += numbers
    return attached


def _place(item: CableItem, end: str, kind: str) -> int:
    """Index of the node at that end."""
    require_choice("end", end, tuple(_ENDS))
    require_choice("kind", kind, _KINDS)
    if item.cable.closed:
        raise InputError(
            f"end = {end!r}: a closed cable has no ends; join one of its nodes to the body by a "
            "SphericalJoint of MarkerNodePosition and MarkerBodyPosition (in the plane with "
            "constrainedAxes=[1, 1, 0])."
        )
    return _ENDS[end]


def _initial_end(mbs: Any, item: CableItem, node: int) -> tuple[Array, Array]:
    """(3,) initial position and slope of a node."""
    data = mbs.GetNode(node)
    total = np.add(data["referenceCoordinates"], data["initialCoordinates"]).reshape(2, -1)
    padded = np.zeros((2, 3))
    padded[:, : item.cable.dimension] = total
    return padded[0], padded[1]


def _require_meeting(item: CableItem, node: int, position: Array, frame: BodyFrame, point: Array) -> None:
    limit = POSITION_TOLERANCE * item.cable.length
    dim = item.cable.dimension
    distance = float(np.linalg.norm((position - point)[:dim]))
    if not distance <= limit:
        raise InputError(
            f"node {node} of the cable at {position[:dim].tolist()} and the point of {frame.name} at "
            f"{point[:dim].tolist()} are {distance:.3g} m apart (limit {limit:.3g} m, {POSITION_TOLERANCE:g} "
            "of the cable's length): correct localPosition, or move the body or the cable."
        )


def _direction(frame: BodyFrame, slope: Array, kind: str, local_direction: Any, node: int) -> Array | None:
    """(3,) direction of a clamp in the body's frame, None for a hinge."""
    if kind == "hinge":
        if local_direction is not None:
            raise InputError(
                f"localDirection = {local_direction!r} is given, but a hinge has none: leave it out."
            )
        return None
    fitting: Array = frame.orientation().T @ (slope / np.linalg.norm(slope))
    if local_direction is None:
        return fitting
    direction = require_vector("localDirection", local_direction)
    norm = float(np.linalg.norm(direction))
    if not abs(norm - 1.0) <= DIRECTION_TOLERANCE:
        raise InputError(
            f"localDirection = {local_direction!r} has length {norm:.9g}: must be a unit vector "
            f"(within {DIRECTION_TOLERANCE:g})."
        )
    angle = float(np.arctan2(np.linalg.norm(np.cross(direction, fitting)), direction @ fitting))
    if not angle <= DIRECTION_TOLERANCE:
        raise InputError(
            f"localDirection = {local_direction!r} of {frame.name} is {angle:.3g} rad away from the initial "
            f"slope of node {node} (limit {DIRECTION_TOLERANCE:g} rad): use {np.round(fitting, 9).tolist()}, "
            "or turn the body or the cable."
        )
    return direction
