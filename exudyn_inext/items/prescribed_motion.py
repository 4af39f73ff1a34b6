"""CreatePrescribedMotion: a node that is moved along a given curve."""

from collections.abc import Callable
from typing import Any

import numpy as np
from exudyn.itemInterface import CoordinateConstraint, MarkerNodeCoordinate, NodePointGround

from ..arrays import Array
from ..cable.link import Motion
from ..checks import require_finite_array
from ..constraints.motion import motion_of
from ..errors import InputError
from .arguments import node_number, require_system

_NODES = {"Point2DSlope1": 2, "PointSlope1": 3}


def CreatePrescribedMotion(
    mbs: Any,
    nodeNumber: int,
    position: Callable[[float], Any],
    velocity: Callable[[float], Any] | None = None,
    acceleration: Callable[[float], Any] | None = None,
) -> dict[str, Any]:
    """Move the position of a cable's node along a curve; its slope stays free.

    Adds one CoordinateConstraint with offset user functions for each coordinate, so that native implicit
    solvers understand it as well. The functions must depend on the time alone. What vibrates above 500 Hz
    needs milliseconds as the unit of time.

    Args:
        mbs: the system where the items are added.
        nodeNumber: node of a cable, NodePoint2DSlope1 or NodePointSlope1.
        position: t [s] -> (2,) or (3,) absolute position [m]; at the start that of the node.
        velocity: t -> its derivative [m/s]; None: differences, of one side where the motion begins or ends.
        acceleration: t -> second derivative [m/s^2]; None: differences.

    Returns:
        dict with 'constraintObjects', one for each coordinate.

    Raises:
        InputError: wrong node, not functions, or values of the wrong size; mbs is unchanged then.

    Example:
        CreatePrescribedMotion(mbs, cable["nodes"][0], lambda t: [0.1 * (1 - np.cos(5 * t)), 0])
    """
    reference = _reference_position(mbs, nodeNumber)
    for name, function in (("position", position), ("velocity", velocity), ("acceleration", acceleration)):
        _check_function(name, function, len(reference), optional=name != "position")
    place = _cut(position, len(reference))
    motion = motion_of(
        place,
        None if velocity is None else _cut(velocity, len(reference)),
        None if acceleration is None else _cut(acceleration, len(reference)),
    )
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    constraints = []
    for axis in range(len(reference)):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodeNumber, coordinate=axis))
        offset, rate = _offset_functions(motion, place, axis, float(reference[axis]))
        constraints.append(
            mbs.AddObject(
                CoordinateConstraint(
                    markerNumbers=[ground, marker], offsetUserFunction=offset, offsetUserFunction_t=rate
                )
            )
        )
    return {"constraintObjects": constraints}


def _reference_position(mbs: Any, number: Any) -> Array:
    require_system(mbs)
    place, count = node_number(number), mbs.systemData.NumberOfNodes()
    if not 0 <= place < count:
        raise InputError(f"nodeNumber = {number!r}: mbs has no such node, but {count}, counted from 0.")
    node = mbs.GetNode(place)
    dim = _NODES.get(node["nodeType"])
    if dim is None:
        raise InputError(
            f"nodeNumber = {number!r} is a {node['nodeType']}: must be a node of a cable, one of "
            f"{sorted(_NODES)}."
        )
    return np.array(node["referenceCoordinates"][:dim])


def _check_function(name: str, function: Any, dim: int, optional: bool) -> None:
    if function is None and optional:
        return
    if not callable(function):
        raise InputError(f"{name} = {function!r}: must be a function of the time, t -> {dim} numbers.")
    values = require_finite_array(f"{name}(0)", function(0.0))
    if values.ndim != 1 or len(values) not in (dim, 3) or values[dim:].any():
        raise InputError(
            f"{name}(0) = {values.tolist()}: must be {dim} finite numbers, as the node is {dim}D."
        )


def _cut(function: Callable[[float], Any], dim: int) -> Callable[[float], Array]:
    return lambda t: np.asarray(function(t), dtype=float)[:dim]


def _offset_functions(motion: Motion, place: Callable[[float], Array], axis: int, reference: float) -> Any:
    """Exudyn's user functions of the offset and its rate; the first one carries the motion.

    place: t -> (dim,) of the motion, without the derivatives.
    """

    def offset_user_function(mbs, t, itemNumber, lOffset):
        return float(place(t)[axis]) - reference

    def offset_rate_user_function(mbs, t, itemNumber, lOffset):
        return float(motion.at(t)[1, axis])

    offset_user_function.motion = motion  # type: ignore[attr-defined]
    return offset_user_function, offset_rate_user_function
