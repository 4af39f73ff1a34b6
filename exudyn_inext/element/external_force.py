"""Consistent nodal forces of uniform and concentrated loads, Eq. (17)."""

import numpy as np

from ..arrays import Array
from .shape_functions import shape_functions


def uniform_force(length: float) -> Array:
    """int S dx over one element: consistent force of a unit force density.

    Args:
        length: element length l [m].

    Returns:
        (4,) [m, m^2, m, m^2].
    """
    return np.array([length / 2, length**2 / 12, length / 2, -(length**2) / 12])


def point_force(force: Array, xi: float, length: float) -> Array:
    """S(xi) F for a force F (dim,) [N] at xi within the element. Returns (4, dim)."""
    return np.multiply.outer(shape_functions(xi, length), force)
