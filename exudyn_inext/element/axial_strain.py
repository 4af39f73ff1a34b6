"""Axial strain |r_x| - 1 of the element: at its nodes, and in its middle from its mean.

With m^2 = int |r_x|^2 dx / l, Simpson's rule gives the strain in the middle,
3/2 (m - 1) - (c_left + c_right) / 4. Both strains vanish where the constraints (18), (19) are fulfilled.
"""

import numpy as np

from ..compiled import inlined


@inlined
def norm(axes, x):
    """|x| of x (dim,)."""
    square = 0.0
    for i in range(len(axes)):
        square += x[i] * x[i]
    return np.sqrt(square)


@inlined
def middle_strain(mean, left, right):
    """Value in the middle, from the mean over the element and the values at its nodes [-, 1/s, ...]."""
    return 1.5 * mean - 0.25 * (left + right)


@inlined
def mean_strain(left, middle, right):
    """The inverse of `middle_strain`: Simpson's rule."""
    return (left + 4.0 * middle + right) / 6.0


@inlined
def rise_by_left(left, right):
    """Half the derivative by `left` of 3 l int (c_x)^2 dx = 7 left^2 + 7 right^2 + 2 left right.

    left, right: strains at the nodes less that in the middle, through which c is a parabola [-].
    """
    return 7.0 * left + right
