"""Constant mass matrix of the element, Eq. (12)."""

import numpy as np

from ..arrays import Array
from .shape_functions import quadrature, shape_functions


def mass_matrix(length: float) -> Array:
    """m = int S S^T dx: the scalar mass matrix per unit line density; every direction shares it.

    Args:
        length: element length l [m].

    Returns:
        (4, 4) [m, m^2; m^2, m^3] in the order [r, r_x] left, [r, r_x] right; multiply by rho_A.
    """
    xi, weight = quadrature(length)
    shape = shape_functions(xi, length)
    return np.einsum("ag,bg,g->ab", shape, shape, weight)
