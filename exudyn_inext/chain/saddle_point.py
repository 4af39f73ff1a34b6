"""Structured solve of [M C_q^T; C_q 0] [x; lam] = [f; b], Eq. (29), in O(N) operations.

The nodal constraints (18) are eliminated: a slope's increment is x_s = N beta + p, where the columns
of N are transverse to the slope and p, along it, is known from the constraint. What is left has
2 dim unknowns a node, y_k = [r_k, beta_k, lam_(k-1)]: each length multiplier follows all coordinates
that it touches, so that a block tridiagonal LDL^T needs no pivoting. A length constraint over several
elements is carried from node to node and eliminated at its last one.
"""

from typing import NamedTuple

import numpy as np

from ..compiled import inlined, kernel, local_array
from ..element.shape_functions import Array
from .chain import Chain


class Factor(NamedTuple):
    """L D L^T of the reduced saddle-point matrix at one configuration.

    gradient: (N, 4, dim) length constraint Jacobian on r_left, s_left, r_right, s_right.
    slope: (n, dim) slopes of the configuration.
    basis: (n, dim, dim - 1) orthonormal vectors transverse to the slopes.
    lower: (n, 2 dim, 2 dim) unit lower factor L of each diagonal block.
    inverse_pivot: (n, 2 dim) inverse of D.
    coupling: (n, 2 dim, 2 dim) D^-1 L^-1 E, where E couples node k with node k + 1.
    solution: (n, 2, 2 dim) two right-hand sides, then their solutions.
    along: (n, 2) known increments along the slope, p = along * slope, for both.
    """

    gradient: Array
    slope: Array
    basis: Array
    lower: Array
    inverse_pivot: Array
    coupling: Array
    solution: Array
    along: Array


def allocate(chain: Chain) -> Factor:
    """Memory for the factor of `chain`; nothing is allocated after this."""
    nodes, dim = len(chain.free), len(chain.axes)
    size = 2 * dim
    return Factor(
        gradient=np.zeros((nodes - 1, 4, dim)),
        slope=np.zeros((nodes, dim)),
        basis=np.zeros((nodes, dim, dim - 1)),
        lower=np.zeros((nodes, size, size)),
        inverse_pivot=np.zeros((nodes, size)),
        coupling=np.zeros((nodes, size, size)),
        solution=np.zeros((nodes, 2, size)),
        along=np.zeros((nodes, 2)),
    )


@inlined
def _set_basis(axes, slope, k, basis):
    """Orthonormal vectors transverse to the slope of node k.

    3D without a branch on the direction: Duff et al., Building an Orthonormal Basis, Revisited,
    Journal of Computer Graphics Techniques 6(1), 2017.
    """
    square = 0.0
    for i in range(len(axes)):
        square += slope[k, i] * slope[k, i]
    inverse = 1.0 / np.sqrt(square)
    x = slope[k, 0] * inverse
    y = slope[k, 1] * inverse
    if len(axes) == 2:
        basis[k, 0, 0] = -y
        basis[k, 1, 0] = x
    else:
        z = slope[k, 2] * inverse
        sign = np.copysign(1.0, z)
        a = -1.0 / (sign + z)
        b = x * y * a
        basis[k, 0, 0] = 1.0 + sign * x * x * a
        basis[k, 1, 0] = sign * b
        basis[k, 2, 0] = -sign * x
        basis[k, 0, 1] = b
        basis[k, 1, 1] = sign + y * y * a
        basis[k, 2, 1] = -y


@inlined
def _add_diagonal_block(axes, mass_diagonal, factor, k, block):
    """block += D_k: mass of node k and Jacobian of the element to its left; lower triangle."""
    dim = len(axes)
    for i in range(dim):
        block[i, i] += mass_diagonal[k, 0]
        for j in range(dim - 1):
            block[dim + j, i] += mass_diagonal[k, 1] * factor.basis[k, i, j]
    for j in range(dim - 1):
        block[dim + j, dim + j] += mass_diagonal[k, 2]
    if k > 0:
        for i in range(dim):
            block[2 * dim - 1, i] += factor.gradient[k - 1, 2, i]
            for j in range(dim - 1):
                transverse = factor.basis[k, i, j] * factor.gradient[k - 1, 3, i]
                block[2 * dim - 1, dim + j] += transverse


