"""Springs and dampers that are implicit in the accelerations, as rows among those of joints that yield.

Along each principal direction n of a connector, with its damping d = n . D n, its stiffness k = n . K n and
the rate B v of its stretch,

    M a = F - B^T (f + W (B a - B a_before) + W_s (B a + B_t v)),   W = (1/2 + 1/16) h d,   W_s = 0.3 h^2 k,

the first one as of contact, see `implicit_contacts`: f is the force at the velocities that a_before predicts.
The second one acts on the rate of change of B v. With a quarter in place of 0.3, central differences become
the trapezoidal rule, which is stable for all k; the rest is a margin for what else acts there. The stretch of
steps that do not resolve the vibrations of a spring is then that of the forces on it, but for amplitudes
of 0.22 h times the velocities that it cannot follow. Both together are a row

    B a - mu / (W + W_s) = (W B a_before - W_s B_t v) / (W + W_s)

beside those of the joints, which yields by its `softness` 1 / (W + W_s). Where stiffness and damping have
other directions, there are rows of both: W beside the directions of the damping would delay what moves there.
"""

from typing import Any

import numpy as np

from ..compiled import inlined
from .circle_contacts import SHARE
from .connectors import CARTESIAN, ROUNDING, RUBBING, SPRING
from .joints import NONE
from .points import cross, dot
from .rows import DASHPOT, ROW

SMALLEST = 1e-300  # W of what is explicit, which makes its row as soft as can be
STIFF = 0.3  # of h^2 k


def rows_of_dashpots(connectors: Any) -> Any:
    """Records of the rows, one for each direction along which a connector damps or is stiff.

    Args:
        connectors: records.
    """
    to = connectors["directions"]
    laws = np.stack([connectors["stiffness"], connectors["damping"]])
    along = np.einsum("kni,lkij,knj->lkn", to, laws, to)
    acts = (along > ROUNDING * np.abs(laws).max(axis=(2, 3), initial=0.0)[:, :, np.newaxis]).any(axis=0)
    asked = connectors["asked"] > 0
    acts |= np.hstack([asked, asked & (connectors["splits"] > 0)[:, np.newaxis]])
    which, numbers = np.nonzero(acts)
    rows = np.zeros(len(which), ROW)
    rows["kind"], rows["component"], rows["connector"] = DASHPOT, numbers, which
    rows["points"], rows["functions"], rows["turning"] = connectors["points"][which], NONE, NONE
    return rows


def freeze(connectors: Any, which: np.ndarray) -> None:
    """Let springs pull along their axes as at the last evaluation, however long they are.

    connectors: records, in place.   which: numbers of those with rows.
    """
    way = connectors["stretch"][which] - connectors["offset"][which]
    connectors["force"][which] += np.einsum("kij,kj->ki", connectors["stiffness"][which], way)
    connectors["stiffness"][which] = 0.0


@inlined
def _direction(connector, number, one, other, half, k):
    """Component k of the axis along which, or about which if half is 1, a connector damps.

    number: of its direction.
    """
    if connector.kind == SPRING:
        square = 0.0
        for i in range(3):
            square += (other.x[0, i] - one.x[0, i]) ** 2
        return (1.0 - half) * (other.x[0, k] - one.x[0, k]) / np.sqrt(square)
    direction = connector.directions[number, 3 * half : 3 * half + 3]
    if connector.kind == CARTESIAN or connector.kind == RUBBING:
        return direction[k]
    return dot(connector.frame[0, k], direction)


@inlined
def _along(direction, law):
    """n . L n of a direction n (6,) and a matrix L (6, 6)."""
    total = 0.0
    for i in range(6):
        for j in range(6):
            total += direction[i] * law[i, j] * direction[j]
    return total


@inlined
def _turning_rate(kind, row, one, other):
    """What the turning of its axis adds to the change of a rate."""
    speed, along, square, turning = 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        velocity = other.x[1, i] - one.x[1, i]
        distance = other.x[0, i] - one.x[0, i]
        speed, along, square = speed + velocity**2, along + velocity * distance, square + distance**2
        turning += velocity * cross(one.spin, row.e[1], i)
        turning += (other.spin[i] - one.spin[i]) * cross(one.spin, row.turned[1], i)
    if kind == SPRING:
        return (speed - along * along / square) / np.sqrt(square)
    return 0.0 if kind in (CARTESIAN, RUBBING) else turning


@inlined
def _bend(kind, row, one, other):
    """B_t v: the change of the rate with accelerations of the coordinates zero; the row is aimed."""
    total = dot(row.e[0], one.x[2]) + dot(row.e[1], other.x[2])
    total += dot(row.turned[0], one.spin_rate) + dot(row.turned[1], other.spin_rate)
    return total + _turning_rate(kind, row, one, other)


@inlined
def aim_dashpots(joints, connectors, points):
    """Directions and softness of all rows, after `add_connectors`."""
    for r in range(joints.holding, len(joints.rows)):
        row = joints.rows[r]
        connector, number = connectors[row.connector], row.component
        one, other = points[row.points[0]], points[row.points[1]]
        for side in range(2):
            factor = connector.factors[1] if side == 1 else -connector.factors[0]
            for k in range(3):
                row.e[side, k] = factor * _direction(connector, number, one, other, 0, k)
                row.turned[side, k] = factor * _direction(connector, number, one, other, 1, k)
        direction, spring, damper = connector.directions[number], 0.0, 0.0
        if number < 6:
            spring = STIFF * row.reach**2 * max(_along(direction, connector.stiffness), 0.0)
        if number >= 6 or connector.splits == 0:
            damper = SHARE * row.lag * max(_along(direction, connector.damping), 0.0)
        both = max(spring + damper, SMALLEST)
        row.softness, row.springiness = 1.0 / both, spring / both
        row.bend = _bend(connector.kind, row, one, other)


@inlined
def added_energy(joints, duration):
    """Kinetic energy of what implicit springs add to the mass [J].   duration: of an evaluation [s]."""
    total = 0.0
    for r in range(joints.holding, len(joints.rows)):
        row = joints.rows[r]
        if row.springiness > 0.0:
            rate = joints.gamma[r] + duration * row.softness * joints.multipliers[r]
            total += 0.5 * row.springiness / row.softness * rate**2
    return total
