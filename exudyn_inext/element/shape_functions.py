"""Hermite shape functions of the element, Eq. (9), and their quadrature."""

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array

# Products of up to four shape function derivatives are polynomials of degree 6 or less.
_GAUSS_ABSCISSAE, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


def shape_functions(xi: ArrayLike, length: float | Array) -> Array:
    """S(xi), Eq. (9), for the coordinates [r, r_x] of the left and then of the right node.

    Args:
        xi: (...) abscissa within the element, 0 to 1 [-].
        length: element length l, or one for each xi [m].

    Returns:
        (4, ...) weights [-, m, -, m].
    """
    x = np.asarray(xi, dtype=float)
    return np.stack(
        [
            1 - 3 * x**2 + 2 * x**3,
            length * (x - 2 * x**2 + x**3),
            3 * x**2 - 2 * x**3,
            length * (x**3 - x**2),
        ]
    )


def first_derivatives(xi: ArrayLike, length: float | Array) -> Array:
    """S_x = dS/dx, Eq. (11). Returns (4, ...) [1/m, -, 1/m, -]."""
    x = np.asarray(xi, dtype=float)
    return np.stack(
        [
            6 * (x**2 - x) / length,
            1 - 4 * x + 3 * x**2,
            6 * (x - x**2) / length,
            3 * x**2 - 2 * x,
        ]
    )


def second_derivatives(xi: ArrayLike, length: float | Array) -> Array:
    """S_xx = d2S/dx2, Eq. (11). Returns (4, ...) [1/m^2, 1/m, 1/m^2, 1/m]."""
    x = np.asarray(xi, dtype=float)
    return np.stack(
        [
            (12 * x - 6) / length**2,
            (6 * x - 4) / length,
            (6 - 12 * x) / length**2,
            (6 * x - 2) / length,
        ]
    )


def quadrature(length: float) -> tuple[Array, Array]:
    """Gauss points xi (4,) [-] and weights (4,) [m] of one element, exact up to degree 7."""
    return 0.5 * (_GAUSS_ABSCISSAE + 1), 0.5 * length * _GAUSS_WEIGHTS
