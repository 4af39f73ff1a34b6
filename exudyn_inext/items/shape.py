"""The initial shape of a cable: nodal positions, slopes and velocities."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.cable import reference_lengths
from ..checks import (
    LARGEST_NUMBER_OF_ITEMS,
    require_choice,
    require_finite_array,
    require_flag,
    require_integer,
    require_positive,
)
from ..errors import InputError
from .catenary import hanging_curve, of_constant_length

SLOPE_TOLERANCE = 1e-8  # |r_x| - 1 [-]
LENGTH_TOLERANCE = 1e-2  # int |r_x|^2 dx / l - 1 of an element [-]
SMALLEST_RING = 3  # elements
LENGTH_REFERENCES = ("shape", "straight")
LARGE_ANGLE = 15.0  # between a slope and the lines to the next nodes [degrees]
MIDDLE_TOLERANCE = 0.1  # |r_x| - 1 in the middle of an element [-]; 0.045 for half a turn


@dataclass(frozen=True, eq=False)
class CableShape:
    """Nodes of a cable in its initial, inextensible shape.

    Args:
        positions: (n, 2) or (n, 3) nodal positions [m]; n = number of elements + 1.
        slopes: like positions; unit tangents dr/dx [-].
        elementLengths: arc length of each element [m], a number or (n - 1,) values; None: the
            lengths of the curves through positions and slopes.
        velocities: like positions [m/s]; None: at rest.
        slopeVelocities: like positions, d(dr/dx)/dt [1/s]; None: zero.
        closed: whether one more element joins the last node to the first one; every node is given once,
            and there are as many elements as nodes.
        lengthReference: what Eq. (19) keeps constant: 'shape': int |r_x|^2 dx of each element as it is in
            this shape; 'straight': its arc length, where the shape is only near one that the cable can
            have, for SolveEquilibrium to start from, or where a cable that stretches begins strained.
    """

    positions: Any
    slopes: Any
    elementLengths: Any = None
    velocities: Any = None
    slopeVelocities: Any = None
    closed: bool = False
    lengthReference: str = "shape"

    @staticmethod
    def Circle(
        center: Any, radius: float, numberOfElements: int, normal: Any = (0, 0, 1), start: Any = (1, 0, 0)
    ) -> "CableShape":
        """Closed ring, counterclockwise about `normal`.

        Args:
            center: (2,) or (3,) [m].
            radius: [m].
            numberOfElements: at least 3.
            normal: (3,) axis of the ring; need not be a unit vector.
            start: (2,) or (3,) direction from the center to the first node, not along `normal`.

        Raises:
            InputError: a number out of range, or start and normal are parallel.
        """
        number = _element_count(numberOfElements)
        if number < SMALLEST_RING:
            raise InputError(f"numberOfElements = {number}: a ring needs at least {SMALLEST_RING}.")
        size = require_positive("radius [m]", radius)
        first, second = _axes_of_plane(_point("normal", normal), _point("start", start))
        angle = 2.0 * np.pi * np.arange(number)[:, None] / number
        outward = np.cos(angle) * first + np.sin(angle) * second
        return CableShape(
            positions=_point("center", center) + size * outward,
            slopes=np.cos(angle) * second - np.sin(angle) * first,
            elementLengths=2.0 * np.pi * size / number,
            closed=True,
        )

    @staticmethod
    def Line(
        positionStart: Any,
        positionEnd: Any,
        numberOfElements: int,
        velocityStart: Any = (0, 0, 0),
        velocityEnd: Any = (0, 0, 0),
    ) -> "CableShape":
        """Straight cable with elements of equal length and a velocity that is linear in x.

        Args:
            positionStart: (2,) or (3,) position of the first node [m].
            positionEnd: position of the last node [m].
            numberOfElements: at least 1.
            velocityStart: velocity of the first node [m/s].
            velocityEnd: velocity of the last node [m/s].

        Raises:
            InputError: the two ends coincide, or a number is missing or not finite.
        """
        for name, given in (("positionStart", positionStart), ("positionEnd", positionEnd)):
            if given is None:
                raise InputError(
                    f"{name} = None is missing: give both ends of the straight cable, or a shape."
                )
        number = _element_count(numberOfElements)
        start, end = _point("positionStart", positionStart), _point("positionEnd", positionEnd)
        length = float(np.linalg.norm(end - start))
        if length == 0.0:
            raise InputError(
                f"length = 0 m: positionStart and positionEnd are both {start.tolist()}; give two "
                "different points, or a CableShape whose nodes lie apart."
            )
        at = np.linspace(0.0, 1.0, number + 1)[:, None]
        v_start, v_end = _point("velocityStart", velocityStart), _point("velocityEnd", velocityEnd)
        along = np.broadcast_to((end - start) / length, (number + 1, 3))
        turning = np.broadcast_to((v_end - v_start) / length, (number + 1, 3))
        return CableShape(
            positions=start + at * (end - start),
            slopes=along,
            elementLengths=length / number,
            velocities=v_start + at * (v_end - v_start),
            slopeVelocities=turning,
        )

    @staticmethod
    def Catenary(
        positionStart: Any,
        positionEnd: Any,
        length: float,
        numberOfElements: int,
        gravity: Any = (0, -1, 0),
    ) -> "CableShape":
        """Cable at rest that hangs between two points, as it does without bending stiffness.

        The length is exact: the nodes are those of elements near the catenary, which keep their length.
        `SolveEquilibrium` finds how the bending stiffness changes the shape. A warning says where elements
        are too long for the bend at the lowest point, so that nodes lie far from it.

        Args:
            positionStart: (2,) or (3,) position of the first node [m].
            positionEnd: position of the last node [m].
            length: of the cable, at least the distance of both [m].
            numberOfElements: at least 1.
            gravity: (2,) or (3,) direction in which it hangs; need not be a unit vector.

        Raises:
            InputError: a cable that is too short, no direction, ends one above the other, or elements
                that are too long to join both.
        """
        number = _element_count(numberOfElements)
        start, end = _point("positionStart", positionStart), _point("positionEnd", positionEnd)
        size, down = require_positive("length [m]", length), _point("gravity", gravity)
        if not down.any():
            raise InputError(f"gravity = {down.tolist()}: give the direction in which the cable hangs.")
        at = np.linspace(0.0, size, number + 1)
        curve = hanging_curve(end - start, size, -down / np.linalg.norm(down), at)
        q = of_constant_length(np.stack(curve, axis=1), size)
        return CableShape(start + q[:, 0], q[:, 1], size / number, lengthReference="straight")


@dataclass(frozen=True, eq=False)
class CheckedShape:
    """A shape that an inextensible cable can have.

    q, v: (n, 2, 3) coordinates [m, -] and velocities [m/s, 1/s]; the first node of a closed cable is
        repeated.   lengths: (n - 1,) [m].   closed, straight_lengths: see `Cable`.
    """

    q: Array
    v: Array
    lengths: Array
    closed: bool
    straight_lengths: bool


def check_shape(shape: CableShape, stretches: bool = False) -> CheckedShape:
    """Validate `shape`.

    Args:
        stretches: whether the cable has an axial stiffness: with straight lengths it may begin strained.

    Raises:
        InputError: wrong sizes, numbers that are not finite, slopes that are not unit vectors,
            points that no inextensible cable of the given length joins.
    """
    if not isinstance(shape, CableShape):
        raise InputError(f"shape = {shape!r}: must be a CableShape(positions, slopes, ...).")
    positions, slopes = _rows("positions", shape.positions), _rows("slopes", shape.slopes)
    nodes = len(positions)
    if nodes < 2:
        raise InputError(f"positions has {nodes} point(s): a cable needs at least 2.")
    rates = [
        np.zeros((nodes, 3)) if given is None else _rows(name, given)
        for name, given in (
            ("velocities", shape.velocities),
            ("slopeVelocities", shape.slopeVelocities),
        )
    ]
    for name, rows in (("slopes", slopes), ("velocities", rates[0]), ("slopeVelocities", rates[1])):
        if len(rows) != nodes:
            raise InputError(f"{name} has {len(rows)} rows: needs {nodes}, one for each position.")
    require_choice("lengthReference", shape.lengthReference, LENGTH_REFERENCES)
    closed = require_flag("closed", shape.closed)
    q, v = np.stack([positions, slopes], axis=1), np.stack(rates, axis=1)
    if closed:
        _check_ring(positions)
        q, v = np.concatenate([q, q[:1]]), np.concatenate([v, v[:1]])
    lengths = _checked_lengths(q, shape.elementLengths)
    if not (stretches and shape.lengthReference == "straight"):
        _check_unstrained(q, lengths, stretches)
    return CheckedShape(q, v, lengths, closed, shape.lengthReference == "straight")


def _check_ring(positions: Array) -> None:
    if len(positions) < SMALLEST_RING:
        raise InputError(f"positions has {len(positions)} points: a ring needs at least {SMALLEST_RING}.")
    if np.array_equal(positions[0], positions[-1]):
        raise InputError(
            f"positions[0] and positions[-1] are both {positions[0].tolist()}: with closed=True every node "
            "is given once, and an element joins the last one to the first one; leave the last row out."
        )


def _axes_of_plane(normal: Array, start: Array) -> tuple[Array, Array]:
    """Unit vectors in the plane of a ring: towards `start`, and a quarter turn further."""
    second = np.cross(normal, start)
    size = float(np.linalg.norm(second))
    if not size > 1e-9 * float(np.linalg.norm(normal) * np.linalg.norm(start)):
        raise InputError(
            f"normal = {normal.tolist()} and start = {start.tolist()} must not be zero or parallel: the ring "
            "lies in a plane across the normal; choose another start."
        )
    second = second / size
    first = np.cross(second, normal)
    return first / float(np.linalg.norm(first)), second


def _element_count(number: Any) -> int:
    return require_integer("numberOfElements", number, 1, LARGEST_NUMBER_OF_ITEMS)


_SHAPES = {1: "one point with 2 or 3 components", 2: "one row of 2 or 3 numbers a node"}


def _vectors(name: str, values: Any, ndim: int) -> Array:
    """(..., 3) from (..., 2) or (..., 3) with that number of axes."""
    array = require_finite_array(name, values)
    if array.ndim != ndim:
        raise InputError(f"{name} has shape {array.shape}: needs {_SHAPES[ndim]}.")
    missing = 3 - array.shape[-1]
    if missing not in (0, 1):
        raise InputError(f"{name} has shape {array.shape}: needs 2 or 3 components a point.")
    return np.concatenate([array, np.zeros((*array.shape[:-1], missing))], axis=-1)


def _point(name: str, values: Any) -> Array:
    return _vectors(name, values, 1)


def _rows(name: str, values: Any) -> Array:
    return _vectors(name, values, 2)


def _check_unit_slopes(slopes: Array) -> None:
    norms = np.linalg.norm(slopes, axis=1)
    worst = int(np.argmax(np.abs(norms - 1.0)))
    if abs(norms[worst] - 1.0) > SLOPE_TOLERANCE:
        raise InputError(
            f"slopes[{worst}] = {slopes[worst].tolist()} has length {norms[worst]:.9g}: the slope of an "
            f"inextensible cable is a unit vector (tolerance {SLOPE_TOLERANCE:g}); divide it by its length."
        )


def _curve_lengths(q: Array) -> Array:
    """(N,) lengths l with int |r_x|^2 dx = l of the Hermite curves through positions and slopes."""
    d = q[1:, 0] - q[:-1, 0]
    ends = q[:-1, 1] + q[1:, 1]
    cosine = np.einsum("ei,ei->e", q[:-1, 1], q[1:, 1])
    chord = np.einsum("ei,ei->e", d, d)
    turned = np.einsum("ei,ei->e", d, ends)
    # q^T G q = l in closed form: (22 + 2 cosine) l^2 + 6 turned l - 36 chord = 0
    a, b = 22.0 + 2.0 * cosine, 6.0 * turned
    return (-b + np.sqrt(b * b + 144.0 * a * chord)) / (2.0 * a)


def _checked_lengths(q: Array, given: Any) -> Array:
    number = len(q) - 1
    if given is None:
        lengths = _curve_lengths(q)
    else:
        lengths = require_finite_array("elementLengths", given)
        if lengths.ndim != 0 and lengths.shape != (number,):
            raise InputError(
                f"elementLengths has shape {lengths.shape}: needs one number, or one for each of the "
                f"{number} elements."
            )
        lengths = np.array(np.broadcast_to(lengths, (number,)))
    for k, length in enumerate(lengths):
        require_positive(f"length of element {k}, between nodes {k} and {_next(k, q)} [m]", float(length))
    return lengths


def _check_unstrained(q: Array, lengths: Array, stretches: bool) -> None:
    try:
        _check_unit_slopes(q[:, 1])
        _check_reach(q, lengths)
    except InputError as error:
        remedy = " With lengthReference='straight' this cable, which stretches, begins strained." * stretches
        raise InputError(f"{error}{remedy}") from None


def _check_reach(q: Array, lengths: Array) -> None:
    chords = np.linalg.norm(q[1:, 0] - q[:-1, 0], axis=1)
    k = int(np.argmax(chords / lengths))
    if chords[k] > lengths[k] * (1.0 + SLOPE_TOLERANCE):
        raise InputError(
            f"nodes {k} and {_next(k, q)} are {chords[k]:.9g} m apart, the element between them is "
            f"{lengths[k]:.9g} m long: no inextensible cable joins them; lengthen the element or move "
            "the points together."
        )
    mean_square = reference_lengths(q, lengths) / lengths
    k = int(np.argmax(np.abs(mean_square - 1.0)))
    if abs(mean_square[k] - 1.0) > LENGTH_TOLERANCE:
        raise InputError(
            f"the curve through nodes {k} and {_next(k, q)} with the given slopes has a mean square stretch "
            f"of {mean_square[k]:.6g} for an element of {lengths[k]:.9g} m: an inextensible cable allows "
            f"1 +- {LENGTH_TOLERANCE:g}; correct elementLengths or the slopes, or use more elements."
            f"{_tangents(q)}"
        )
    _check_middles(q, lengths)


def _tangents(q: Array) -> str:
    """Which slope is farthest from the direction of the curve there, if it is far from it."""
    chords = q[1:, 0] - q[:-1, 0]
    chords = chords / np.maximum(np.linalg.norm(chords, axis=1), 1e-300)[:, np.newaxis]
    ends = np.concatenate([chords[:1], chords]), np.concatenate([chords, chords[-1:]])
    cosines = np.maximum(*(np.einsum("ni,ni->n", q[:, 1], chord) for chord in ends))
    worst = int(np.argmin(cosines))
    angle = float(np.degrees(np.arccos(np.clip(cosines[worst], -1.0, 1.0))))
    if angle < LARGE_ANGLE:
        return ""
    return (
        f" slopes[{worst}] = {q[worst, 1].tolist()} is no tangent of the shape: it is {angle:.0f} degrees "
        "off the lines to the next nodes; CableShape.Catenary has tangents of a cable that sags."
    )


def _next(k: int, q: Array) -> int:
    """Number of the node after node k; a ring's last element ends at its first node."""
    ends_at_start = k == len(q) - 2 and np.array_equal(q[0], q[-1])
    return 0 if ends_at_start else k + 1


def _check_middles(q: Array, lengths: Array) -> None:
    """Slopes that point elsewhere than the curve show in the middle of the elements."""
    middle = 1.5 * (q[1:, 0] - q[:-1, 0]) / lengths[:, None] - 0.25 * (q[1:, 1] + q[:-1, 1])
    norms = np.linalg.norm(middle, axis=1)
    k = int(np.argmax(np.abs(norms - 1.0)))
    if abs(norms[k] - 1.0) > MIDDLE_TOLERANCE:
        raise InputError(
            f"the curve through nodes {k} and {_next(k, q)} has |r_x| = {norms[k]:.4g} midway: an "
            f"inextensible cable allows 1 +- {MIDDLE_TOLERANCE:g} there; check the direction of the slopes, "
            f"which point from the first to the last node, or use more elements.{_tangents(q)}"
        )
