"""Two slopes that are the same: with unit length each, one equation in the plane, two in space.

    c = n . (r x s),  n = 2 b x e / E,  e = d + s,  E = e . e

is the component of the second slope r along b, a unit vector across the direction d, as the smallest rotation
from d to the first slope s turns it. c = 0 for parallel slopes of any length. There is no such rotation where
s = -d: `same_slopes` keeps d away from where cables come to rest. In the plane nothing needs to turn: there
d = 0, and n = b is the normal.
"""

import numpy as np

from ..arrays import Array
from ..compiled import inlined, inlined_kernel
from .points import cross, cross_product, dot

ASIDE = np.array([0.31, -0.47, 0.23])  # of the initial slope is d, so that -d lies in no plane of axes


def same_slopes(slope: Array) -> tuple[Array, Array]:
    """d (3,) and b_k (k, 3) of slopes that are the same.   slope: (2,) or (3,) of both at the start."""
    if len(slope) == 2:
        return np.zeros(3), np.array([[0.0, 0.0, 1.0]])
    direction = slope / np.linalg.norm(slope) + ASIDE
    direction /= np.linalg.norm(direction)
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return direction, np.stack([first, np.cross(direction, first)])


@inlined
def _normal(b, d, s):
    """n, e and E, which is infinite where n is constant."""
    if d[0] == 0.0 and d[1] == 0.0 and d[2] == 0.0:
        return (b[0], b[1], b[2]), (0.0, 0.0, 0.0), np.inf
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
