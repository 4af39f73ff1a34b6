"""Rigid bodies, whose mass matrices are constant in their frames; trees of links, see `trees`.

With the orientation A, the angular velocity w = G p_t in the frame of the body, and T with G T = 1,

    [m, S^T; S, J] [A^T a; G p_tt + G_t p_t] = [A^T f; T^T Q] - [-w x S w; w x J w],    S x = m b x x,

for a force f and generalised forces Q on the rotational coordinates p; b is the centre of mass. Euler
parameters keep |p| = 1: A, G and T are those of unit quaternions, and p . p_tt is given.
"""

import numpy as np

from ..arrays import record_type
from ..compiled import inlined

MOST = 7  # coordinates of a body

BODY = record_type(
    [
        ("first", np.int64),  # coordinate among all of the scene
        ("translations", np.int64),  # coordinates: 1, 2 or 3; up to 7 of what does not turn
        ("rotations", np.int64),  # coordinates: 0, 1 (angle about z), 3 (angles x, y, z) or 4 (quaternion)
        ("reference", np.float64, (MOST,)),
        ("mass", np.float64, (MOST, MOST)),  # in its frame; of what does not turn, of its coordinates
        ("inverse", np.float64, (MOST, MOST)),  # of it, zero for directions in which it cannot move
        ("orientation", np.float64, (3, 3)),  # A
        ("rates", np.float64, (3, 4)),  # G
        ("inverse_rates", np.float64, (4, 3)),  # T
        ("spin", np.float64, (3,)),  # w in the frame of the body [rad/s]
        ("bias", np.float64, (MOST,)),  # G_t p_t [rad/s^2]; of what does not turn, see `trees`: h
        ("wrench", np.float64, (MOST,)),  # right-hand side, and what it is solved for
        ("normal", np.float64, (4,)),  # p of a quaternion over |p|^2
        ("target", np.float64),  # of p . p_tt, p . p_t or p . dp
        ("drift_correction", np.float64),  # what p . p_tt lacked in the last step
    ]
)


@inlined
def _set_orientation(body, rows):
    """`rows`: nine numbers."""
    for i in range(3):
        for j in range(3):
            body.orientation[i, j] = rows[3 * i + j]


@inlined
def _orient_by_quaternion(body, q):
    at = body.first + body.translations
    w = q[at] + body.reference[3]
    x = q[at + 1] + body.reference[4]
    y = q[at + 2] + body.reference[5]
    z = q[at + 3] + body.reference[6]
    _set_orientation(
        body,
        (
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ),
    )
    rows = (-x, w, z, -y, -y, -z, w, x, -z, y, -x, w)
    square = w * w + x * x + y * y + z * z
    for i in range(3):
        for j in range(4):
            body.rates[i, j] = 2.0 * rows[4 * i + j]
            body.inverse_rates[j, i] = 0.5 * rows[4 * i + j] / square


@inlined
def _orient_by_angles(body, q):
    at = body.first + body.translations
    a, b, c = q[at] + body.reference[3], q[at + 1] + body.reference[4], q[at + 2] + body.reference[5]
    sa, ca, sb, cb, sc, cc = np.sin(a), np.cos(a), np.sin(b), np.cos(b), np.sin(c), np.cos(c)
    _set_orientation(
        body,
        (
            cb * cc,
            -cb * sc,
            sb,
            ca * sc + sa * sb * cc,
            ca * cc - sa * sb * sc,
            -sa * cb,
            sa * sc - ca * sb * cc,
            sa * cc + ca * sb * sc,
            ca * cb,
        ),
    )
    rates = (cb * cc, sc, 0.0, -cb * sc, cc, 0.0, sb, 0.0, 1.0)
    inverse = (cc / cb, -sc / cb, 0.0, sc, cc, 0.0, -sb * cc / cb, sb * sc / cb, 1.0)
    for i in range(3):
        for j in range(3):
            body.rates[i, j], body.inverse_rates[i, j] = rates[3 * i + j], inverse[3 * i + j]


