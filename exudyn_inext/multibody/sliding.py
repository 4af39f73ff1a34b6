"""Points that slide along cables: each is the foot of the perpendicular of another point p.

On a chain of elements r(s), with d = p - r, the slope r' and the rates r_t and r'_t at a fixed s,

    r' . d = 0,    s_t = (r' . (p_t - r_t) + r'_t . d) / (r' . r' - r'' . d),

    x = r,    x_t = r_t + r' s_t,    x_tt = 2 r'_t s_t + r'' s_t^2 + r' s_tt.

The frame has t = r' / |r'| and one or two normals n. x_tt goes without its last term, and `along` is S alone:
both lack what lies along the slope, which does for equations along the normals.

In space the frame follows from a direction e; only a cable along -e, which hardly ever happens, has none:
n = b - (b . t) / (1 + e . t) (t + e), with b at right angles to e. It turns by w = t x t_t + tau t with
tau = (t x e) . t_t / (1 + e . t).
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, record_type
from ..called_system import implements
from ..compiled import inlined
from .points import cross, dot, move_rare_points, place_rare_points

CLOSE = 1e-13  # of the place to the foot, relative to the length of an element
MOST_STEPS = 30  # of Newton's method, besides those from element to element
BEYOND = 1e-6  # the ends of a chain that a foot may be, relative to the length of an element
FRAME = np.array(
    [[1.0, np.sqrt(2.0), np.sqrt(3.0)], [np.sqrt(2.0), -1.0, 0.0], [1.0, np.sqrt(2.0), -np.sqrt(3.0)]]
)
FRAME /= np.linalg.norm(FRAME, axis=1)[:, np.newaxis]  # rows e and both b

SLIDER = record_type(
    [
        ("point", np.int64),  # that slides, a point of a cable
        ("follows", np.int64),  # p, a point before it
        ("dimension", np.int64),  # of the cable
        ("first", np.int64),  # coordinate of the chain
        ("elements", np.int64),  # how many
        ("segment", np.int64),  # which of them, at present
        ("x", np.float64),  # on it [m]
        ("length", np.float64),  # of that element
        ("lengths", np.int64),  # first of those of all its elements, see `Sliders`
        ("weights", np.float64, (4, 4)),  # S and its first three derivatives there
        ("slope", np.float64, (3,)),  # r'
        ("bend", np.float64, (3,)),  # r''
        ("way", np.float64, (3,)),  # d
        ("rate", np.float64, (3,)),  # of r', where the point is
        ("change", np.float64, (3,)),  # of this rate, with accelerations of the coordinates zero
    ]
)

PLACE = ("segment", "x", "length")  # from which the next foot is looked for


class Sliders(NamedTuple):
    """records: of all of them.   lengths: of their elements, one chain after the other [m].

    points: of the scene.
    """

    records: Any
    lengths: Array
    points: Any = None


def span_chains(sliders):
    """Let coordinates of its whole chain belong to each point that slides, until it is placed again."""
    records, points = sliders.records, sliders.points
    points["first"][records["point"]] = records["first"]
    points["width"][records["point"]] = 2 * records["dimension"] * (records["elements"] + 1)


@inlined
def set_frame(dimension, slope, frame, turn):
    """Slope and normals as columns of an orientation (3, 3).

    slope: (3,) r'.   frame: (3, 3) rows e and both b.
    """
    norm = np.sqrt(dot(slope, slope))
    for i in range(3):
        turn[i, 0] = slope[i] / norm
    if dimension == 2:
        turn[0, 1], turn[1, 1] = -turn[1, 0], turn[0, 0]
        return
    t = turn[:, 0]
    for j in range(1, 3):
        share = dot(frame[j], t) / (1.0 + dot(frame[0], t))
        for i in range(3):
            turn[i, j] = frame[j, i] - share * (t[i] + frame[0, i])


@inlined
def weigh(slider):
    """S and derivatives at present, see `element.shape_functions`; straight beyond a chain's ends."""
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
    w[3, 0] = 12.0 / (length * length * length)
    w[3, 1] = w[3, 3] = 6.0 / (length * length)
    w[3, 2] = -w[3, 0]
    if beyond != 0.0:
        for k in range(4):
            w[0, k] += beyond * w[1, k]
            w[2, k] = w[3, k] = 0.0


