"""Bending energy and elastic forces of the element, in two measures of the curvature.

`secondDerivative`: kappa^2 = |r_xx|^2, the inextensible limit of (4): a constant stiffness matrix.
`product`:          kappa^2 = |r_x|^2 |r_xx|^2, Eqs. (4), (13)-(16): a constant stiffness tensor.
"""

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from ..lowered import local_array
from .shape_functions import first_derivatives, quadrature, second_derivatives

# Pairs (a, b) of the three difference coordinates, the off-diagonal ones once.
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def stiffness_matrix(length: float) -> Array:
    """int S_xx S_xx^T dx: bending stiffness of `secondDerivative` per unit EI.

    Args:
        length: element length l [m].

    Returns:
        (4, 4) [1/m^3, 1/m^2; 1/m^2, 1/m], in the order [r, r_x] left, [r, r_x] right.
    """
    xi, weight = quadrature(length)
    curvature = second_derivatives(xi, length)
    return np.einsum("ag,bg,g->ab", curvature, curvature, weight)


def stiffness_tensor(length: float) -> Array:
    """k of Eqs. (14), (15) per unit EI: U = 1/2 k^{abmn} Q_ab Q_mn with Q_ab = q_a . q_b / 2.

    Args:
        length: element length l [m].

    Returns:
        (4, 4, 4, 4), symmetric in (a, b), in (m, n) and under exchange of both pairs.
    """
    xi, weight = quadrature(length)
    slope = np.einsum("ag,bg->abg", *[first_derivatives(xi, length)] * 2)
    curvature = np.einsum("ag,bg->abg", *[second_derivatives(xi, length)] * 2)
    half = np.einsum("abg,mng,g->abmn", slope, curvature, weight)
    return 2 * (half + half.transpose(2, 3, 0, 1))


def in_pairs(tensor: Array) -> Array:
    """Condense a (3, 3, 3, 3) tensor, symmetric in its pairs, to (6, 6) over `PAIRS`.

    W_ab = tensor^{abmn} Q_mn becomes six sums of six: columns of mixed pairs count twice.
    """
    return np.array([[tensor[a, b, m, n] * (1 if m == n else 2) for m, n in PAIRS] for a, b in PAIRS])


@inlined
def add_second_derivative_force(axes, stiffness, differences, force):
    """force -= K e: elastic force of `secondDerivative`.

    Args:
        axes: (0, 1) or (0, 1, 2): its length is the space dimension, a compile-time constant.
        stiffness: (3, 3) EI times the stiffness matrix in difference coordinates.
        differences: (3, dim) e = (d, s_left, s_right) [m, -, -].
        force: (3, dim) generalised force on e, added to [N, Nm, Nm].
    """
    for a in range(3):
        for i in range(len(axes)):
            force[a, i] -= (
                stiffness[a, 0] * differences[0, i]
                + stiffness[a, 1] * differences[1, i]
                + stiffness[a, 2] * differences[2, i]
            )


@inlined
def _set_product(axes, differences, products, pair):
    """products[pair] = Q_ab = e_a . e_b / 2."""
    a, b = PAIRS[pair]
    products[pair, 0] = 0.0
    for i in range(len(axes)):
        products[pair, 0] += 0.5 * differences[a, i] * differences[b, i]


@inlined
def _add_force_of_pair(axes, tensor, products, differences, force, pair):
    """force -= (k^{abmn} Q_mn) e_b of one pair (a, b), and of (b, a)."""
    weight = 0.0
    for column in range(6):
        weight += tensor[pair, column] * products[column, 0]
    a, b = PAIRS[pair]
    for i in range(len(axes)):
        force[a, i] -= weight * differences[b, i]
        if a != b:
            force[b, i] -= weight * differences[a, i]


@inlined
def add_product_force(axes, tensor, differences, force):
    """force -= k^{abmn} Q_mn e_b: elastic force of `product`, Eq. (16).

    Args:
        axes, differences, force: see `add_second_derivative_force`.
        tensor: (6, 6) EI times the stiffness tensor over `PAIRS` of difference coordinates.
    """
    products = local_array(6, 1)
    for pair in range(6):
        _set_product(axes, differences, products, pair)
    for pair in range(6):
        _add_force_of_pair(axes, tensor, products, differences, force, pair)


@inlined
def add_bending_force(axes, stiffness, tensor, differences, force):
    """Elastic force of one element in the measure of its cable: `product` if there is a tensor.

    `tensor` is empty (0, 0) for `secondDerivative`; its shape is known when compiling.
    Arguments: see the two forces.
    """
    if len(tensor) == 0:
        add_second_derivative_force(axes, stiffness, differences, force)
    else:
        add_product_force(axes, tensor, differences, force)
