"""Points of bodies, of cables and of the ground: where they are, how they move, and their Jacobians.

Those that most scenes do not have, on trees or sliding along cables, are called by address.
"""

import numpy as np

from ..arrays import record_type
from ..called_system import of_parts
from ..compiled import inlined, protocol
from ..lowered import VECTOR

FIXED, ON_BODY, ON_CABLE, FRAME_OF_CABLE, COORDINATE, ANGLE, ON_LINK = range(7)
MOST = 12  # coordinates of a point: those of two nodes in space

POINT = record_type(
    [
        ("kind", np.int64),
        ("body", np.int64),  # its number among the bodies, or links
        ("first", np.int64),  # coordinate among all of the scene
        ("width", np.int64),  # number of coordinates
        ("dimension", np.int64),  # of a cable
        ("axis", np.int64),  # of an angle: 0, 1, 2
        ("local", np.float64, (3,)),  # in the frame of a body, link or cable; what is added to a coordinate
        ("weights", np.float64, (4,)),  # of positions and slopes of a cable's nodes in the point on its axis
        ("slope_weights", np.float64, (4,)),  # in the slope there
        ("x", np.float64, (3, 3)),  # position, velocity, and acceleration with that of the coordinates zero
        ("orientation", np.float64, (3, 3)),
        ("spin", np.float64, (3,)),  # angular velocity
        ("spin_rate", np.float64, (3,)),  # its rate, with accelerations of the coordinates zero
        ("along", np.float64, (3, MOST)),  # of the velocity by those of the coordinates
        ("about", np.float64, (3, MOST)),  # of the angular velocity
    ]
)
"""A point with its frame; all in the global frame."""


@inlined
def cross(a, b, i):
    """Component i of a x b."""
    j, k = (i + 1) % 3, (i + 2) % 3
    return a[j] * b[k] - a[k] * b[j]


@inlined
def cross_product(a, b):
    """a x b."""
    return cross(a, b, 0), cross(a, b, 1), cross(a, b, 2)


