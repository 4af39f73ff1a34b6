"""Forces by stiffness and damping matrices, each entry on its own: F_i += f - k q_j - d q_jt."""

import numpy as np

from ..arrays import record_type
from ..compiled import inlined

LINEAR_FORCE = record_type(
    [
        ("row", np.int64),  # i, coordinate among all of the scene
        ("column", np.int64),  # j
        ("stiffness", np.float64),  # k
        ("damping", np.float64),  # d
        ("constant", np.float64),  # f
    ]
)


@inlined
def add_linear_forces(entries, q, v, force):
    """Add all of them to force (n,).   q, v: (n,) coordinates and velocities."""
    for e in range(len(entries)):
        one = entries[e]
        force[one.row] += one.constant - one.stiffness * q[one.column] - one.damping * v[one.column]
