"""A slope that follows a direction fixed to a body: native constraint with user functions.

c_k = t_k . r_x = 0 for the directions t_k = A(q_body) b_k across the cable: one in the plane, two in space.
"""

from typing import Any, NamedTuple

import numpy as np
from exudyn.itemInterface import CoordinateVectorConstraint, MarkerNodeCoordinates

from ...arrays import Array
from .body_frame import BodyFrame


class Clamp(NamedTuple):
    """What a constraint with these user functions does.   body_node, node: numbers.   across: (k, 3) b_k."""

    body_node: int
    node: int
    across: Array


def directions_across(direction: Array, frame: BodyFrame, dim: int) -> Array:
    """(dim - 1, 3) unit vectors b_k of the body's frame, across `direction` (3,) of that frame.

    In the plane, the one that lies in the plane of the cable.
    """
    if dim == 2:
        orientation = frame.orientation()
        along = orientation @ direction
        return np.array([orientation.T @ [-along[1], along[0], 0.0]])
    return across_in_space(direction)


def across_in_space(direction: Array) -> Array:
    """(2, 3) unit vectors at right angles to a direction (3,) and each other."""
    smallest = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(direction, smallest)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])


def add_clamp(mbs: Any, frame: BodyFrame, node: int, direction: Array, dim: int) -> dict[str, list[int]]:
    """Markers and constraint that keep the slope of a cable's node along `direction` of a body."""
    markers = [int(mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=n))) for n in (frame.node, node)]
    across = directions_across(direction, frame, dim)
    value, jacobian = _user_functions(frame, across, dim)
    value.clamp = Clamp(int(frame.node or 0), node, across)
    constraint = mbs.AddObject(
        CoordinateVectorConstraint(
            markerNumbers=markers,
            scalingMarker0=np.zeros((dim - 1, len(frame.coordinates))),
            constraintUserFunction=value,
            jacobianUserFunction=jacobian,
        )
    )
    return {"markers": markers, "constraintObjects": [int(constraint)]}


def _user_functions(frame: BodyFrame, across: Array, dim: int) -> tuple[Any, Any]:
    """c (dim - 1,), and its Jacobian with respect to the coordinates of the body and of the node."""
    size, pose = len(frame.coordinates), frame.pose
    slopes = slice(size + dim, size + 2 * dim)

    def derivatives(q: Any) -> tuple[Array, Array]:
        q = np.asarray(q)
        _, rotation, angular = pose(q[:size])  # type: ignore[misc]
        slope = rotation[:dim].T @ q[slopes]  # in the body's frame
        jacobian = np.zeros((dim - 1, size + 2 * dim))
        jacobian[:, :size] = np.cross(across, slope) @ angular
        jacobian[:, slopes] = across @ rotation[:dim].T
        return across @ slope, jacobian

    def clamp_user_function(mbs, t, itemNumber, q, q_t, velocityLevel):
        value, jacobian = derivatives(q)
        return (jacobian @ np.asarray(q_t) if velocityLevel else value).tolist()

    def clamp_jacobian_user_function(mbs, t, itemNumber, q, q_t, velocityLevel):
        return derivatives(q)[1]

    return clamp_user_function, clamp_jacobian_user_function
