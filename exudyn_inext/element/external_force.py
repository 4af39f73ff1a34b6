"""Consistent nodal forces of distributed and concentrated loads, Eq. (17)."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from .shape_functions import quadrature, shape_functions


def distributed_force(load: Callable[[Array], Array], start: float, length: float) -> Array:
    """int S f dx over one element.

    Args:
        load: f(x): arc lengths (g,) [m] to force densities (g, dim) [N/m].
        start: arc length of the element's left end [m].
        length: element length l [m].

    Returns:
        (4, dim) [N, Nm, N, Nm]. Exact for f up to degree 4 in x.
    """
    xi, weight = quadrature(length)
    return np.einsum("ag,gi,g->ai", shape_functions(xi, length), load(start + length * xi), weight)


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
