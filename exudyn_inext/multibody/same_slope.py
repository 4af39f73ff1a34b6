"""Two slopes that are the same: with unit length each, one equation in the plane, two in space.

    c = n . (r x s),  n = 2 b x e / E,  e = d + s,  E = e . e

is the component of the second slope r along b, a unit vector across the initial slope d, as the smallest
rotation from d to the first slope s turns it. c = 0 for parallel slopes of any length.
"""

from ..compiled import inlined, inlined_kernel
from .points import cross, cross_product, dot


@inlined
def _normal(b, d, s):
    """n, e and E."""
    e = (d[0] + s[0], d[1] + s[1], d[2] + s[2])
    square, n = dot(e, e), cross_product(b, e)
    return (2.0 * n[0] / square, 2.0 * n[1] / square, 2.0 * n[2] / square), e, square


@inlined_kernel
def slope_difference(b, d, s, r, gradient):
    """c [-].

    Args:
        b, d, s, r: (3,) see above.   gradient: (2, 3) output: dc/ds and dc/dr.
    """
    n, e, square = _normal(b, d, s)
    w = cross_product(r, s)
    value = dot(n, w)
    for i in range(3):
        gradient[0, i] = cross(n, r, i) + 2.0 * (cross(w, b, i) - value * e[i]) / square
        gradient[1, i] = cross(s, n, i)
    return value


@inlined
def slope_gamma(b, d, one, other):
    """-c_tt, with E n_t = 2 b x s_t - E_t n and E n_tt = -2 E_t n_t - E_tt n.

    one, other: (3, 3) s and r with their rates; accelerations are zero.
    """
    s, v, r, u = one[0], one[1], other[0], other[1]
    n, e, square = _normal(b, d, s)
    rate, change = 2.0 * dot(e, v), 2.0 * dot(v, v)
    w, w_tt, total = cross_product(r, s), cross_product(u, v), 0.0
    for i in range(3):
        n_t = (2.0 * cross(b, v, i) - rate * n[i]) / square
        n_tt = -(2.0 * rate * n_t + change * n[i]) / square
        total += n_tt * w[i] + 2.0 * n_t * (cross(u, s, i) + cross(r, v, i)) + 2.0 * n[i] * w_tt[i]
    return -total
