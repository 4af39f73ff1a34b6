"""Dampers of springs that are implicit in the accelerations, as rows among those of joints that yield.

Along each axis of a connector, with its damping d and the rate B v of its stretch,

    (M + W B^T B) a = F - B^T (f - W B a_before),   W = (1/2 + 1/16) h d,

as of contact, see `implicit_contacts`: f is the force at the velocities that a_before predicts. With the
multiplier mu = W B (a - a_before) this is a row B a - mu / W = B a_before beside those of the joints, which
yields by its `softness` 1 / W.
"""

from typing import Any

import numpy as np

from ..compiled import inlined
from .circle_contacts import SHARE
from .connectors import CARTESIAN, RUBBING, SPRING
from .joints import NONE
from .rows import DASHPOT, ROW

SMALLEST = 1e-300  # W of a damper that is explicit, which makes its row as soft as can be


def rows_of_dashpots(connectors: Any) -> Any:
    """Records of the rows, one for each axis along which a connector damps.

    Without those whose damping couples axes: they remain explicit.

    Args:
        connectors: records.
    """
    damping = connectors["damping"]
    diagonal = np.diagonal(damping, axis1=1, axis2=2)
    is_simple = np.count_nonzero(damping, axis=(1, 2)) == np.count_nonzero(diagonal, axis=1)
    which, axes = np.nonzero((diagonal > 0.0) & is_simple[:, np.newaxis])
    rows = np.zeros(len(which), ROW)
    rows["kind"], rows["component"], rows["connector"] = DASHPOT, axes, which
    rows["points"], rows["functions"], rows["turning"] = connectors["points"][which], NONE, NONE
    return rows


@inlined
def _direction(connector, axis, one, other, k):
    """Component k of the axis along or about which a connector damps.   axis: 0 to 5."""
    if connector.kind == SPRING:
        square = 0.0
        for i in range(3):
            square += (other.x[0, i] - one.x[0, i]) ** 2
        return (other.x[0, k] - one.x[0, k]) / np.sqrt(square)
    if connector.kind == CARTESIAN or connector.kind == RUBBING:
        return 1.0 if k == axis else 0.0
    return connector.frame[0, k, axis % 3]


@inlined
def aim_dashpots(joints, connectors, points):
    """Directions and softness of all rows, after `add_connectors`."""
    for r in range(joints.holding, len(joints.rows)):
        row = joints.rows[r]
        connector, axis = connectors[row.connector], row.component
        one, other = points[row.points[0]], points[row.points[1]]
        for k in range(3):
            direction = _direction(connector, axis, one, other, k)
            for side in range(2):
                factor = connector.factors[1] if side == 1 else -connector.factors[0]
                row.e[side, k] = factor * direction if axis < 3 else 0.0
                row.turned[side, k] = factor * direction if axis >= 3 else 0.0
        row.softness = 1.0 / max(SHARE * row.lag * connector.damping[axis, axis], SMALLEST)
