"""Bending damping of cables that stretch, implicit: lag D(q), the present matrix, beside the effective mass.

The constant matrix of `implicit_bending` damps all of r_xx,t, also what lies along the cable, where stretch
varies: a second solve takes that off again only where it is small beside the mass. D(q) is a sum of b b^T
over the quadrature points, b = sqrt(lag D w) d(kappa_t)/dv, and needs no second solve.
"""

import numpy as np

from ..compiled import inlined
from ..element.bending_damping import set_curvature_row
from ..lowered import local_array
from .assembly import differences


@inlined
def damping_rows(axes, nodes, elements, q, k, rows):
    """Set b of element k on its nodes, supports taken out; returns how many.

    q: (n, 2, dim).   rows: (24, 2 dim) output, two for each of up to 12 b, four points and three components:
        on position and slope of the left node, and of the right one.
    """
    element, left, right, dim = elements[k], nodes[k].free, nodes[k + 1].free, len(axes)
    e, row, memory = local_array(3, 3), local_array(3, 3), local_array(7, 3)
    if not element.damped:
        return 0
    number = 0
    differences(axes, q, k, e)
    for g in range(element.damping.shape[0]):
        scale = np.sqrt(element.lag * element.damping[g, 0])
        if scale > 0.0:
            for component in range(2 if len(axes) == 2 else 0, 3):
                set_curvature_row(axes, element.damping[g], component, e, memory, row)
                for i in range(dim):
                    rows[2 * number, i] = -scale * left[0] * row[0, i]
                    rows[2 * number, dim + i] = scale * left[1] * row[1, i]
                    rows[2 * number + 1, i] = scale * right[0] * row[0, i]
                    rows[2 * number + 1, dim + i] = scale * right[1] * row[2, i]
                number += 1
    return number
