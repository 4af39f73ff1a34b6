"""Strains do not see translations: they depend on d = r_right - r_left and the two end slopes.

An element's curvature and stretch are quadratic forms of the three vectors e = (d, s_left, s_right)
instead of the four nodal ones. The kernels use this form: 3x3 instead of 4x4 coefficients.
"""

import numpy as np

from ..arrays import Array

_KEPT = [2, 1, 3]  # with r_left = 0 as origin: d = r_right, then both slopes


def in_differences(nodal_form: Array) -> Array:
    """Rewrite a translation-invariant form in (d, s_left, s_right).

    Args:
        nodal_form: (4, 4) or (4, 4, 4, 4), in the order r_left, s_left, r_right, s_right.

    Returns:
        (3, 3) or (3, 3, 3, 3).
    """
    return nodal_form[np.ix_(*[_KEPT] * nodal_form.ndim)]
