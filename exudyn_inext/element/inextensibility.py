"""Inextensibility of the element: nodal constraints (18) and the integral ones (19)."""

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from .shape_functions import first_derivatives, quadrature


def slope_gram_matrix(length: float) -> Array:
    """G = int S_x S_x^T dx, so that int |r_x|^2 dx = q^T G q in every direction, Eq. (19).

    Args:
        length: element length l [m].

    Returns:
        (4, 4) [1/m, -; -, m], in the order [r, r_x] left, [r, r_x] right.
    """
    xi, weight = quadrature(length)
    slope = first_derivatives(xi, length)
    return np.einsum("ag,bg,g->ab", slope, slope, weight)


@inlined
def nodal_constraint(axes, slope):
    """c = r_x . r_x - 1 at a node, Eq. (18).   slope: (dim,) r_x [-].   Returns c [-]."""
    value = -1.0
    for i in range(len(axes)):
        value += slope[i] * slope[i]
    return value


@inlined
def nodal_rate(axes, slope, slope_rate):
    """c_q v = 2 r_x . v_x at a node.   slope [-], slope_rate [1/s]: (dim,).   Returns [1/s]."""
    value = 0.0
    for i in range(len(axes)):
        value += slope[i] * slope_rate[i]
    return 2.0 * value


@inlined
def nodal_gamma(axes, slope_rate):
    """gamma = -(c_q v)_q v = -2 v_x . v_x at a node, Eq. (27).   Returns [1/s^2]."""
    value = 0.0
    for i in range(len(axes)):
        value += slope_rate[i] * slope_rate[i]
    return -2.0 * value


@inlined
def length_gradient(axes, gram, differences, gradient):
    """gradient = 2 G e: Jacobian of int |r_x|^2 dx with respect to e = (d, s_left, s_right).

    Args:
        axes: (0, 1) or (0, 1, 2): its length is the space dimension, a compile-time constant.
        gram: (3, 3) slope Gram matrix in difference coordinates [1/m, -; -, m].
        differences: (3, dim) [m, -, -].
        gradient: (3, dim) output [-, m, m].
    """
    for a in range(3):
        for i in range(len(axes)):
            gradient[a, i] = 2.0 * (
                gram[a, 0] * differences[0, i]
                + gram[a, 1] * differences[1, i]
                + gram[a, 2] * differences[2, i]
            )


@inlined
def contract(axes, left, right):
    """left : right over (3, dim). With a = 2 G e: e:a / 2 = int |r_x|^2 dx, and e_t:a its rate."""
    value = 0.0
    for a in range(3):
        for i in range(len(axes)):
            value += left[a, i] * right[a, i]
    return value
