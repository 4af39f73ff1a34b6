"""Kelvin-Voigt damping of the element: a bending moment D kappa_t that opposes the curvature's rate.

As in the native ANCF cables, kappa is the vector r_x x r_xx, over |r_x|^2 if the cable stretches. In the
plane rigid motions are not damped. In space a bent cable that turns about an axis in its plane of bending
is, as its kappa turns with it.
"""

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from .shape_functions import first_derivatives, quadrature, second_derivatives


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


# Rows of the memory of the forces.
R_X, R_XX, V_X, V_XX, KAPPA_T, ON_SLOPE, ON_CURVATURE = range(7)


@inlined
def _at_point(axes, table, first, differences, memory, row):
    """memory[row] = sum_a table[first + a] e_a; the third component of planar vectors is zero."""
    memory[row, 2] = 0.0
    for i in range(len(axes)):
        memory[row, i] = (
            table[first] * differences[0, i]
            + table[first + 1] * differences[1, i]
            + table[first + 2] * differences[2, i]
        )


@inlined
def _cross(memory, a, b, row):
    """memory[row] = memory[a] x memory[b]."""
    memory[row, 0] = memory[a, 1] * memory[b, 2] - memory[a, 2] * memory[b, 1]
    memory[row, 1] = memory[a, 2] * memory[b, 0] - memory[a, 0] * memory[b, 2]
    memory[row, 2] = memory[a, 0] * memory[b, 1] - memory[a, 1] * memory[b, 0]


@inlined
def _state_at(axes, table, differences, rates, memory):
    """r_x, r_xx and their rates at a quadrature point."""
    _at_point(axes, table, 1, differences, memory, R_X)
    _at_point(axes, table, 4, differences, memory, R_XX)
    _at_point(axes, table, 1, rates, memory, V_X)
    _at_point(axes, table, 4, rates, memory, V_XX)


@inlined
def _moment(memory):
    """Rate w of r_x x r_xx, and what a moment w does: r_xx x w on r_x, w x r_x on r_xx."""
    _cross(memory, V_X, R_XX, KAPPA_T)
    _cross(memory, R_X, V_XX, ON_SLOPE)
    for i in range(3):
        memory[KAPPA_T, i] += memory[ON_SLOPE, i]
    _cross(memory, R_XX, KAPPA_T, ON_SLOPE)
    _cross(memory, KAPPA_T, R_X, ON_CURVATURE)


@inlined
def _take_off(axes, table, weight, memory, force):
    """force -= weight times what acts on r_x and r_xx."""
    for a in range(3):
        for i in range(len(axes)):
            weighted = table[1 + a] * memory[ON_SLOPE, i] + table[4 + a] * memory[ON_CURVATURE, i]
            force[a, i] -= weight * weighted


@inlined
def add_damping_force(axes, table, differences, rates, memory, force):
    """force -= D int kappa_t . d(kappa)/de dx.

    Args:
        axes: (0, 1) or (0, 1, 2): its length is the space dimension, a compile-time constant.
        table: (4, 7) `damping_table` with its weights times D; zeros without damping.
        differences, rates: (3, dim) e = (d, s_left, s_right) [m, -, -] and its time derivative.
        memory: (7, 3) local array.
        force: (3, dim) generalised force on e, added to [N, Nm, Nm].
    """
    for g in range(table.shape[0]):
        _state_at(axes, table[g], differences, rates, memory)
        _moment(memory)
        _take_off(axes, table[g], table[g, 0], memory, force)


@inlined
def add_stretched_damping_force(axes, table, differences, rates, memory, force):
    """The same with kappa = r_x x r_xx / |r_x|^2; nothing where the weights are zero, as between two cables.

    With r_xx,t less 2 (r_x . r_x,t) / |r_x|^2 r_xx its rate is that of r_x x r_xx, over |r_x|^2.
    """
    for g in range(table.shape[0]):
        if table[g, 0] > 0.0:
            _state_at(axes, table[g], differences, rates, memory)
            square, rate, work = 0.0, 0.0, 0.0
            for i in range(len(axes)):
                square += memory[R_X, i] * memory[R_X, i]
                rate += memory[R_X, i] * memory[V_X, i]
            per_square = 1.0 / square
            for i in range(len(axes)):
                memory[V_XX, i] -= 2.0 * rate * per_square * memory[R_XX, i]
            _moment(memory)
            for i in range(len(axes)):
                work += memory[R_XX, i] * memory[ON_CURVATURE, i]
            for i in range(len(axes)):
                memory[ON_SLOPE, i] -= 2.0 * work * per_square * memory[R_X, i]
            _take_off(axes, table[g], table[g, 0] * per_square * per_square, memory, force)


@inlined
def set_curvature_row(axes, point, component, differences, memory, row):
    """row (3, dim) = derivative of a component of kappa_t, as above, with respect to the rates of e.

    point: (7,) of the `damping_table`.   differences: (3, dim) e.   memory: (7, 3) local array.
    """
    _at_point(axes, point, 1, differences, memory, R_X)
    _at_point(axes, point, 4, differences, memory, R_XX)
    square, work = 0.0, 0.0
    for i in range(3):
        memory[KAPPA_T, i] = 0.0
        square += memory[R_X, i] * memory[R_X, i]
    memory[KAPPA_T, component] = 1.0
    per_square = 1.0 / square
    _cross(memory, R_XX, KAPPA_T, ON_SLOPE)
    _cross(memory, KAPPA_T, R_X, ON_CURVATURE)
    for i in range(len(axes)):
        work += memory[R_XX, i] * memory[ON_CURVATURE, i]
    for a in range(3):
        for i in range(len(axes)):
            on_slope = memory[ON_SLOPE, i] - 2.0 * work * per_square * memory[R_X, i]
            row[a, i] = per_square * (point[1 + a] * on_slope + point[4 + a] * memory[ON_CURVATURE, i])


@inlined
def add_curvature_force(axes, table, rates, memory, force):
    """force -= D int r_xx,t . d(r_xx)/de dx: what the damping would be if all of r_xx,t were damped.

    Its matrix is constant and at least that of `add_damping_force`. Arguments: see there.
    """
    for g in range(table.shape[0]):
        _at_point(axes, table[g], 4, rates, memory, V_XX)
        for a in range(3):
            for i in range(len(axes)):
                force[a, i] -= table[g, 0] * table[g, 4 + a] * memory[V_XX, i]


@inlined
def curvature_power(axes, table, rates, memory):
    """D int r_xx,t . r_xx,t dx [W]. Arguments: see `add_damping_force`."""
    power = 0.0
    for g in range(table.shape[0]):
        _at_point(axes, table[g], 4, rates, memory, V_XX)
        for i in range(len(axes)):
            power += table[g, 0] * memory[V_XX, i] * memory[V_XX, i]
    return power
