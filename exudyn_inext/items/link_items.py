"""Native constraints of an mbs that become links of a cable: distances and moving coordinates."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.link import Motion, rest
from ..constraints.motion import motion_of
from ..scene.links import MovingCoordinate, Rod

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}
_BODY_MARKERS = {"BodyPosition", "BodyRigid"}


def read_rod(mbs: Any, data: dict[str, Any]) -> Rod | None:
    """An active distance constraint between nodes, or a node and ground; None if it is not one."""
    if data["objectType"] != "ConnectorDistance" or not data["activeConnector"]:
        return None
    nodes: list[int] = []
    points: list[Array] = []
    for number in data["markerNumbers"]:
        marker = mbs.GetMarker(number)
        point = _fixed_point(mbs, marker)
        if point is not None:
            points.append(point)
        elif marker["markerType"] in _POSITION_MARKERS:
            nodes.append(int(marker["nodeNumber"]))
        else:
            return None
    if not nodes:
        return None
    return Rod(tuple(nodes), points[0] if points else None, float(data["distance"]), f"'{data['name']}'")


def _fixed_point(mbs: Any, marker: dict[str, Any]) -> Array | None:
    """(3,) position of a marker on ground, or None."""
    if marker["markerType"] in _POSITION_MARKERS:
        node = mbs.GetNode(marker["nodeNumber"])
        return np.array(node["referenceCoordinates"]) if node["nodeType"] == "PointGround" else None
    if marker["markerType"] in _BODY_MARKERS:
        body = mbs.GetObject(marker["bodyNumber"])
        if body["objectType"] == "Ground":
            offset = np.array(body["referenceRotation"]) @ np.array(marker["localPosition"])
            return np.array(body["referencePosition"]) + offset
    return None


def read_moving_coordinate(mbs: Any, number: int, data: dict[str, Any]) -> MovingCoordinate | None:
    """A CoordinateConstraint to ground whose offset is given, by a user function or constant; or None."""
    known = (
        data["objectType"] == "ConnectorCoordinate"
        and data["activeConnector"]
        and not data["velocityLevel"]
        and data["factor1"] == 1.0
        and (data["offset"] != 0.0 or data["offsetUserFunction"])
    )
    if not known:
        return None
    ground, marker = (mbs.GetMarker(number) for number in data["markerNumbers"])
    if any(m["markerType"] != "NodeCoordinate" for m in (ground, marker)):
        return None
    if mbs.GetNode(ground["nodeNumber"])["nodeType"] != "PointGround":
        return None
    node, axis = int(marker["nodeNumber"]), int(marker["coordinate"])
    reference = np.array(mbs.GetNode(node)["referenceCoordinates"])
    if axis >= len(reference) // 2:
        return None
    motion = _motion(mbs, number, data, float(reference[axis]))
    return MovingCoordinate(node, axis, motion, f"'{data['name']}'")


def _motion(mbs: Any, number: int, data: dict[str, Any], reference: float) -> Motion:
    """The motion that a helper left at the user function, or that of this coordinate alone."""
    offset = float(data["offset"])
    if not data["offsetUserFunction"]:
        return rest(np.array([reference + offset]))
    function = data["offsetUserFunction"]["function"]
    if hasattr(function, "motion"):
        return function.motion
    rate = data["offsetUserFunction_t"]["function"] if data["offsetUserFunction_t"] else None
    return motion_of(
        lambda t: reference + function(mbs, t, number, offset),
        None if rate is None else lambda t: rate(mbs, t, number, offset),
        is_pure=False,
    )
