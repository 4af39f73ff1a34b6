"""Equations of joints between two points, c(x_0, x_1) = 0: all joints are made of six kinds of them.

With the distance d = x_1 - x_0 and axes e_0 and e_1 that are fixed to the points' frames:

    DIFFERENCE  c = f x_1i - x_0i - o        one coordinate in the global frame
    ALONG       c = (x_1 - f x_0) . e_s - o  along an axis of one of both; f = 0: x_1 is a slope
    ACROSS      c = e_0 . e_1 - o            axes at a right angle
    DISTANCE    c = |d| - o
    PARALLEL    of slopes, see `same_slope`: b = e_0, d = e_1
    ROLLING     of velocities alone, see `rolling`: n = e_0, a = e_1, r = o; c = 0
    DASHPOT     no joint, see `dashpots`: c_t is the rate of a spring's stretch; c = 0

o may follow functions of time, and e_0 may turn by them in its frame: c_t = d . e_0t - o_t, or
e_0t . e_1 - o_t, where nothing else moves. A DIFFERENCE of angles counts modulo its period.
"""

import numpy as np

from ..arrays import record_type
from ..compiled import inlined
from .points import cross, dot
from .rolling import place_contact, rolling_gamma
from .same_slope import slope_difference, slope_gamma

DIFFERENCE, ALONG, ACROSS, DISTANCE, PARALLEL, ROLLING, DASHPOT = range(7)

ROW = record_type(
    [
        ("kind", np.int64),
        ("points", np.int64, (2,)),
        ("entry", np.int64, (2,)),  # of each point, see `joints`; -1 for one that is fixed
        ("component", np.int64),  # i of DIFFERENCE, s of ALONG, which b of ROLLING, axis of DASHPOT
        ("axes", np.float64, (2, 3)),  # e_0 and e_1 in their frames
        ("factor", np.float64),  # f
        ("offset", np.float64),  # o, at present
        ("rest", np.float64),  # o without what is added to it
        ("functions", np.int64, (2,)),  # places of what follows the time, and is left of a way; or -1
        ("rates", np.float64, (2,)),  # o_t and o_tt
        ("period", np.float64),  # of c, or 0
        (
            "turning",
            np.int64,
        ),  # place of e_0 in its frame, each coordinate with its derivatives, or -1
        ("turn", np.float64, (2, 3)),  # derivatives of e_0 in its frame
        ("turned", np.float64, (2, 3)),  # the same in the global frame, at present; of ROLLING b and p
        ("drift", np.float64),  # -c_t where nothing else moves
        ("e", np.float64, (2, 3)),  # e_0 and e_1 at present; of PARALLEL dc/dx_0 and dc/dx_1
        ("d", np.float64, (3,)),  # distance at present; of ROLLING s
        ("connector", np.int64),  # of DASHPOT; dc_t/dx_t and dc_t/dw of both points are e and `turned`
        ("lag", np.float64),  # of DASHPOT, the step h [s]; 0: the damper is explicit
        ("reach", np.float64),  # of DASHPOT, the step h [s]; 0: the spring is explicit
        ("softness", np.float64),  # of DASHPOT, see there; 0: the row does not yield
        ("springiness", np.float64),  # of DASHPOT, the share of its spring in 1 / softness
        ("bend", np.float64),  # of DASHPOT, c_tt with accelerations of the coordinates zero
    ]
)


@inlined
def move_rows(rows, functions):
    """Offsets and axes at present.   functions: (F,) values of functions of time, with two derivatives."""
    for r in range(len(rows)):
        row = rows[r]
        row.offset, row.rates[0], row.rates[1] = row.rest, 0.0, 0.0
        for side in range(2):
            place = row.functions[side]
            if place >= 0:
                row.offset += functions[place]
                for k in range(2):
                    row.rates[k] += functions[place + 1 + k]
        if row.turning >= 0:
            for i in range(3):
                place = row.turning + 3 * i
                row.axes[0, i] = functions[place]
                for k in range(2):
                    row.turn[k, i] = functions[place + 1 + k]


@inlined
def _to_global(point, own, result):
    """A vector (3,) of the frame of a point."""
    for i in range(3):
        total = 0.0
        for j in range(3):
            total += point.orientation[i, j] * own[j]
        result[i] = total


@inlined
def _turn_axis(row, point, side):
    _to_global(point, row.axes[side], row.e[side])
    if side == 0 and row.turning >= 0:
        for k in range(2):
            _to_global(point, row.turn[k], row.turned[k])


@inlined
def _set_distance(row, one, other):
    factor = row.factor if row.kind == ALONG else 1.0
    for i in range(3):
        row.d[i] = other.x[0, i] - factor * one.x[0, i]


