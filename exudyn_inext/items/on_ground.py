"""What native markers and connectors tie to the ground."""

from typing import Any

import numpy as np

from ..arrays import Array


def point_on_ground(mbs: Any, marker: dict[str, Any]) -> Array | None:
    """(3,) position of a marker on the ground, or None if it moves."""
    if _is_on_node(marker):
        node = mbs.GetNode(marker["nodeNumber"])
        return np.array(node["referenceCoordinates"]) if node["nodeType"] == "PointGround" else None
    body = mbs.GetObject(marker["bodyNumber"]) if "bodyNumber" in marker else None
    if body is None or body["objectType"] != "Ground":
        return None
    offset = np.array(body["referenceRotation"]) @ np.array(marker.get("localPosition", np.zeros(3)))
    return np.array(body["referencePosition"]) + offset


def markers_of(mbs: Any, data: dict[str, Any]) -> list[dict[str, Any]]:
    """Of a connector."""
    return [mbs.GetMarker(number) for number in data["markerNumbers"]]


def node_marker_to_ground(mbs: Any, data: dict[str, Any]) -> tuple[dict[str, Any], int] | None:
    """The marker on a node that a connector ties to the ground, and which of both it is; None: others."""
    if not data["activeConnector"]:
        return None
    markers = enumerate(markers_of(mbs, data))
    moving = [(marker, k) for k, marker in markers if point_on_ground(mbs, marker) is None]
    return moving[0] if len(moving) == 1 and _is_on_node(moving[0][0]) else None


def _is_on_node(marker: dict[str, Any]) -> bool:
    """Markers between bodies have a node only if they count turns."""
    return int(marker.get("nodeNumber", -1)) >= 0