@inlined
def _orient_in_plane(body, q):
    angle = q[body.first + body.translations] + body.reference[3]
    s, c = np.sin(angle), np.cos(angle)
    _set_orientation(body, (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0))


@inlined
def place_body(body, q):
    """A, G and T at the coordinates q (n,) of the scene."""
    if body.rotations == 4:
        _orient_by_quaternion(body, q)
    elif body.rotations == 3:
        _orient_by_angles(body, q)
    elif body.rotations == 1:
        _orient_in_plane(body, q)


@inlined
def set_normal(body):
    """The direction in which the norm of a quaternion changes, for all that follows; the body is placed."""
    if body.rotations == 4:
        rates = body.rates
        values = (0.5 * rates[0, 1], -0.5 * rates[0, 0], -0.5 * rates[0, 3], 0.5 * rates[0, 2])
        square = values[0] ** 2 + values[1] ** 2 + values[2] ** 2 + values[3] ** 2
        for i in range(4):
            body.normal[i] = values[i] / square


@inlined
def move_body(body, q, v):
    """w and G_t p_t at the velocities v (n,) of the scene; the body is placed at q (n,)."""
    at = body.first + body.translations
    for i in range(3):
        spin = 0.0
        for j in range(body.rotations):
            spin += body.rates[i, j] * v[at + j]
        body.spin[i] = spin
    if body.rotations == 3:
        b, c = q[at + 1] + body.reference[4], q[at + 2] + body.reference[5]
        sb, cb, sc, cc = np.sin(b), np.cos(b), np.sin(c), np.cos(c)
        u, w, z = v[at], v[at + 1], v[at + 2]
        body.bias[0] = -sb * cc * w * u - cb * sc * z * u + cc * z * w
        body.bias[1] = sb * sc * w * u - cb * cc * z * u - sc * z * w
        body.bias[2] = cb * w * u


@inlined
def _take_wrench(body, force):
    """A^T f and T^T Q of generalised forces that begin at force[0]."""
    number = body.translations
    for i in range(3):
        along, about = 0.0, 0.0
        for j in range(number):
            along += body.orientation[j, i] * force[j]
        for j in range(body.rotations):
            about += body.inverse_rates[j, i] * force[number + j]
        body.wrench[i], body.wrench[3 + i] = along, about


@inlined
def _subtract_gyroscopic(body):
    """w x S w to the force, -w x J w to the torque."""
    spin, mass, wrench = body.spin, body.mass, body.wrench
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        static_j, static_k, spin_j, spin_k = 0.0, 0.0, 0.0, 0.0
        for m in range(3):
            static_j += mass[3 + j, m] * spin[m]
            static_k += mass[3 + k, m] * spin[m]
            spin_j += mass[3 + j, 3 + m] * spin[m]
            spin_k += mass[3 + k, 3 + m] * spin[m]
        wrench[i] += spin[j] * static_k - spin[k] * static_j
        wrench[3 + i] -= spin[j] * spin_k - spin[k] * spin_j


@inlined
def _solve(body, biased, result):
    """[A; T] of the inverse mass times the wrench; `biased`: less G_t p_t.   result: from [0] on."""
    number = body.translations
    inverse, wrench = body.inverse, body.wrench
    for i in range(number):
        total = 0.0
        for j in range(3):
            local = 0.0
            for m in range(6):
                local += inverse[j, m] * wrench[m]
            total += body.orientation[i, j] * local
        result[i] = total
    for i in range(body.rotations):
        result[number + i] = 0.0
    for j in range(3):
        local = -body.bias[j] if biased else 0.0
        for m in range(6):
            local += inverse[3 + j, m] * wrench[m]
        for i in range(body.rotations):
            result[number + i] += body.inverse_rates[i, j] * local


@inlined
def _multiply(matrix, size, x, result):
    """(size,) of the first rows and columns of a matrix."""
    for i in range(size):
        total = 0.0
        for j in range(size):
            total += matrix[i, j] * x[j]
        result[i] = total