@inlined
def dot(a, b):
    """a . b of (3,) vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def swing(spin, rate, arm, i):
    """Component i of w x (w x r) + w_t x r."""
    j, k = (i + 1) % 3, (i + 2) % 3
    along = spin[0] * arm[0] + spin[1] * arm[1] + spin[2] * arm[2]
    square = spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2
    return spin[i] * along - square * arm[i] + rate[j] * arm[k] - rate[k] * arm[j]


@inlined
def _place_on_body(point, body, q):
    turn, dim = body.orientation, body.translations
    for i in range(3):
        arm = 0.0
        for j in range(3):
            point.orientation[i, j] = turn[i, j]
            arm += turn[i, j] * point.local[j]
        point.x[2, i] = arm  # until `_move_on_body` sets it
        point.x[0, i] = arm + body.reference[i] + (q[body.first + i] if i < dim else 0.0)
    arm = point.x[2]
    for k in range(body.rotations):
        for i in range(3):
            about = 0.0
            for j in range(3):
                about += turn[i, j] * body.rates[j, k]
            point.about[i, dim + k] = about
        for i in range(3):
            j, m = (i + 1) % 3, (i + 2) % 3
            point.along[i, dim + k] = point.about[j, dim + k] * arm[m] - point.about[m, dim + k] * arm[j]


@inlined
def _move_on_body(point, body, v):
    """Velocity and w x (w x r) + w_t x r."""
    turn = body.orientation
    for i in range(3):
        spin, rate, velocity = 0.0, 0.0, 0.0
        for j in range(3):
            spin += turn[i, j] * body.spin[j]
            rate += turn[i, j] * body.bias[j]
        for k in range(point.width):
            velocity += point.along[i, k] * v[point.first + k]
        point.spin[i], point.spin_rate[i], point.x[1, i] = spin, rate, velocity
    x, y, z = 0.0, 0.0, 0.0
    for j in range(3):
        x += turn[0, j] * point.local[j]
        y += turn[1, j] * point.local[j]
        z += turn[2, j] * point.local[j]
    for i in range(3):
        point.x[2, i] = swing(point.spin, point.spin_rate, (x, y, z), i)


@inlined
def angle_about(turn, axis):
    """One of the angles a, b, c of turn (3, 3) = R_x(a) R_y(b) R_z(c) [rad]."""
    if axis == 0:
        return np.arctan2(-turn[1, 2], turn[2, 2])
    if axis == 1:
        return np.arctan2(turn[0, 2], np.sqrt(turn[1, 2] ** 2 + turn[2, 2] ** 2))
    return np.arctan2(-turn[0, 1], turn[0, 0])


@inlined
def _place_angle(point, body):
    """Its rate is the angular velocity about the global axis (CMarkerNodeRotationCoordinate.cpp)."""
    turn = body.orientation[point.axis]
    point.x[0, 0] = angle_about(body.orientation, point.axis)
    for k in range(body.rotations):
        point.along[0, k] = dot(turn, body.rates[:, k])


@inlined
def _move_angle(point, body):
    turn = body.orientation[point.axis]
    point.x[1, 0], point.x[2, 0] = dot(turn, body.spin), dot(turn, body.bias)


@inlined
def _combine(point, q, order):
    """Weighted sum of the coordinates (or of their velocities) of a point on a cable."""
    dim = point.dimension
    for i in range(dim):
        total = 0.0
        for k in range(4):
            if k * dim < point.width:
                total += point.weights[k] * q[point.first + k * dim + i]
        point.x[order, i] = total


@inlined
def _slope_of(point, q):
    """Slope at a point of a planar cable, or its rate."""
    x, y = 0.0, 0.0
    for k in range(4):
        if 2 * k < point.width:
            x += point.slope_weights[k] * q[point.first + 2 * k]
            y += point.slope_weights[k] * q[point.first + 2 * k + 1]
    return x, y


@inlined
def _place_frame(point, q):
    """The frame of a planar cable follows its slope: r + local_y n."""
    x, y = _slope_of(point, q)
    square = x * x + y * y
    norm = np.sqrt(square)
    turn, off = point.orientation, point.local[1]
    turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = x / norm, -y / norm, y / norm, x / norm
    for i in range(2):
        point.x[0, i] += off * turn[i, 1]
    for k in range(4):
        if 2 * k < point.width:
            for j in range(2):
                about = point.slope_weights[k] * turn[j, 1] / norm
                point.about[2, 2 * k + j] = about
                for i in range(2):
                    on_axis = point.weights[k] if i == j else 0.0
                    point.along[i, 2 * k + j] = on_axis - off * turn[i, 0] * about


@inlined
def _move_frame(point, q, v):
    """w = s x s_t / s^2 and its rate with s_tt = 0; n_t = -w t."""
    x, y = _slope_of(point, q)
    u, w = _slope_of(point, v)
    square = x * x + y * y
    spin = (x * w - y * u) / square
    rate = -2.0 * spin * (x * u + y * w) / square
    point.spin[2], point.spin_rate[2] = spin, rate
    turn, off = point.orientation, point.local[1]
    for i in range(2):
        point.x[1, i] -= off * spin * turn[i, 0]
        point.x[2, i] = -off * (rate * turn[i, 0] + spin**2 * turn[i, 1])


@inlined
def _weighted_sum(point, q):
    total = 0.0
    for k in range(point.width):
        total += point.along[0, k] * q[point.first + k]
    return total


@inlined
def place_points(points, bodies, q):
    """Positions, orientations and Jacobians at q (n,), but of links; the bodies are placed."""
    for p in range(len(points)):
        point = points[p]
        if point.kind == ON_BODY:
            _place_on_body(point, bodies[point.body], q)
        elif point.kind == COORDINATE:
            point.x[0, 0] = point.local[0] + _weighted_sum(point, q)
        elif point.kind == ANGLE:
            _place_angle(point, bodies[point.body])
        elif point.kind == ON_CABLE or point.kind == FRAME_OF_CABLE:
            _combine(point, q, 0)
            if point.kind == FRAME_OF_CABLE:
                _place_frame(point, q)


@inlined
def move_points(points, bodies, q, v):
    """Velocities at v (n,), and what accelerations are with those of the coordinates zero."""
    for p in range(len(points)):
        point = points[p]
        if point.kind == ON_BODY:
            _move_on_body(point, bodies[point.body], v)
        elif point.kind == COORDINATE:
            point.x[1, 0] = _weighted_sum(point, v)
        elif point.kind == ANGLE:
            _move_angle(point, bodies[point.body])
        elif point.kind == ON_CABLE or point.kind == FRAME_OF_CABLE:
            _combine(point, v, 1)
            if point.kind == FRAME_OF_CABLE:
                _move_frame(point, q, v)


@inlined
def add_wrench(point, wrench, sign, force):
    """Add the generalised force of a force and a torque, wrench (6,), times the sign.   force: (n,)."""
    for k in range(point.width):
        total = 0.0
        for i in range(3):
            total += point.along[i, k] * wrench[i] + point.about[i, k] * wrench[3 + i]
        force[point.first + k] += sign * total


@inlined
def add_torque(point, torque, force):
    """Add the generalised force of a torque (3,) alone.   force: (n,)."""
    for k in range(point.width):
        force[point.first + k] += dot(point.about[:, k], torque)


@protocol
def place_rare_points(system, q):
    """Places, frames and Jacobians at q (n,), and what the points are on; all other points are placed."""


@protocol
def move_rare_points(system, q, v):
    """Velocities at (q, v), (n,) each, accelerations with those of the coordinates zero; all others move."""


of_parts(place_rare_points, VECTOR)
of_parts(move_rare_points, VECTOR, VECTOR)
