"""A disc that rolls on a plane: where they touch, both have the same velocity.

With the normal n of the plane, the axis a of the disc, points x_0 and x_1 on both, and spins w_0 and w_1,

    f = a x n / |a x n|,  p = r a x f,  s = x_1 + p - x_0,
    b . u = 0,  u = v_1 + w_1 x p - v_0 - w_0 x s,  b = n x f, f or n

(CObjectJointRollingDisc.cpp). This is no rate of a function of places.
"""

import numpy as np

from ..compiled import inlined, inlined_kernel
from .points import cross, cross_product, dot


@inlined
def _sum(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def _forward(n, a):
    """f, and |a x n|."""
    g = cross_product(a, n)
    size = np.sqrt(dot(g, g))
    return (g[0] / size, g[1] / size, g[2] / size), size


@inlined_kernel
def place_contact(n, a, which, radius, arms):
    """Of equation number `which`.   n, a: (3,).   arms: (2, 3) output: b and p."""
    f, _ = _forward(n, a)
    across, p = cross_product(n, f), cross_product(a, f)
    for i in range(3):
        arms[0, i] = across[i] if which == 0 else (f[i] if which == 1 else n[i])
        arms[1, i] = radius * p[i]


@inlined_kernel
def rolling_gamma(n, a, which, radius, arms, s, one, other):
    """-(b . u)_t with accelerations of the coordinates zero.

    Args:
        n, a, which, radius, arms: see `place_contact`.   s: (3,).   one, other: points on plane and disc.
    """
    (f, size), n_t, a_t = _forward(n, a), cross_product(one.spin, n), cross_product(other.spin, a)
    g_t = _sum(cross_product(a_t, n), cross_product(a, n_t))
    along = dot(f, g_t)
    f_t = (g_t[0] - along * f[0]) / size, (g_t[1] - along * f[1]) / size, (g_t[2] - along * f[2]) / size
    across_t = _sum(cross_product(n_t, f), cross_product(n, f_t))
    turned, total = _sum(cross_product(a_t, f), cross_product(a, f_t)), 0.0
    p, p_t = arms[1], (radius * turned[0], radius * turned[1], radius * turned[2])
    s_t = _sum(other.x[1], p_t)
    s_t = s_t[0] - one.x[1, 0], s_t[1] - one.x[1, 1], s_t[2] - one.x[1, 2]
    for i in range(3):
        b_t = across_t[i] if which == 0 else (f_t[i] if which == 1 else n_t[i])
        u = other.x[1, i] + cross(other.spin, p, i) - one.x[1, i] - cross(one.spin, s, i)
        u_t = other.x[2, i] + cross(other.spin_rate, p, i) + cross(other.spin, p_t, i)
        u_t -= one.x[2, i] + cross(one.spin_rate, s, i) + cross(one.spin, s_t, i)
        total += b_t * u + arms[0, i] * u_t
    return -total