@inlined
def accelerate_body(body, force, acceleration):
    """Acceleration under generalised forces and the target; both (k,) of the body alone."""
    if body.rotations == 0:
        for i in range(body.translations):
            body.wrench[i] = force[i] - body.bias[i]
        _multiply(body.inverse, body.translations, body.wrench, acceleration)
        return
    _take_wrench(body, force)
    _subtract_gyroscopic(body)
    _solve(body, True, acceleration)
    add_lever(body, acceleration)


@inlined
def subtract_inertia(body, force):
    """Take off the generalised forces of the motion at zero second derivatives of the coordinates.

    force: (k,) of the body alone, which is placed and moves.
    """
    if body.rotations == 0:
        for i in range(body.translations):
            force[i] += body.bias[i]
        return
    for i in range(6):
        body.wrench[i] = 0.0
    _subtract_gyroscopic(body)
    for i in range(6):
        for j in range(3):
            body.wrench[i] -= body.mass[i, 3 + j] * body.bias[j]
    for j in range(3):
        for i in range(body.translations):
            force[i] -= body.orientation[i, j] * body.wrench[j]
        for i in range(body.rotations):
            force[body.translations + i] -= body.rates[j, i] * body.wrench[3 + j]


@inlined
def respond_body(body, force, response):
    """Acceleration under generalised forces alone; both (k,)."""
    if body.rotations == 0:
        _multiply(body.inverse, body.translations, force, response)
        return
    _take_wrench(body, force)
    _solve(body, False, response)


@inlined
def add_lever(body, x):
    """x += p target / |p|^2 for a quaternion.   x: (k,) of the body alone."""
    if body.rotations == 4:
        for i in range(4):
            x[body.translations + i] += body.normal[i] * body.target


@inlined
def _norm_rate(body, v):
    """p . v over |p|^2, for v (k,) of the body alone."""
    total = 0.0
    for i in range(4):
        total += body.normal[i] * v[body.translations + i]
    return total


@inlined
def _square(body):
    """|p|^2."""
    total = 0.0
    for i in range(4):
        total += body.normal[i] * body.normal[i]
    return 1.0 / total


@inlined
def aim_at_acceleration(body, v, zeta):
    """p . p_tt = -p_t . p_t - zeta p . p_t, and what earlier steps taught.   v: (k,) of the body alone."""
    if body.rotations == 4:
        speed = 0.0
        for i in range(4):
            speed += v[body.translations + i] ** 2
        body.target = -speed - zeta * _norm_rate(body, v) * _square(body) + body.drift_correction


@inlined
def aim_at_velocity(body, v, zeta):
    """p . dv = -zeta (|p|^2 - 1) / 2 - p . v.   v: (k,) of the body alone."""
    if body.rotations == 4:
        square = _square(body)
        body.target = -zeta * 0.5 * (square - 1.0) - _norm_rate(body, v) * square


@inlined
def aim_at_place(body, q, learning):
    """p . dp = -c, c = (|p|^2 - 1) / 2 at q (n,) of the scene, which teaches the next steps; returns |c|."""
    if body.rotations != 4:
        return 0.0
    at, square = body.first + body.translations, 0.0
    for i in range(4):
        square += (q[at + i] + body.reference[3 + i]) ** 2
    body.target = 0.5 * (1.0 - square)
    body.drift_correction += learning * body.target
    return abs(body.target)


@inlined
def twice_energy(body, v):
    """Of velocities v (k,) of the body alone, twice its kinetic energy [J]; the body is placed."""
    moving, total = body.wrench, 0.0
    for i in range(MOST):
        moving[i] = v[i] if body.rotations == 0 and i < body.translations else 0.0
    for i in range(3 if body.rotations > 0 else 0):
        for j in range(body.translations):
            moving[i] += body.orientation[j, i] * v[j]
        for j in range(body.rotations):
            moving[3 + i] += body.rates[i, j] * v[body.translations + j]
    for i in range(MOST):
        for j in range(MOST):
            total += moving[i] * body.mass[i, j] * moving[j]
    return total
