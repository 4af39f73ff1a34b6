"""Native mass points, which may lie on nodes of a cable: there they are part of its inertia.

Exudyn gives such a mass point the slopes of its node, too, but no rows for them: what a connector does to the
body at its other end then acts on these slopes. Loads are right.
"""

from collections.abc import Container
from typing import Any

from ..errors import SceneError
from .arguments import described

_TYPES = {"MassPoint", "MassPoint2D"}


def node_of_mass_point(data: dict[str, Any]) -> int:
    """The node of a mass point; -1 of another object.   data: of the object."""
    return int(data["nodeNumber"]) if data["objectType"] in _TYPES else -1


def require_none_connected(mbs: Any, number: int, data: dict[str, Any], mass_points: Container[int]) -> None:
    """Raise SceneError if an object connects one of these mass points on nodes of cables."""
    for marker in data.get("markerNumbers", ()) if mass_points else ():
        body = int(mbs.GetMarker(marker).get("bodyNumber", -1))
        if body in mass_points:
            point = mbs.GetObject(body)
            raise SceneError(
                f"{described(data, number)} connects {described(point, body)} on a node of a cable, whose "
                "slopes Exudyn would load with forces of the other body: connect the node, by "
                f"MarkerNodePosition(nodeNumber={int(point['nodeNumber'])})."
            )
