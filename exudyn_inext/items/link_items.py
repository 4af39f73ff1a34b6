"""Native constraints of an mbs that become links of a cable: distances and moving coordinates."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.link import Motion, rest
from ..constraints.motion import motion_of
from ..scene.links import MovingCoordinate, Rod
from ..scene.model import HeldCoordinate
from .functions_of_time import drive_of, is_of_time_alone, python_function
from .on_ground import markers_of, node_marker_to_ground, point_on_ground

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}


def read_rod(mbs: Any, data: dict[str, Any]) -> Rod | None:
    """An active distance constraint between nodes, or a node and ground; None if it is not one."""
    if data["objectType"] != "ConnectorDistance" or not data["activeConnector"]:
        return None
    nodes: list[int] = []
    points: list[Array] = []
    for marker in markers_of(mbs, data):
        point = point_on_ground(mbs, marker)
        if point is not None:
            points.append(point)
        elif marker["markerType"] in _POSITION_MARKERS:
            nodes.append(int(marker["nodeNumber"]))
        else:
            return None
    if not nodes:
        return None
    return Rod(tuple(nodes), points[0] if points else None, float(data["distance"]), f"'{data['name']}'")


def read_held_coordinate(mbs: Any, data: dict[str, Any], is_moved: bool = False) -> HeldCoordinate | None:
    """What a CoordinateConstraint ties to the ground, with an offset or without; None of other objects."""
    if data["objectType"] != "ConnectorCoordinate" or data["velocityLevel"]:
        return None
    if bool(data["offset"] != 0.0 or data["offsetUserFunction"]) != is_moved:
        return None
    marker, which = node_marker_to_ground(mbs, data) or ({"markerType": ""}, 0)
    if marker["markerType"] != "NodeCoordinate":
        return None
    gradient = float(data["factor1"]) if which else -1.0
    return HeldCoordinate(int(marker["nodeNumber"]), int(marker["coordinate"]), gradient)


def read_moving_coordinate(mbs: Any, number: int, data: dict[str, Any]) -> MovingCoordinate | None:
    """A CoordinateConstraint to ground whose offset is given, by a user function or constant; or None."""
    tied = read_held_coordinate(mbs, data, is_moved=True)
    if tied is None or tied.gradient != 1.0:
        return None
    reference = np.array(mbs.GetNode(tied.node)["referenceCoordinates"])
    if tied.coordinate >= len(reference) // 2:
        return None
    motion = _motion(mbs, number, data, float(reference[tied.coordinate]))
    return MovingCoordinate(tied.node, tied.coordinate, motion, f"'{data['name']}'")


def _motion(mbs: Any, number: int, data: dict[str, Any], reference: float) -> Motion:
    """The motion that a helper left at the user function, or that of this coordinate alone."""
    offset = float(data["offset"])
    if not data["offsetUserFunction"]:
        return rest(np.array([reference + offset]))
    function = python_function(data["offsetUserFunction"])
    if hasattr(function, "motion"):
        return function.motion
    given = data["offsetUserFunction"], data["offsetUserFunction_t"]
    if drive := drive_of(given[0]):
        return _motion_of_drive(drive, reference)
    rate = python_function(given[1]) if given[1] else None
    return motion_of(
        lambda t: reference + function(mbs, t, number, offset),
        None if rate is None else lambda t: rate(mbs, t, number, offset),
        is_pure=all(is_of_time_alone(mbs, one) for one in given if one),
    )


def _motion_of_drive(drive: Any, reference: float) -> Motion:
    def at_times(times: Sequence[float]) -> Array:
        values: Array = drive.sample(times)
        values[:, 0] += reference
        return values

    is_given = bool(drive.rate)
    return Motion(lambda t: at_times([t])[0], is_smooth=is_given, given=(True, False), at_times=at_times)
