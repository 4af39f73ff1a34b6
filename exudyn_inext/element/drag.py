"""Quasi-static drag of the element: a force per present length against the flow, across and along the cable.

    f = -c_n |w_n| w_n - c_t |w_t| w_t,    w = r_t - u,  w_t = (w . t) t,  w_n = w - w_t,  t = r_x / |r_x|

(Morison's formula without inertia terms; J. R. Morison et al., Petroleum Transactions, AIME 189 (1950)
149-154, split by the independence principle), with c_n = rho d C_n / 2 and c_t = pi rho d C_t / 2. A cable
that stretches keeps its diameter d.
"""

import math

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from .shape_functions import first_derivatives, quadrature, shape_functions


def drag_table(length: float) -> Array:
    """What the force needs at the quadrature points.

    Args:
        length: element length l [m].

    Returns:
        (4, 8) weight [m], S of (r, r_x) left and right, S_x of (d, s_left, s_right) at each point.
    """
    xi, weight = quadrature(length)
    slope = first_derivatives(xi, length)[[2, 1, 3]]
    return np.concatenate([weight[:, None], shape_functions(xi, length).T, slope.T], axis=1)


# Rows of the law, and of the memory of the force.
COEFFICIENTS, FLOW = 0, 1
TANGENT, RELATIVE = 0, 1


@inlined
def drag_density(axes, law, slope, relative):
    """Drag per length of the reference, |r_x| f, into `relative`.

    Args:
        axes: (0, 1) or (0, 1, 2): its length is the space dimension, a compile-time constant.
        law: (2, 3): c_n, c_t [kg/m^2], 0; the velocity u of the flow [m/s].
        slope: (3,) r_x [-].
        relative: (3,) r_t [m/s], then |r_x| f [N/m].
    """
    square, along, speed = 0.0, 0.0, 0.0
    for i in range(len(axes)):
        relative[i] -= law[FLOW, i]
        square += slope[i] * slope[i]
        along += slope[i] * relative[i]
    stretch = math.sqrt(square)
    along /= square
    for i in range(len(axes)):
        relative[i] -= along * slope[i]
        speed += relative[i] * relative[i]
    normal = law[COEFFICIENTS, 0] * math.sqrt(speed) * stretch
    tangential = law[COEFFICIENTS, 1] * abs(along) * square * along
    for i in range(len(axes)):
        relative[i] = -normal * relative[i] - tangential * slope[i]


@inlined
def add_drag_force(axes, table, law, differences, rates, memory, force):
    """force += int S |r_x| f dx.

    Args:
        axes: as for `drag_density`.
        table: (4, 8) `drag_table`.   law: as for `drag_density`.
        differences: (3, dim) e = (d, s_left, s_right) [m, -, -].
        rates: (4, dim) velocities of (r, r_x) left and right [m/s, 1/s].
        memory: (2, 3) local array.
        force: (4, dim) generalised force on (r, r_x) left and right, added to [N, Nm].
    """
    for g in range(table.shape[0]):
        for i in range(len(axes)):
            memory[TANGENT, i] = (
                table[g, 5] * differences[0, i]
                + table[g, 6] * differences[1, i]
                + table[g, 7] * differences[2, i]
            )
            memory[RELATIVE, i] = (
                table[g, 1] * rates[0, i]
                + table[g, 2] * rates[1, i]
                + table[g, 3] * rates[2, i]
                + table[g, 4] * rates[3, i]
            )
        drag_density(axes, law, memory[TANGENT], memory[RELATIVE])
        for a in range(4):
            for i in range(len(axes)):
                force[a, i] += table[g, 0] * table[g, 1 + a] * memory[RELATIVE, i]