@inlined
def _set_coupling(axes, mass_coupling, factor, k, w):
    """w = E: mass between nodes k and k + 1, Jacobian of the element between them."""
    dim = len(axes)
    for i in range(dim):
        for j in range(dim):
            w[i, j] = 0.0
    for i in range(dim):
        w[i, i] = mass_coupling[k, 0]
        w[i, 2 * dim - 1] = factor.gradient[k, 0, i]
        for j in range(dim - 1):
            w[i, dim + j] = mass_coupling[k, 1] * factor.basis[k + 1, i, j]
            w[dim + j, i] = mass_coupling[k, 2] * factor.basis[k, i, j]
    for j in range(dim - 1):
        for m in range(dim - 1):
            product = 0.0
            for i in range(dim):
                product += factor.basis[k, i, j] * factor.basis[k + 1, i, m]
            w[dim + j, dim + m] = mass_coupling[k, 3] * product
        product = 0.0
        for i in range(dim):
            product += factor.basis[k, i, j] * factor.gradient[k, 1, i]
        w[dim + j, 2 * dim - 1] = product
    for j in range(2 * dim):
        w[2 * dim - 1, j] = 0.0


@inlined
def _hand_on_multiplier(axes, block, w):
    """Move an unfinished length multiplier to the next node; its slot here becomes void."""
    last = 2 * len(axes) - 1
    for i in range(last):
        w[i, last] += block[last, i]
        block[last, i] = 0.0
    handed_on = block[last, last]
    block[last, last] = 1.0
    return handed_on


@inlined
def _eliminate(axes, block, w, inverse_pivot, k, factor):
    """L D L^T of the block, W = L^-1 E, and what both leave for later."""
    size = 2 * len(axes)
    for j in range(size):
        inverse = 1.0 / block[j, j]
        inverse_pivot[j, 0] = inverse
        factor.inverse_pivot[k, j] = inverse
        for i in range(j + 1, size):
            multiple = block[i, j] * inverse
            factor.lower[k, i, j] = multiple
            for r in range(j + 1, i + 1):
                block[i, r] -= multiple * block[r, j]
            for c in range(size):
                w[i, c] -= multiple * w[j, c]
    for i in range(size):
        for c in range(size):
            factor.coupling[k, i, c] = w[i, c] * inverse_pivot[i, 0]


@inlined
def _next_block(axes, w, inverse_pivot, block):
    """block = -W^T D^-1 W: what node k leaves to node k + 1; lower triangle."""
    size = 2 * len(axes)
    for i in range(size):
        for j in range(i + 1):
            product = 0.0
            for r in range(size):
                product += w[r, i] * inverse_pivot[r, 0] * w[r, j]
            block[i, j] = -product


@kernel
def factorise(chain, q, factor):
    """Factorise at q; the `gradient` of the factor must be set, see `assembly.assemble`.

    Args:
        chain: coefficients, supports taken out.
        q: (n, 2, dim) configuration.
        factor: Factor.
    """
    axes = chain.axes
    size = 2 * len(axes)
    last = len(chain.free) - 1
    block, w, inverse_pivot = local_array(6, 6), local_array(6, 6), local_array(6, 1)
    for i in range(size):
        for j in range(size):
            block[i, j] = 0.0
            w[i, j] = 0.0
    for k in range(last + 1):
        for i in range(len(axes)):
            factor.slope[k, i] = q[k, 1, i]
        _set_basis(axes, factor.slope, k, factor.basis)
    for k in range(last + 1):
        _add_diagonal_block(axes, chain.mass_diagonal, factor, k, block)
        if k < last:
            _set_coupling(axes, chain.mass_coupling, factor, k, w)
        handed_on = 0.0
        if not chain.ends_group[k]:
            handed_on = _hand_on_multiplier(axes, block, w)
        _eliminate(axes, block, w, inverse_pivot, k, factor)
        _next_block(axes, w, inverse_pivot, block)
        block[size - 1, size - 1] += handed_on


