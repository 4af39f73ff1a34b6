"""A slope that follows a direction fixed to a body: native constraint with user functions.

c_k = t_k . r_x = 0 for the directions t_k = A(q_body) b_k across the cable: one in the plane, two in space.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from exudyn.itemInterface import CoordinateVectorConstraint, MarkerNodeCoordinates

from ...arrays import Array
from .body_frame import BodyFrame

Derivatives = Callable[[Array], tuple[Array, Array]]
"""Coordinates of two nodes, (n,), -> c (k,), c_q (k, n)."""


class Clamp(NamedTuple):
    """What a constraint with these user functions does.   body_node, node: numbers.   across: (k, 3) b_k."""

    body_node: int
    node: int
    across: Array


def directions_across(direction: Array, orientation: Array, dim: int) -> Array:
    """(dim - 1, 3) unit vectors b_k of a frame, across `direction` (3,) of that frame, and each other.

    In the plane, the one that lies in the plane of the cable.   orientation: (3, 3) of the frame.
    """
    if dim == 2:
        along = orientation @ direction
        return np.array([orientation.T @ [-along[1], along[0], 0.0]])
    smallest = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(direction, smallest)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])


def add_clamp(mbs: Any, frame: BodyFrame, node: int, direction: Array, dim: int) -> dict[str, list[int]]:
    """Markers and constraint that keep the slope of a cable's node along `direction` of a body."""
    across, body_node = directions_across(direction, frame.orientation(), dim), int(frame.node or 0)
    derivatives, meaning = clamp_derivatives(frame, across, dim), Clamp(body_node, node, across)
    markers, constraint = add_slope_constraint(mbs, (body_node, node), derivatives, meaning)
    return {"markers": markers, "constraintObjects": [constraint]}


def clamp_derivatives(frame: BodyFrame, across: Array, dim: int) -> Derivatives:
    """Of the coordinates of the body, then of the node."""
    size, pose = len(frame.coordinates), frame.pose
    slopes = slice(size + dim, size + 2 * dim)

    def derivatives(q: Array) -> tuple[Array, Array]:
        _, rotation, angular = pose(q[:size])  # type: ignore[misc]
        slope = rotation[:dim].T @ q[slopes]  # in the body's frame
        jacobian = np.zeros((dim - 1, size + 2 * dim))
        jacobian[:, :size] = np.cross(across, slope) @ angular
        jacobian[:, slopes] = across @ rotation[:dim].T
        return across @ slope, jacobian

    return derivatives


def add_slope_constraint(
    mbs: Any, nodes: Sequence[int], derivatives: Derivatives, meaning: Any, name: str = ""
) -> tuple[list[int], int]:
    """Markers and constraint c = 0.   meaning: `Clamp` or `SameSlope`, with one row for each of its b_k."""
    markers = [int(mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=node))) for node in nodes]
    value, jacobian = user_functions(derivatives)
    value.meaning = meaning
    constraint = CoordinateVectorConstraint(
        name=name,
        markerNumbers=markers,
        scalingMarker0=np.zeros((len(meaning.across), len(mbs.GetNode(nodes[0])["referenceCoordinates"]))),
        constraintUserFunction=value,
        jacobianUserFunction=jacobian,
    )
    return markers, int(mbs.AddObject(constraint))


def user_functions(derivatives: Derivatives) -> tuple[Any, Any]:
    """Of the constraint, or its rate, and of its Jacobian, as Exudyn calls them."""

    def slope_user_function(mbs, t, itemNumber, q, q_t, velocityLevel):
        value, jacobian = derivatives(np.asarray(q))
        return (jacobian @ np.asarray(q_t) if velocityLevel else value).tolist()

    def slope_jacobian_user_function(mbs, t, itemNumber, q, q_t, velocityLevel):
        return derivatives(np.asarray(q))[1]

    return slope_user_function, slope_jacobian_user_function