@inlined
def _sum(slider, order, i, q):
    """Component i of r or one of its derivatives from coordinates, or of their rates from velocities."""
    dim, total = slider.dimension, 0.0
    at = slider.first + 2 * dim * slider.segment + i
    for k in range(4):
        total += slider.weights[order, k] * q[at + dim * k]
    return total


@inlined
def _measure(slider, point, p, q):
    """At the present place; returns how far the foot is, to first order [m]."""
    weigh(slider)
    for i in range(slider.dimension):
        point.x[0, i] = _sum(slider, 0, i, q)
        slider.slope[i], slider.bend[i] = _sum(slider, 1, i, q), _sum(slider, 2, i, q)
        slider.way[i] = p.x[0, i] - point.x[0, i]
    square = dot(slider.slope, slider.slope)
    return dot(slider.slope, slider.way) / max(square - dot(slider.bend, slider.way), 0.5 * square)


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


@implements(place_rare_points, Sliders)
def place_sliders(sliders, q):
    """Feet on the chains."""
    points = sliders.points
    for k in range(len(sliders.records)):
        slider = sliders.records[k]
        point = points[slider.point]
        _find_foot(slider, sliders.lengths, point, points[slider.follows], q)
        dim = slider.dimension
        point.first, point.width = slider.first + 2 * dim * slider.segment, 4 * dim
        set_frame(dim, slider.slope, FRAME, point.orientation)
        for j in range(4):
            point.weights[j] = slider.weights[0, j]
            for i in range(dim):
                point.along[i, dim * j + i] = slider.weights[0, j]


@inlined
def _move_along(slider, point, p, q, v):
    """Velocity, acceleration, and rates of the slope, where the point is."""
    slope, bend, way, rate = slider.slope, slider.bend, slider.way, slider.rate
    along, acceleration = 0.0, 0.0
    rate[2] = slider.change[2] = 0.0  # which are no part of a plane
    for i in range(slider.dimension):
        rate[i] = _sum(slider, 1, i, v)
        along += slope[i] * (p.x[1, i] - point.x[1, i]) + rate[i] * way[i]
    reach = dot(slope, slope) - dot(bend, way)
    speed = along / reach
    for i in range(slider.dimension):
        point.x[1, i] += slope[i] * speed
        point.x[2, i] = (2.0 * rate[i] + bend[i] * speed) * speed
        rate[i] += bend[i] * speed
        slider.change[i] = (2.0 * _sum(slider, 2, i, v) + _sum(slider, 3, i, q) * speed) * speed
        acceleration += slope[i] * (p.x[2, i] - point.x[2, i]) + slider.change[i] * way[i]
        acceleration += 2.0 * rate[i] * (p.x[1, i] - point.x[1, i])
    for i in range(slider.dimension):
        slider.change[i] += bend[i] * acceleration / reach


@inlined
def _turn_with_slope(slider, point):
    """The frame's angular velocity and its rate; t_t and, but for what lies along t, t_tt follow from r'."""
    t, norm = point.orientation[:, 0], np.sqrt(dot(slider.slope, slider.slope))
    rate, change, space = slider.rate, slider.change, 1.0 if slider.dimension == 3 else 0.0
    stretch, along = dot(t, rate), 0.0
    for i in range(3):
        change[i] = (change[i] - 2.0 * stretch / norm * rate[i]) / norm
        rate[i] = (rate[i] - stretch * t[i]) / norm
        along += FRAME[0, i] * t[i]
    share = space / (1.0 + along)
    twist, twist_rate = 0.0, 0.0
    for i in range(3):
        twist += share * cross(t, FRAME[0], i) * rate[i]
        twist_rate += share * cross(t, FRAME[0], i) * change[i]
    twist_rate -= share * twist * dot(FRAME[0], rate)
    for i in range(3):
        point.spin[i] = cross(t, rate, i) + twist * t[i]
        point.spin_rate[i] = cross(t, change, i) + twist_rate * t[i] + twist * rate[i]


@implements(move_rare_points, Sliders)
def move_sliders(sliders, q, v):
    """Feet on the chains; velocities at a fixed s are set."""
    points = sliders.points
    for k in range(len(sliders.records)):
        slider = sliders.records[k]
        point = points[slider.point]
        _move_along(slider, point, points[slider.follows], q, v)
        _turn_with_slope(slider, point)