@inlined
def _set_along(axes, free, factor, column, nodal_target):
    """p of each node: 2 r_x . (along r_x) = target."""
    for k in range(len(free)):
        square = 0.0
        for i in range(len(axes)):
            square += factor.slope[k, i] * factor.slope[k, i]
        factor.along[k, column] = free[k, 1] * nodal_target[k] / (2.0 * square)


@inlined
def reduce_right_hand_side(chain, factor, column, force, nodal_target, length_target):
    """Reduced right-hand side [f_r, N^T f_s, b] less the share of the known p.

    Args:
        chain, factor: as factorised.
        column: 0 or 1, which right-hand side of the factor to set.
        force: (n, 2, dim) on positions and slopes.
        nodal_target: (n,) of the nodal constraints (18).
        length_target: (N,) of the length constraints (19), the share of each element.
    """
    axes, dim, last = chain.axes, len(chain.axes), len(chain.free) - 1
    slope, along, m, y = factor.slope, factor.along, chain.mass_coupling, factor.solution
    _set_along(axes, chain.free, factor, column, nodal_target)
    for k in range(last + 1):
        target = 0.0
        if k > 0:
            target = length_target[k - 1]
        for j in range(dim - 1):
            y[k, column, dim + j] = 0.0
        for i in range(dim):
            here = along[k, column] * slope[k, i]
            on_position = force[k, 0, i] - chain.mass_diagonal[k, 1] * here
            on_slope = force[k, 1, i] - chain.mass_diagonal[k, 2] * here
            if k > 0:
                left = along[k - 1, column] * slope[k - 1, i]
                on_position -= m[k - 1, 2] * left
                on_slope -= m[k - 1, 3] * left
                target -= factor.gradient[k - 1, 1, i] * left + factor.gradient[k - 1, 3, i] * here
            if k < last:
                right = along[k + 1, column] * slope[k + 1, i]
                on_position -= m[k, 1] * right
                on_slope -= m[k, 3] * right
            y[k, column, i] = chain.free[k, 0] * on_position
            for j in range(dim - 1):
                y[k, column, dim + j] += chain.free[k, 1] * factor.basis[k, i, j] * on_slope
        y[k, column, 2 * dim - 1] = target


@inlined
def _substitute_forward(axes, columns, ends_group, factor):
    size = 2 * len(axes)
    z, passed_on = local_array(2, 6), local_array(2, 6)
    for c in range(len(columns)):
        for i in range(size):
            passed_on[c, i] = 0.0
    for k in range(len(ends_group)):
        for c in range(len(columns)):
            for i in range(size):
                z[c, i] = factor.solution[k, c, i] + passed_on[c, i]
        for c in range(len(columns)):
            passed_on[c, size - 1] = 0.0
            if not ends_group[k]:
                passed_on[c, size - 1] = z[c, size - 1]
                z[c, size - 1] = 0.0
        for j in range(size):
            for i in range(j + 1, size):
                for c in range(len(columns)):
                    z[c, i] -= factor.lower[k, i, j] * z[c, j]
        for c in range(len(columns)):
            for i in range(size):
                product = 0.0
                for r in range(size):
                    product += factor.coupling[k, r, i] * z[c, r]
                passed_on[c, i] = passed_on[c, i] - product if i == size - 1 else -product
                factor.solution[k, c, i] = z[c, i] * factor.inverse_pivot[k, i]


@inlined
def _substitute_backward(axes, columns, ends_group, factor):
    size = 2 * len(axes)
    z, right = local_array(2, 6), local_array(2, 6)
    for c in range(len(columns)):
        for i in range(size):
            right[c, i] = 0.0
    for k in range(len(ends_group) - 1, -1, -1):
        for c in range(len(columns)):
            for i in range(size):
                product = 0.0
                for j in range(size):
                    product += factor.coupling[k, i, j] * right[c, j]
                z[c, i] = factor.solution[k, c, i] - product
        for i in range(size - 1, -1, -1):
            for j in range(i):
                for c in range(len(columns)):
                    z[c, j] -= factor.lower[k, i, j] * z[c, i]
        for c in range(len(columns)):
            if not ends_group[k]:
                z[c, size - 1] = right[c, size - 1]
            for i in range(size):
                right[c, i] = z[c, i]
                factor.solution[k, c, i] = z[c, i]


