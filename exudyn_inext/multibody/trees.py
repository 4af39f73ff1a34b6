"""Kinematic trees: links with one joint each, whose coordinate they have; all of a tree are one body.

With the Jacobians J and J_w of the centre of mass of a link and of its angular velocity w, its inertia I
about that centre, and the parts a_0 and w_0 of its accelerations with those of the coordinates zero,

    M q_tt = f - h,    M = sum of m J^T J + J_w^T I J_w,    h = sum of J^T m a_0 + J_w^T (I w_0 + w x I w).

See Exudyn's ObjectKinematicTree.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import record_type
from ..called_system import implements
from ..compiled import inlined
from .bodies import MOST
from .points import ON_LINK, cross, move_rare_points, place_rare_points, swing

LINK = record_type(
    [
        ("body", np.int64),  # number of its tree's record
        ("first", np.int64),  # coordinate of the tree among all of the scene
        ("width", np.int64),  # number of them
        ("own", np.int64),  # which of them is that of its joint
        ("parent", np.int64),  # its record, before this one
        ("slides", np.bool_),  # along the axis of its joint; otherwise it turns about it
        ("axis", np.int64),  # of the joint: 0, 1, 2
        ("turn", np.float64, (3, 3)),  # the joint's frame in that of the parent
        ("offset", np.float64, (3,)),  # of the joint from the parent's centre of mass, in the parent's frame
        ("centre", np.float64, (3,)),  # of mass, from the joint
        ("reference", np.float64),  # what is added to the coordinate
        ("mass", np.float64),
        ("inertia", np.float64, (3, 3)),  # about the centre of mass
        ("arms", np.float64, (2, 3)),  # from the parent's centre to the joint, and on to the link's
        ("direction", np.float64, (3,)),  # of the axis
        ("turned", np.float64, (3, 3)),  # I in the global frame
        ("x", np.float64, (2, 3)),  # the centre of mass, and a_0
        ("orientation", np.float64, (3, 3)),
        ("spin", np.float64, (3,)),  # w
        ("spin_rate", np.float64, (3,)),  # w_0
        ("along", np.float64, (3, MOST)),  # J
        ("about", np.float64, (3, MOST)),  # J_w
    ]
)
"""A link with its frame at present; the first record is the ground."""


class Trees(NamedTuple):
    """records: links, the first one of them the ground.   bodies, points: records of the scene."""

    records: Any
    bodies: Any
    points: Any


@inlined
def _product(a, b, i, j):
    return a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@inlined
def _place(link, links, q):
    """Its frame, and that of its joint; the parent is placed."""
    parent, axis = links[link.parent], link.axis
    turn = link.turned  # memory: the joint's frame
    for i in range(3):
        arm = 0.0
        for j in range(3):
            turn[i, j] = _product(parent.orientation, link.turn, i, j)
            arm += parent.orientation[i, j] * link.offset[j]
        link.arms[0, i] = arm
    angle = q[link.first + link.own] + link.reference
    way = angle if link.slides else 0.0
    c, s = (1.0, 0.0) if link.slides else (np.cos(angle), np.sin(angle))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    for i in range(3):
        link.direction[i] = link.orientation[i, axis] = turn[i, axis]
        link.orientation[i, j] = c * turn[i, j] + s * turn[i, k]
        link.orientation[i, k] = c * turn[i, k] - s * turn[i, j]
        link.arms[0, i] += way * turn[i, axis]
    for i in range(3):
        lever = 0.0
        for m in range(3):
            lever += link.orientation[i, m] * link.centre[m]
        link.arms[1, i] = lever
        link.x[0, i] = parent.x[0, i] + link.arms[0, i] + lever


@inlined
def _set_jacobians(link, links):
    parent = links[link.parent]
    for k in range(link.width):
        is_own = k == link.own
        for i in range(3):
            link.about[i, k] = parent.about[i, k] + (link.direction[i] if is_own and not link.slides else 0.0)
        for i in range(3):
            along = parent.along[i, k] + (link.direction[i] if is_own and link.slides else 0.0)
            along += cross(parent.about[:, k], link.arms[0], i) + cross(link.about[:, k], link.arms[1], i)
            link.along[i, k] = along


@inlined
def _turn_inertia(link):
    turn = link.orientation
    for i in range(3):
        for j in range(3):
            total = 0.0
            for m in range(3):
                for n in range(3):
                    total += turn[i, m] * link.inertia[m, n] * turn[j, n]
            link.turned[i, j] = total


@inlined
def _add_mass(link, mass):
    for k in range(link.width):
        for m in range(link.width):
            total = 0.0
            for i in range(3):
                total += link.mass * link.along[i, k] * link.along[i, m]
                for j in range(3):
                    total += link.about[i, k] * link.turned[i, j] * link.about[j, m]
            mass[k, m] += total


@inlined
def _invert(matrix, size, inverse):
    """A positive definite matrix, by Gauss-Jordan elimination in place."""
    for i in range(size):
        for j in range(size):
            inverse[i, j] = matrix[i, j]
    for p in range(size):
        pivot = 1.0 / inverse[p, p]
        inverse[p, p] = 1.0
        for j in range(size):
            inverse[p, j] *= pivot
        for i in range(size):
            if i != p:
                multiple = inverse[i, p]
                inverse[i, p] = 0.0
                for j in range(size):
                    inverse[i, j] -= multiple * inverse[p, j]


@inlined
def _place_links(links, bodies, q):
    """Frames, Jacobians, and the masses of trees at q (n,)."""
    for number in range(1, len(links)):
        link = links[number]
        body = bodies[link.body]
        if link.own == 0:
            for i in range(link.width):
                for j in range(link.width):
                    body.mass[i, j] = 0.0
        _place(link, links, q)
        _set_jacobians(link, links)
        _turn_inertia(link)
        _add_mass(link, body.mass)
        if link.own == link.width - 1:
            _invert(body.mass, link.width, body.inverse)


@inlined
def _move(link, links, v):
    """w, w_0 and a_0; the parent moves."""
    parent, speed = links[link.parent], v[link.first + link.own]
    sliding = speed if link.slides else 0.0
    turning = speed - sliding
    for i in range(3):
        coriolis = cross(parent.spin, link.direction, i)
        link.spin[i] = parent.spin[i] + turning * link.direction[i]
        link.spin_rate[i] = parent.spin_rate[i] + turning * coriolis
        link.x[1, i] = parent.x[1, i] + 2.0 * sliding * coriolis
    for i in range(3):
        link.x[1, i] += swing(parent.spin, parent.spin_rate, link.arms[0], i)
        link.x[1, i] += swing(link.spin, link.spin_rate, link.arms[1], i)


@inlined
def _generalised(link, force, torque, k):
    """Component k of J^T force + J_w^T torque."""
    total = 0.0
    for i in range(3):
        total += link.along[i, k] * force[i] + link.about[i, k] * torque[i]
    return total


@inlined
def _inertia_moment(link, i):
    """Component i of I w_0 + w x I w."""
    j, m = (i + 1) % 3, (i + 2) % 3
    rate, at_j, at_m = 0.0, 0.0, 0.0
    for n in range(3):
        rate += link.turned[i, n] * link.spin_rate[n]
        at_j += link.turned[j, n] * link.spin[n]
        at_m += link.turned[m, n] * link.spin[n]
    return rate + link.spin[j] * at_m - link.spin[m] * at_j


@inlined
def _move_links(links, bodies, v):
    """Rates, and h of trees, at the velocities v (n,); the links are placed."""
    for number in range(1, len(links)):
        link = links[number]
        bias = bodies[link.body].bias
        if link.own == 0:
            for k in range(link.width):
                bias[k] = 0.0
        _move(link, links, v)
        a, mass = link.x[1], link.mass
        force = (mass * a[0], mass * a[1], mass * a[2])
        moment = (_inertia_moment(link, 0), _inertia_moment(link, 1), _inertia_moment(link, 2))
        for k in range(link.width):
            bias[k] += _generalised(link, force, moment, k)


@inlined
def _place_on_link(point, link):
    turn, x, y, z = link.orientation, point.local[0], point.local[1], point.local[2]
    for i in range(3):
        arm = turn[i, 0] * x + turn[i, 1] * y + turn[i, 2] * z
        point.x[2, i] = arm  # until `_move_on_link` sets it
        point.x[0, i] = link.x[0, i] + arm
        for j in range(3):
            point.orientation[i, j] = turn[i, j]
    for k in range(link.width):
        for i in range(3):
            point.about[i, k] = link.about[i, k]
            point.along[i, k] = link.along[i, k] + cross(link.about[:, k], point.x[2], i)


@implements(place_rare_points, Trees)
def place_trees(trees, q):
    """Frames and masses of links, and points on them, `local` from the centre of mass."""
    links, points = trees.records, trees.points
    _place_links(links, trees.bodies, q)
    for p in range(len(points)):
        if points[p].kind == ON_LINK:
            _place_on_link(points[p], links[points[p].body])


@inlined
def _move_on_link(point, link, v):
    for i in range(3):
        velocity = 0.0
        for k in range(point.width):
            velocity += point.along[i, k] * v[point.first + k]
        point.x[1, i], point.spin[i], point.spin_rate[i] = velocity, link.spin[i], link.spin_rate[i]
    at, centre = point.x[0], link.x[0]
    arm = (at[0] - centre[0], at[1] - centre[1], at[2] - centre[2])
    for i in range(3):
        point.x[2, i] = link.x[1, i] + swing(link.spin, link.spin_rate, arm, i)


@implements(move_rare_points, Trees)
def move_trees(trees, q, v):
    """Rates of links, h, and points on them."""
    links, points = trees.records, trees.points
    _move_links(links, trees.bodies, v)
    for p in range(len(points)):
        if points[p].kind == ON_LINK:
            _move_on_link(points[p], links[points[p].body], v)
