"""Springs and dampers between two points: a force and a torque on both.

SPRING     along the distance, k (L - L_0) + d (L_t - v_0) + f
CARTESIAN  in the global frame, K (d - o) + D d_t
SIX        in the frame of the first point: distances and angles about x, y and z

An angle about z with a place among the data of a scene goes on from the last one that these keep, beyond half
a turn: see Exudyn's ObjectConnectorTorsionalSpringDamper with a nodeNumber.
"""

import numpy as np

from ..arrays import record_type
from ..compiled import inlined
from .circle_contacts import NOW
from .points import add_wrench, angle_about

SPRING, CARTESIAN, SIX = range(3)

CONNECTOR = record_type(
    [
        ("kind", np.int64),
        ("points", np.int64, (2,)),
        ("place", np.int64),  # of its last angle about z among the data of the scene; -1: it keeps none
        ("stiffness", np.float64, (6, 6)),
        ("damping", np.float64, (6, 6)),
        ("offset", np.float64, (6,)),
        ("rate_offset", np.float64, (6,)),
        ("force", np.float64, (6,)),  # constant, in the frame of the law
        ("turns", np.float64, (2, 3, 3)),  # of the law's frames in those of both points
        ("wrench", np.float64, (6,)),
        ("stretch", np.float64, (6,)),
        ("rate", np.float64, (6,)),
        ("frame", np.float64, (3, 3, 3)),  # A_0, A_1 and A_0^T A_1 at present
    ]
)


@inlined
def _multiply(left, right, result, transposed):
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += (left[k, i] if transposed else left[i, k]) * right[k, j]
            result[i, j] = total


@inlined
def _set_frames(connector, one, other):
    frame = connector.frame
    _multiply(one.orientation, connector.turns[0], frame[0], False)
    _multiply(other.orientation, connector.turns[1], frame[1], False)
    _multiply(frame[0], frame[1], frame[2], True)


@inlined
def _stretch_in_frame(connector, one, other):
    """Distances and angles in the frame of the first point, and their rates."""
    _set_frames(connector, one, other)
    frame, relative = connector.frame[0], connector.frame[2]
    for i in range(3):
        connector.stretch[i], connector.rate[i], connector.rate[3 + i] = 0.0, 0.0, 0.0
        for j in range(3):
            connector.stretch[i] += frame[j, i] * (other.x[0, j] - one.x[0, j])
            connector.rate[i] += frame[j, i] * (other.x[1, j] - one.x[1, j])
            connector.rate[3 + i] += frame[j, i] * (other.spin[j] - one.spin[j])
    for axis in range(3):
        connector.stretch[3 + axis] = angle_about(relative, axis)


@inlined
def _count_turns(connector, data, settles):
    """The angle about z that is nearest to the last one.   settles: whether it becomes the last one."""
    around = 2.0 * np.pi
    turns = np.floor((data[NOW, connector.place] - connector.stretch[5]) / around + 0.5)
    connector.stretch[5] += turns * around
    if settles:
        data[NOW, connector.place] = connector.stretch[5]


@inlined
def _apply_law(connector):
    """Into the wrench, in the frame of the law."""
    for i in range(6):
        total = connector.force[i]
        for j in range(6):
            total += connector.stiffness[i, j] * (connector.stretch[j] - connector.offset[j])
            total += connector.damping[i, j] * (connector.rate[j] - connector.rate_offset[j])
        connector.wrench[i] = total


@inlined
def _turn_wrench(connector):
    """From the frame of the first point to the global one."""
    frame, wrench = connector.frame[0], connector.wrench
    for half in range(2):
        at = 3 * half
        x, y, z = wrench[at], wrench[at + 1], wrench[at + 2]
        for i in range(3):
            wrench[at + i] = frame[i, 0] * x + frame[i, 1] * y + frame[i, 2] * z


@inlined
def _set_spring_force(connector, one, other):
    square, along = 0.0, 0.0
    for i in range(3):
        distance = other.x[0, i] - one.x[0, i]
        square += distance * distance
        along += distance * (other.x[1, i] - one.x[1, i])
    length = np.sqrt(square)
    force = connector.stiffness[0, 0] * (length - connector.offset[0])
    force += connector.damping[0, 0] * (along / length - connector.rate_offset[0]) + connector.force[0]
    for i in range(3):
        connector.wrench[i] = force / length * (other.x[0, i] - one.x[0, i])


@inlined
def _set_wrench(connector, one, other, data, settles):
    """What the points pull each other with."""
    if connector.kind == SPRING:
        _set_spring_force(connector, one, other)
        return
    if connector.kind == SIX:
        _stretch_in_frame(connector, one, other)
        if connector.place >= 0:
            _count_turns(connector, data, settles)
    else:
        for i in range(3):
            connector.stretch[i] = other.x[0, i] - one.x[0, i]
            connector.rate[i] = other.x[1, i] - one.x[1, i]
    _apply_law(connector)
    if connector.kind == SIX:
        _turn_wrench(connector)


@inlined
def add_connectors(connectors, points, data, settles, force):
    """Add the generalised forces of all connectors to force (n,); the points are placed and move.

    data: see `Contacts`.   settles: whether they are brought up to date.
    """
    for c in range(len(connectors)):
        connector = connectors[c]
        one, other = points[connector.points[0]], points[connector.points[1]]
        _set_wrench(connector, one, other, data, settles)
        add_wrench(one, connector.wrench, 1.0, force)
        add_wrench(other, connector.wrench, -1.0, force)
