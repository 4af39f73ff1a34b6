"""Forces and torques on points: constant, or functions of time."""

import numpy as np

from ..arrays import record_type
from ..compiled import inlined
from .points import add_wrench

NONE = -1  # no function

LOAD = record_type(
    [
        ("point", np.int64),
        ("is_torque", np.int64),
        ("is_fixed_to_body", np.int64),  # whether it turns with the frame of its point
        ("function", np.int64),  # place of its components among the functions of time, or NONE
        ("constant", np.float64, (3,)),  # components, if there is no function
        ("wrench", np.float64, (6,)),
    ]
)


@inlined
def add_loads(loads, points, functions, force):
    """Add the generalised forces of all loads to force (n,).   functions: values at present."""
    for k in range(len(loads)):
        load = loads[k]
        point = points[load.point]
        at = 3 if load.is_torque else 0
        for i in range(3):
            value = functions[load.function + i] if load.function >= 0 else load.constant[i]
            load.wrench[at + i] = value
        if load.is_fixed_to_body:
            x, y, z = load.wrench[at], load.wrench[at + 1], load.wrench[at + 2]
            for i in range(3):
                turn = point.orientation[i]
                load.wrench[at + i] = turn[0] * x + turn[1] * y + turn[2] * z
        add_wrench(point, load.wrench, 1.0, force)
