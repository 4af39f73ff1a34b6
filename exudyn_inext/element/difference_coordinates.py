"""Strains do not see translations: they depend on d = r_right - r_left and the two end slopes.

An element's curvature and stretch are quadratic forms of the three vectors e = (d, s_left, s_right)
instead of the four nodal ones. The kernels use this form: 3x3 instead of 4x4 coefficients.
"""

from ..arrays import Array

_KEPT = [2, 1, 3]  # with r_left = 0 as origin: d = r_right, then both slopes


def in_differences(nodal_forms: Array) -> Array:
    """Rewrite translation-invariant forms in (d, s_left, s_right).

    Args:
        nodal_forms: (N, 4, 4) or (N, 4, 4, 4, 4), in the order r_left, s_left, r_right, s_right.

    Returns:
        (N, 3, 3) or (N, 3, 3, 3, 3).
    """
    for axis in range(1, nodal_forms.ndim):
        nodal_forms = nodal_forms.take(_KEPT, axis=axis)
    return nodal_forms
