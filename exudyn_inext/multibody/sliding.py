"""Points that slide along planar cables: each is the foot of the perpendicular of another point p.

On a chain of elements r(s), with d = p - r, the slope r' and the rates r_t and r'_t at a fixed s,

    r' . d = 0,    s_t = (r' . (p_t - r_t) + r'_t . d) / (r' . r' - r'' . d),

    x = r,    x_t = r_t + r' s_t,    x_tt = 2 r'_t s_t + r'' s_t^2,

with a frame along the slope. What x_tt lacks lies along the slope, and so does what `along` lacks, that is S:
this does for equations along the normal.
"""

from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, record_type
from ..compiled import dispatched, inlined
from ..system import implements

CLOSE = 1e-13  # of the place to the foot, relative to the length of an element
MOST_STEPS = 30  # of Newton's method, besides those from element to element
BEYOND = 1e-6  # the ends of a chain that a foot may be, relative to the length of an element
PER_NODE = 4  # coordinates

SLIDER = record_type(
    [
        ("point", np.int64),  # that slides, a point of a cable
        ("follows", np.int64),  # p, a point before it
        ("first", np.int64),  # coordinate of the chain
        ("elements", np.int64),  # how many
        ("segment", np.int64),  # which of them, at present
        ("x", np.float64),  # on it [m]
        ("length", np.float64),  # of that element
        ("lengths", np.int64),  # first of those of all its elements, see `Sliders`
        ("weights", np.float64, (3, 4)),  # S, S' and S'' there
        ("slope", np.float64, (2,)),  # r'
        ("bend", np.float64, (2,)),  # r''
        ("way", np.float64, (2,)),  # d
    ]
)


class Sliders(NamedTuple):
    """records: of all of them.   lengths: of their elements, one chain after the other [m]."""

    records: Any
    lengths: Array


class NoSliders(NamedTuple):
    """Of a scene that has none."""

    records: Any = np.zeros(0, SLIDER)


@dispatched
@singledispatch
def place_sliders(sliders, points, q):
    """Places, frames and Jacobians at q (n,); all other points are placed.

    Raises:
        NotImplementedError: no such points.
    """
    raise NotImplementedError(f"no sliding points of type {type(sliders).__name__}")


@dispatched
@singledispatch
def move_sliders(sliders, points, v):
    """Velocities at v (n,), and accelerations with those of the coordinates zero; all points move.

    Raises:
        NotImplementedError: no such points.
    """
    raise NotImplementedError(f"no sliding points of type {type(sliders).__name__}")


@implements(place_sliders, NoSliders)
def place_no_sliders(sliders, points, q):
    """There are none."""


@implements(move_sliders, NoSliders)
def move_no_sliders(sliders, points, v):
    """There are none."""


@inlined
def _weigh(slider):
    """S, S' and S'' at the present place, see `element.shape_functions`; straight beyond a chain's ends."""
    w, length = slider.weights, slider.length
    at = min(max(slider.x, 0.0), length)
    x, beyond = at / length, slider.x - at
    w[0, 0] = 1.0 + x * x * (2.0 * x - 3.0)
    w[0, 1] = length * x * (1.0 - x) * (1.0 - x)
    w[0, 2] = x * x * (3.0 - 2.0 * x)
    w[0, 3] = length * x * x * (x - 1.0)
    w[1, 0] = 6.0 * x * (x - 1.0) / length
    w[1, 1] = 1.0 + x * (3.0 * x - 4.0)
    w[1, 2] = -w[1, 0]
    w[1, 3] = x * (3.0 * x - 2.0)
    w[2, 0] = (12.0 * x - 6.0) / (length * length)
    w[2, 1] = (6.0 * x - 4.0) / length
    w[2, 2] = -w[2, 0]
    w[2, 3] = (6.0 * x - 2.0) / length
    if beyond != 0.0:
        for k in range(4):
            w[0, k] += beyond * w[1, k]
            w[2, k] = 0.0


@inlined
def _sum(slider, order, i, q):
    """Component i of r, r' or r'' from coordinates, or of their rates from velocities."""
    at, total = slider.first + PER_NODE * slider.segment + i, 0.0
    for k in range(4):
        total += slider.weights[order, k] * q[at + 2 * k]
    return total


@inlined
def _measure(slider, point, p, q):
    """At the present place; returns how far the foot is, to first order [m]."""
    _weigh(slider)
    along, square, bent = 0.0, 0.0, 0.0
    for i in range(2):
        point.x[0, i] = _sum(slider, 0, i, q)
        slider.slope[i], slider.bend[i] = _sum(slider, 1, i, q), _sum(slider, 2, i, q)
        slider.way[i] = p.x[0, i] - point.x[0, i]
        along += slider.slope[i] * slider.way[i]
        square += slider.slope[i] * slider.slope[i]
        bent += slider.bend[i] * slider.way[i]
    return along / max(square - bent, 0.5 * square)


@inlined
def _find_foot(slider, lengths, point, p, q):
    """By Newton's method from the last place."""
    for _ in range(MOST_STEPS + slider.elements):
        step = _measure(slider, point, p, q)
        if not abs(step) > CLOSE * slider.length:
            break
        slider.x += step
        if slider.x < 0.0 and slider.segment > 0:
            slider.segment -= 1
            slider.x = slider.length = lengths[slider.lengths + slider.segment]
        elif slider.x > slider.length and slider.segment < slider.elements - 1:
            slider.segment += 1
            slider.x, slider.length = 0.0, lengths[slider.lengths + slider.segment]


@implements(place_sliders, Sliders)
def place_all_sliders(sliders, points, q):
    """Arguments: see `place_sliders`."""
    for k in range(len(sliders.records)):
        slider = sliders.records[k]
        point = points[slider.point]
        _find_foot(slider, sliders.lengths, point, points[slider.follows], q)
        point.first, point.width = slider.first + PER_NODE * slider.segment, 2 * PER_NODE
        x, y = slider.slope[0], slider.slope[1]
        norm, turn = np.sqrt(x * x + y * y), point.orientation
        turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = x / norm, -y / norm, y / norm, x / norm
        for j in range(4):
            point.weights[j] = slider.weights[0, j]
            for i in range(2):
                point.along[i, 2 * j + i] = slider.weights[0, j]


@implements(move_sliders, Sliders)
def move_all_sliders(sliders, points, v):
    """Arguments: see `move_sliders`; velocities at a fixed s are set."""
    for k in range(len(sliders.records)):
        slider = sliders.records[k]
        point, p = points[slider.point], points[slider.follows]
        slope, bend, way = slider.slope, slider.bend, slider.way
        x, y = _sum(slider, 1, 0, v), _sum(slider, 1, 1, v)
        square = slope[0] * slope[0] + slope[1] * slope[1]
        along = slope[0] * (p.x[1, 0] - point.x[1, 0]) + slope[1] * (p.x[1, 1] - point.x[1, 1])
        along += x * way[0] + y * way[1]
        speed = along / (square - bend[0] * way[0] - bend[1] * way[1])
        point.x[1, 0] += slope[0] * speed
        point.x[1, 1] += slope[1] * speed
        point.x[2, 0] = (2.0 * x + bend[0] * speed) * speed
        point.x[2, 1] = (2.0 * y + bend[1] * speed) * speed
        x, y = x + bend[0] * speed, y + bend[1] * speed
        point.spin[2] = (slope[0] * y - slope[1] * x) / square