@kernel
def substitute(axes, columns, ends_group, factor):
    """Solve for the right-hand sides that are set in the factor.

    Args:
        axes: (0, 1) or (0, 1, 2).   columns: (0,) or (0, 1); both lengths are compile-time constants.
        ends_group: (n,) see Chain.
        factor: Factor; its `solution` is overwritten.
    """
    _substitute_forward(axes, columns, ends_group, factor)
    _substitute_backward(axes, columns, ends_group, factor)


@inlined
def expand_solution(axes, factor, column, x, length_multiplier):
    """x = [r, N beta + p] (n, 2, dim) and multipliers (N,) from solution `column` of the factor."""
    dim = len(axes)
    for k in range(len(x)):
        for i in range(dim):
            x[k, 0, i] = factor.solution[k, column, i]
            increment = factor.along[k, column] * factor.slope[k, i]
            for j in range(dim - 1):
                increment += factor.basis[k, i, j] * factor.solution[k, column, dim + j]
            x[k, 1, i] = increment
        if k > 0:
            length_multiplier[k - 1] = factor.solution[k, column, 2 * dim - 1]


@kernel
def solve(chain, factor, force, nodal_target, length_target, x, length_multiplier):
    """Solve M x + C_q^T lam = force, C_q x = target with a factor.

    Args:
        chain, factor: as factorised.
        force, nodal_target, length_target: see `reduce_right_hand_side`.
        x: (n, 2, dim) solution; zero where a support holds.
        length_multiplier: (N,) lam of the constraint that the element belongs to.
    """
    reduce_right_hand_side(chain, factor, 0, force, nodal_target, length_target)
    substitute(chain.axes, (0,), chain.ends_group, factor)
    expand_solution(chain.axes, factor, 0, x, length_multiplier)


@kernel
def apply_mass(chain, x, y):
    """y = M x with the supports taken out.   x, y: (n, 2, dim)."""
    diagonal, coupling = chain.mass_diagonal, chain.mass_coupling
    for k in range(len(x)):
        for i in range(len(chain.axes)):
            y[k, 0, i] = diagonal[k, 0] * x[k, 0, i] + diagonal[k, 1] * x[k, 1, i]
            y[k, 1, i] = diagonal[k, 1] * x[k, 0, i] + diagonal[k, 2] * x[k, 1, i]
    for k in range(len(coupling)):
        m = coupling[k]
        for i in range(len(chain.axes)):
            y[k, 0, i] += m[0] * x[k + 1, 0, i] + m[1] * x[k + 1, 1, i]
            y[k, 1, i] += m[2] * x[k + 1, 0, i] + m[3] * x[k + 1, 1, i]
            y[k + 1, 0, i] += m[0] * x[k, 0, i] + m[2] * x[k, 1, i]
            y[k + 1, 1, i] += m[1] * x[k, 0, i] + m[3] * x[k, 1, i]


@kernel
def nodal_multipliers(chain, factor, force, x, length_multiplier, momentum, multiplier):
    """Multipliers of the nodal constraints that `solve` eliminated, from the balance along r_x.

    Args:
        chain, factor, force, x, length_multiplier: as given to and returned by `solve`.
        momentum: (n, 2, dim) memory.
        multiplier: (n,) output; zero where a support holds the slope.
    """
    apply_mass(chain, x, momentum)
    for k in range(len(x)):
        balance = 0.0
        square = 0.0
        for i in range(len(chain.axes)):
            rest = force[k, 1, i] - momentum[k, 1, i]
            if k > 0:
                rest -= factor.gradient[k - 1, 3, i] * length_multiplier[k - 1]
            if k + 1 < len(x):
                rest -= factor.gradient[k, 1, i] * length_multiplier[k]
            balance += rest * factor.slope[k, i]
            square += factor.slope[k, i] * factor.slope[k, i]
        multiplier[k] = chain.free[k, 1] * balance / (2.0 * square)
