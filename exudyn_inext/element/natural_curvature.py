"""Natural (stress-free) curvature of a planar element.

With kappa = r_x x r_xx, the energy 1/2 EI int (kappa - kappa_0)^2 dx has, besides the bending energy of a
straight cable and a constant, the term -EI int kappa_0 r_x x r_xx dx: its force is linear in q.
"""

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from .shape_functions import first_derivatives, quadrature, second_derivatives


def turning_matrix(length: float, natural: Array | float = 1.0) -> Array:
    """A = int kappa_0 (S_x S_xx^T - S_xx S_x^T) dx, so that int kappa_0 r_x x r_xx dx = 1/2 A_ab q_a x q_b.

    Args:
        length: element length l [m].
        natural: kappa_0, (4,) at the quadrature points or the same at all of them [1/m].

    Returns:
        (4, 4) antisymmetric [1/m^3, 1/m^2; 1/m^2, 1/m], in the order [r, r_x] left, [r, r_x] right.
    """
    xi, weight = quadrature(length)
    shapes = first_derivatives(xi, length), second_derivatives(xi, length)
    half = np.einsum("ag,bg,g->ab", *shapes, weight * natural)
    return half - half.T


def curvature(nodal: Array, xi: Array, length: float) -> Array:
    """kappa = r_x x r_xx / |r_x|^2 (g,) at abscissae xi (g,) of a planar element [1/m].

    Args:
        nodal: (4, 2) [r, r_x] left, [r, r_x] right.   length: of the element [m].
    """
    r_x, r_xx = (s(xi, length).T @ nodal for s in (first_derivatives, second_derivatives))
    turning = r_x[:, 0] * r_xx[:, 1] - r_x[:, 1] * r_xx[:, 0]
    return np.asarray(turning / np.einsum("gi,gi->g", r_x, r_x))


@inlined
def add_natural_curvature_force(natural, differences, force):
    """force += EI kappa_0 A (e turned by -90 degrees); nothing where `natural` is empty, as in space.

    Args:
        natural: (3, 3) EI kappa_0 times the turning matrix in difference coordinates, or (0, 0).
        differences: (3, 2) e = (d, s_left, s_right) [m, -, -].
        force: (3, 2) generalised force on e, added to [N, Nm, Nm].
    """
    for a in range(natural.shape[0]):
        for b in range(natural.shape[1]):
            force[a, 0] += natural[a, b] * differences[b, 1]
            force[a, 1] -= natural[a, b] * differences[b, 0]