@inlined
def row_value(row, one, other):
    """c, with the axes, the distance and the drift at present."""
    row.drift = row.rates[0]
    if row.kind == DASHPOT:
        return 0.0
    if row.kind == PARALLEL:
        return slope_difference(row.axes[0], row.axes[1], one.x[0], other.x[0], row.e)
    if row.kind == DIFFERENCE:
        i = row.component
        value = row.factor * other.x[0, i] - one.x[0, i] - row.offset
        turns = np.rint(value / row.period) if row.period > 0.0 else 0.0
        return value - turns * row.period
    if row.kind == ACROSS or row.kind == ROLLING:
        _turn_axis(row, one, 0)
        _turn_axis(row, other, 1)
    if row.kind == ROLLING:
        place_contact(row.e[0], row.e[1], row.component, row.offset, row.turned)
        for i in range(3):
            row.d[i] = other.x[0, i] + row.turned[1, i] - one.x[0, i]
        return 0.0
    if row.kind == ACROSS:
        row.drift -= dot(row.turned[0], row.e[1])
        return dot(row.e[0], row.e[1]) - row.offset
    _set_distance(row, one, other)
    if row.kind == DISTANCE:
        return np.sqrt(dot(row.d, row.d)) - row.offset
    side = row.component
    _turn_axis(row, one if side == 0 else other, side)
    row.drift -= dot(row.d, row.turned[0])
    return dot(row.d, row.e[side]) - row.offset


@inlined
def row_derivative(row, side, sign, velocity, spin):
    """Rate of c if one point moves.

    Args:
        row: evaluated.   side: 0 or 1, which point.   sign: -f or -1 and 1: of its position in d.
        velocity, spin: (3,).
    """
    if row.kind == DIFFERENCE:
        return (row.factor if side == 1 else -1.0) * velocity[row.component]
    if row.kind == ACROSS:
        total = 0.0
        for i in range(3):
            total += cross(spin, row.e[side], i) * row.e[1 - side, i]
        return total
    if row.kind == DISTANCE:
        return sign * dot(velocity, row.d) / np.sqrt(dot(row.d, row.d))
    if row.kind == PARALLEL or row.kind == DASHPOT:
        return dot(velocity, row.e[side]) + dot(spin, row.turned[side])
    if row.kind == ROLLING:
        total = 0.0
        for i in range(3):
            turned = cross(spin, row.turned[1], i) if side == 1 else cross(spin, row.d, i)
            total += sign * row.turned[0, i] * (velocity[i] + turned)
        return total
    total = sign * dot(velocity, row.e[row.component])
    if side == row.component:
        for i in range(3):
            total += row.d[i] * cross(spin, row.e[side], i)
    return total


@inlined
def add_row_jacobian(row, side, point, jacobian, start):
    """Add dc/dq (width,) of one point to jacobian[start:]; the row is evaluated."""
    sign = 1.0
    if side == 0:
        sign = -row.factor if row.kind == ALONG else -1.0
    for k in range(point.width):
        jacobian[start + k] += row_derivative(row, side, sign, point.along[:, k], point.about[:, k])


@inlined
def _axis_rates(row, side, point, i):
    """Components i of e_t = w x e + u, e_tt = w_t x e + w x (w x e) + 2 w x u + u_t, with u of its turn."""
    spin, e = point.spin, row.e[side]
    along, square = dot(spin, e), dot(spin, spin)
    rate, change = cross(spin, e, i), cross(point.spin_rate, e, i) + spin[i] * along - square * e[i]
    if side == 0:
        change += 2.0 * cross(spin, row.turned[0], i) + row.turned[1, i]
        rate += row.turned[0, i]
    return rate, change


@inlined
def row_gamma(row, one, other):
    """-c_tt with accelerations of the coordinates zero, Eq. (27); the row is evaluated."""
    return _gamma_at_rest(row, one, other) + row.rates[1]


@inlined
def _gamma_at_rest(row, one, other):
    """That of an offset that does not change."""
    total = 0.0
    if row.kind == DASHPOT:
        return total
    if row.kind == DIFFERENCE:
        i = row.component
        return one.x[2, i] - row.factor * other.x[2, i]
    if row.kind == PARALLEL:
        return slope_gamma(row.axes[0], row.axes[1], one.x, other.x)
    if row.kind == ROLLING:
        return rolling_gamma(row.e[0], row.e[1], row.component, row.offset, row.turned, row.d, one, other)
    if row.kind == ACROSS:
        for i in range(3):
            rate, change = _axis_rates(row, 0, one, i)
            other_rate, other_change = _axis_rates(row, 1, other, i)
            total += change * row.e[1, i] + 2.0 * rate * other_rate + row.e[0, i] * other_change
        return -total
    factor = row.factor if row.kind == ALONG else 1.0
    if row.kind == ALONG:
        side = row.component
        for i in range(3):
            rate, change = _axis_rates(row, side, one if side == 0 else other, i)
            velocity = other.x[1, i] - factor * one.x[1, i]
            acceleration = other.x[2, i] - factor * one.x[2, i]
            total += acceleration * row.e[side, i] + 2.0 * velocity * rate + row.d[i] * change
        return -total
    square, speed, along = dot(row.d, row.d), 0.0, 0.0
    for i in range(3):
        velocity = other.x[1, i] - one.x[1, i]
        total += row.d[i] * (other.x[2, i] - one.x[2, i])
        speed += velocity * velocity
        along += row.d[i] * velocity
    return -(total + speed - along * along / square) / np.sqrt(square)
