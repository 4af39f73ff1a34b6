"""Kelvin-Voigt damping of the element: a bending moment D kappa_t that opposes the curvature's rate.

As in the native ANCF cables, kappa is the scalar curvature |r_x x r_xx|, with a sign in the plane: rigid
motions are not damped, and neither is a spatial motion in which only the direction of bending turns.
"""

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from .shape_functions import first_derivatives, quadrature, second_derivatives

NO_CURVATURE = 1e-30  # |r_x x r_xx|^2 [1/m^2] below which a spatial cable counts as straight


def damping_table(length: float) -> Array:
    """What the force needs at the quadrature points, per unit D.

    Args:
        length: element length l [m].

    Returns:
        (4, 7) weight [m], S_x and S_xx of (d, s_left, s_right) at each point.
    """
    xi, weight = quadrature(length)
    kept = [2, 1, 3]
    slope, curvature = first_derivatives(xi, length)[kept], second_derivatives(xi, length)[kept]
    return np.concatenate([weight[:, None], slope.T, curvature.T], axis=1)


@inlined
def _at_point(axes, table, first, differences, vector):
    """vector (3, 1) = sum_a table[first + a] e_a; the third component of planar ones is left alone."""
    for i in range(len(axes)):
        vector[i, 0] = (
            table[first] * differences[0, i]
            + table[first + 1] * differences[1, i]
            + table[first + 2] * differences[2, i]
        )


@inlined
def _cross(a, b, result):
    result[0, 0] = a[1, 0] * b[2, 0] - a[2, 0] * b[1, 0]
    result[1, 0] = a[2, 0] * b[0, 0] - a[0, 0] * b[2, 0]
    result[2, 0] = a[0, 0] * b[1, 0] - a[1, 0] * b[0, 0]


@inlined
def add_damping_force(axes, table, differences, rates, memory, force):
    """force -= D int kappa_t d(kappa)/de dx; nothing where `table` is empty.

    Args:
        axes: (0, 1) or (0, 1, 2): its length is the space dimension, a compile-time constant.
        table: (4, 7) `damping_table` with its weights times D, or (0, 7).
        differences, rates: (3, dim) e = (d, s_left, s_right) [m, -, -] and its time derivative.
        memory: eight (3, 1) local arrays.
        force: (3, dim) generalised force on e, added to [N, Nm, Nm].
    """
    r_x, r_xx, v_x, v_xx, b, b_t, on_slope, on_curvature = memory
    for g in range(table.shape[0]):
        for vector in (r_x, r_xx, v_x, v_xx):
            vector[2, 0] = 0.0
        _at_point(axes, table[g], 1, differences, r_x)
        _at_point(axes, table[g], 4, differences, r_xx)
        _at_point(axes, table[g], 1, rates, v_x)
        _at_point(axes, table[g], 4, rates, v_xx)
        _cross(r_x, r_xx, b)
        _cross(v_x, r_xx, b_t)
        _cross(r_x, v_xx, on_slope)
        square, power = 0.0, 0.0
        for i in range(3):
            b_t[i, 0] += on_slope[i, 0]
            square += b[i, 0] * b[i, 0]
            power += b[i, 0] * b_t[i, 0]
        scale = power / max(square, NO_CURVATURE)
        if len(axes) == 2:  # the sign of kappa is known, also where kappa is zero
            b[2, 0] = 1.0
            scale = b_t[2, 0]
        _cross(r_xx, b, on_slope)
        _cross(b, r_x, on_curvature)
        for a in range(3):
            for i in range(len(axes)):
                force[a, i] -= (
                    table[g, 0]
                    * scale
                    * (table[g, 1 + a] * on_slope[i, 0] + table[g, 4 + a] * on_curvature[i, 0])
                )
