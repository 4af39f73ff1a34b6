"""Springs and dampers between two points: a force and a torque on both.

SPRING     along the distance, k (L - L_0) + d (L_t - v_0) + f
CARTESIAN  in the global frame, K (d - o) + D d_t
SIX        in the frame of the first point: distances and angles about x, y and z
RUBBING    of coordinates with factors, f_1 q_1 - f_0 q_0, which rub and have stops, see `rubbing_springs`
INTRINSIC  in the frame half way between both: the screw, log(A_0^T A_1), that leads from one to the other

An angle about z with a place among the data of a scene goes on from the last one that these keep, beyond half
a turn: see Exudyn's ObjectConnectorTorsionalSpringDamper with a nodeNumber.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, record_type
from ..called_system import implements, of_parts
from ..compiled import inlined, protocol
from ..lowered import COUNT, VECTOR
from .circle_contacts import NOW
from .points import add_torque, add_wrench, angle_about, cross, dot
from .rubbing_springs import BEYOND, SLIDES, force_of_rubbing

SPRING, CARTESIAN, SIX, INTRINSIC, RUBBING = range(5)
ROUNDING = 1e-12

CONNECTOR = record_type(
    [
        ("kind", np.int64),
        ("points", np.int64, (2,)),
        ("place", np.int64),  # of what it keeps among the data of the scene, first; -1: it keeps nothing
        ("asked", np.int64, (6,)),  # whether a function is the law along an axis, see `spring_functions`
        ("stiffness", np.float64, (6, 6)),
        ("damping", np.float64, (6, 6)),
        ("directions", np.float64, (12, 6)),  # see `principal_directions`, in the frame of the law
        ("splits", np.int64),  # whether the last ones are those of the damping
        ("offset", np.float64, (6,)),
        ("rate_offset", np.float64, (6,)),
        ("force", np.float64, (6,)),  # constant, in the frame of the law
        ("factors", np.float64, (2,)),  # of both points
        ("dynamic", np.float64),  # force of friction, as the other ones of `rubbing_springs`
        ("static", np.float64),  # beyond the dynamic one
        ("decay", np.float64),
        ("viscosity", np.float64),
        ("zone", np.float64),
        ("sticking_stiffness", np.float64),
        ("sticking_damping", np.float64),
        ("has_stops", np.int64),
        ("stops", np.float64, (2,)),
        ("stop_stiffness", np.float64),
        ("stop_damping", np.float64),
        ("turns", np.float64, (2, 3, 3)),  # of the law's frames in those of both points
        ("wrench", np.float64, (6,)),
        ("stretch", np.float64, (6,)),
        ("rate", np.float64, (6,)),
        ("frame", np.float64, (3, 3, 3)),  # that of the law, A_1 and A_0^T A_1 at present
        ("axis", np.float64, (3,)),  # of the screw, in its frame
        ("torque", np.float64, (3,)),  # of the force at half the way along the screw about both points
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
def _go_half_way(connector):
    """Turn the frame of the law by half of the angle between both points, which is set.

    Returns the length of an arc of that angle by its chord, a / sin(a) of half the angle a [-].
    """
    relative, axis = connector.frame[2], connector.axis
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        axis[i] = 0.5 * (relative[k, j] - relative[j, k])
    sine, cosine = np.sqrt(dot(axis, axis)), 0.5 * (relative[0, 0] + relative[1, 1] + relative[2, 2] - 1.0)
    half = 0.5 * np.arctan2(sine, cosine)
    if sine > 0.0:
        for i in range(3):
            axis[i] /= sine
    sine, cosine = np.sin(half), np.cos(half)
    for i in range(3):
        connector.stretch[3 + i] = 2.0 * half * axis[i]
        x, y, z = connector.frame[0, i]
        row = (x, y, z)
        along = (1.0 - cosine) * dot(row, axis)
        for j in range(3):
            connector.frame[0, i, j] = cosine * row[j] + sine * cross(row, axis, j) + along * axis[j]
    return half / sine if sine > 0.0 else 1.0


@inlined
def _set_screw(connector, arc):
    """The distances across the axis follow an arc, of that length by its chord."""
    along = (1.0 - arc) * dot(connector.axis, connector.stretch)
    for i in range(3):
        connector.stretch[i] = arc * connector.stretch[i] + along * connector.axis[i]


@inlined
def _set_torque(connector):
    """Of the force, which acts half way between the points, about these: the same one on both."""
    frame, stretch, force = connector.frame[0], connector.stretch, connector.wrench
    x, y, z = dot(frame[0], stretch), dot(frame[1], stretch), dot(frame[2], stretch)
    arm = (0.5 * x, 0.5 * y, 0.5 * z)
    for i in range(3):
        connector.torque[i] = cross(arm, force, i)


@inlined
def _set_stretch(connector, one, other):
    """Distances and angles in the frame of the law, and their rates."""
    _set_frames(connector, one, other)
    frame, relative = connector.frame[0], connector.frame[2]
    arc = _go_half_way(connector) if connector.kind == INTRINSIC else 1.0
    for i in range(3):
        connector.stretch[i], connector.rate[i], connector.rate[3 + i] = 0.0, 0.0, 0.0
        for j in range(3):
            connector.stretch[i] += frame[j, i] * (other.x[0, j] - one.x[0, j])
            connector.rate[i] += frame[j, i] * (other.x[1, j] - one.x[1, j])
            connector.rate[3 + i] += frame[j, i] * (other.spin[j] - one.spin[j])
    if connector.kind == INTRINSIC:
        _set_screw(connector, arc)
        return
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
    """From the frame of the law to the global one."""
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
    connector.stretch[0], connector.rate[0] = length, along / length
    force = connector.stiffness[0, 0] * (length - connector.offset[0])
    force += connector.damping[0, 0] * (connector.rate[0] - connector.rate_offset[0]) + connector.force[0]
    for i in range(3):
        connector.wrench[i] = force / length * (other.x[0, i] - one.x[0, i])


@inlined
def _set_rubbing_force(connector, one, other, data, settles):
    for order, found in enumerate((connector.stretch, connector.rate)):
        found[0] = connector.factors[1] * other.x[order, 0] - connector.factors[0] * one.x[order, 0]
    force = connector.stiffness[0, 0] * (connector.stretch[0] - connector.offset[0])
    force += connector.damping[0, 0] * (connector.rate[0] - connector.rate_offset[0])
    connector.wrench[0] = force + force_of_rubbing(connector, data, settles)


@inlined
def _set_wrench(connector, one, other, data, settles):
    """What the points pull each other with."""
    if connector.kind == SPRING:
        _set_spring_force(connector, one, other)
        return
    if connector.kind == RUBBING:
        _set_rubbing_force(connector, one, other, data, settles)
        return
    if connector.kind == CARTESIAN:
        for i in range(3):
            connector.stretch[i] = other.x[0, i] - one.x[0, i]
            connector.rate[i] = other.x[1, i] - one.x[1, i]
    else:
        _set_stretch(connector, one, other)
        if connector.place >= 0:
            _count_turns(connector, data, settles)
    _apply_law(connector)
    if connector.kind != CARTESIAN:
        _turn_wrench(connector)


def principal_directions(stiffness: Array, damping: Array) -> Array:
    """(2, k, k) unit vectors, in rows, along which these matrices (k, k) do not couple: of each of both.

    Axes where they do not.
    """
    laws = np.stack([stiffness, damping])
    vectors = np.swapaxes(np.linalg.eigh(0.5 * (laws + np.swapaxes(laws, 1, 2)))[1], 1, 2)
    return np.where(is_diagonal(laws)[:, np.newaxis, np.newaxis], np.eye(len(stiffness)), vectors)


def set_directions(record: Any) -> None:
    """Those of the record of a connector, which are of stiffness and damping at once if that may be."""
    laws = np.stack([record["stiffness"], record["damping"]])
    of_both = principal_directions(*laws)
    common = of_both[1 if is_diagonal(laws[0]) else 0]
    record["splits"] = int(not is_diagonal(common @ laws @ common.T).all())
    record["directions"] = np.concatenate(of_both if record["splits"] else [common, np.zeros((6, 6))])


def is_diagonal(matrices: Array) -> Any:
    """Whether matrices (..., k, k) are, but for rounding."""
    sizes = np.abs(matrices).max(axis=(-2, -1), keepdims=True)
    return (np.abs(matrices) * (1.0 - np.eye(matrices.shape[-1])) <= ROUNDING * sizes).all(axis=(-2, -1))


class Connectors(NamedTuple):
    """records: of all.   points, data: of the scene, see `Items`."""

    records: Any
    points: Any
    data: Array


@protocol
def add_connectors(connectors, settles, force):
    """Add the generalised forces of all connectors to force (n,); the points are placed and move.

    settles: whether data are brought up to date, 1 or 0.
    """


of_parts(add_connectors, COUNT, VECTOR)


@implements(add_connectors, Connectors)
def add_all_connectors(connectors, settles, force):
    points = connectors.points
    for c in range(len(connectors.records)):
        connector = connectors.records[c]
        one, other = points[connector.points[0]], points[connector.points[1]]
        _set_wrench(connector, one, other, connectors.data, settles)
        add_wrench(one, connector.wrench, connector.factors[0], force)
        add_wrench(other, connector.wrench, -connector.factors[1], force)
        if connector.kind == INTRINSIC:
            _set_torque(connector)
            add_torque(one, connector.torque, force)
            add_torque(other, connector.torque, force)


def places_of_rubbing(connectors: Any) -> np.ndarray:
    """Of how springs rub, and how far they are beyond stops, among the data of a scene."""
    rubs = (connectors["kind"] == RUBBING) & (connectors["place"] >= 0)
    return (connectors["place"][rubs, np.newaxis] + [SLIDES, BEYOND]).ravel()
