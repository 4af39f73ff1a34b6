"""Native constraints of an mbs that become links of a cable: distances and moving coordinates."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..chain.link import Link, Motion, rest
from ..constraints.distance import hanger, rod
from ..constraints.motion import motion_of, require_smooth
from ..constraints.prescribed_motion import prescribed
from ..errors import SceneError

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}
_BODY_MARKERS = {"BodyPosition", "BodyRigid"}


@dataclass(frozen=True, eq=False)
class Rod:
    """A distance constraint.

    nodes: one or two node numbers.   point: (3,) end on the ground, or None.   length: [m].
    motion: of that end (dim,), if it has been moved during a run.
    """

    nodes: tuple[int, ...]
    point: Array | None
    length: float
    name: str
    motion: Motion | None = None

    def links(self, places: list[int], dim: int) -> list[Link]:
        """The link on a cable's nodes at `places`.

        Raises:
            SceneError: the fixed end is out of the plane of a planar cable.
        """
        if self.point is None:
            return [rod((places[0], places[1]), dim, self.length)]
        if self.point[dim:].any():
            raise SceneError(
                f"{self.name} ends at {self.point.tolist()}, out of the plane of its cable: create the cable "
                "with dimension=3, or move that end to z = 0."
            )
        return [hanger(places[0], self.motion or rest(self.point[:dim]), self.length)]


@dataclass(frozen=True, eq=False)
class MovingCoordinate:
    """A coordinate constraint that moves one coordinate of a node's position.

    node: number.   axis: 0 for x, ...   motion: of the whole position (dim,), or of this axis alone.
    """

    node: int
    axis: int
    motion: Motion
    name: str


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


def links_of_motions(moving: list[MovingCoordinate], places: dict[int, int], dim: int) -> list[Link]:
    """The links of moving coordinates on a cable; places: node number -> index on the cable."""
    links: list[Link] = []
    in_space: dict[int, Motion] = {}
    for coordinate in moving:
        motion = coordinate.motion
        if motion.at(0.0).shape[1] != dim:
            motion = motion_along(motion, coordinate.axis, dim)
        motion = in_space.setdefault(id(coordinate.motion), motion)
        links += prescribed(places[coordinate.node], motion, [coordinate.axis])
    return links


def motion_along(motion: Motion, axis: int, dim: int) -> Motion:
    """The scalar motion as one along an axis of space."""
    direction = np.eye(dim)[axis]
    return replace(motion, at=lambda t: np.multiply.outer(motion.at(t)[:, 0], direction))


def require_smooth_motions(moving: list[MovingCoordinate], time: float) -> None:
    """Raise InputError unless all motions are differentiable twice at the start of the run [s]."""
    checked: set[int] = set()
    for coordinate in moving:
        motion = coordinate.motion
        if motion.is_smooth and not motion.rests and id(motion) not in checked:
            checked.add(id(motion))
            require_smooth(motion, time, f"the motion prescribed by {coordinate.name}")
