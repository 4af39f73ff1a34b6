"""Structured solve of [M C_q^T; C_q 0] [x; lam] = [f; b], Eq. (29), in O(N) operations.

The nodal constraints (18) are eliminated: a slope's increment is x_s = N beta + p, where the columns
of N are transverse to the slope and p, along it, is known from the constraint. What is left has
2 dim unknowns a node, y_k = [r_k, beta_k, lam_(k-1)]: each length multiplier follows all coordinates
that it touches, so that a block tridiagonal LDL^T needs no pivoting. A length constraint over several
elements is carried from node to node and eliminated at its last one.

Everything that a solve needs and gives lies in the records of the chain, see `records`. Inlined parts
take these arrays one by one: unpacking a tuple in the loop would cost reference counts.
"""

import numpy as np

from ..compiled import inlined, kernel, local_array


@inlined
def _set_basis(axes, node):
    """Orthonormal vectors transverse to the slope.

    3D without a branch on the direction: Duff et al., Building an Orthonormal Basis, Revisited,
    Journal of Computer Graphics Techniques 6(1), 2017.
    """
    basis = node.basis
    square = 0.0
    for i in range(len(axes)):
        square += node.slope[i] * node.slope[i]
    inverse = 1.0 / np.sqrt(square)
    x = node.slope[0] * inverse
    y = node.slope[1] * inverse
    if len(axes) == 2:
        basis[0, 0] = -y
        basis[1, 0] = x
    else:
        z = node.slope[2] * inverse
        sign = np.copysign(1.0, z)
        a = -1.0 / (sign + z)
        b = x * y * a
        basis[0, 0] = 1.0 + sign * x * x * a
        basis[1, 0] = sign * b
        basis[2, 0] = -sign * x
        basis[0, 1] = b
        basis[1, 1] = sign + y * y * a
        basis[2, 1] = -y


@inlined
def _add_mass(axes, node, block):
    """block += mass of the node with itself; lower triangle."""
    dim = len(axes)
    for i in range(dim):
        block[i, i] += node.mass[0]
        for j in range(dim - 1):
            block[dim + j, i] += node.mass[1] * node.basis[i, j]
    for j in range(dim - 1):
        block[dim + j, dim + j] += node.mass[2]


@inlined
def _add_gradient(axes, node, element, block):
    """block += Jacobian of the element to the node's left; lower triangle."""
    dim = len(axes)
    for i in range(dim):
        block[2 * dim - 1, i] += element.gradient[2, i]
        for j in range(dim - 1):
            block[2 * dim - 1, dim + j] += node.basis[i, j] * element.gradient[3, i]


@inlined
def _set_coupling(axes, left, element, right, w):
    """w = E: mass between two nodes and Jacobian of the element between them."""
    dim = len(axes)
    for i in range(dim):
        for j in range(dim):
            w[i, j] = 0.0
    for i in range(dim):
        w[i, i] = element.mass[0]
        w[i, 2 * dim - 1] = element.gradient[0, i]
        for j in range(dim - 1):
            w[i, dim + j] = element.mass[1] * right.basis[i, j]
            w[dim + j, i] = element.mass[2] * left.basis[i, j]
    for j in range(dim - 1):
        for m in range(dim - 1):
            product = 0.0
            for i in range(dim):
                product += left.basis[i, j] * right.basis[i, m]
            w[dim + j, dim + m] = element.mass[3] * product
        product = 0.0
        for i in range(dim):
            product += left.basis[i, j] * element.gradient[1, i]
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
def _eliminate(axes, node, block, w, inverse_pivot):
    """L D L^T of the block, W = L^-1 E, and what both leave for the substitutions."""
    size = 2 * len(axes)
    for j in range(size):
        inverse = 1.0 / block[j, j]
        inverse_pivot[j, 0] = inverse
        node.inverse_pivot[j] = inverse
        for i in range(j + 1, size):
            multiple = block[i, j] * inverse
            node.lower[i, j] = multiple
            for r in range(j + 1, i + 1):
                block[i, r] -= multiple * block[r, j]
            for c in range(size):
                w[i, c] -= multiple * w[j, c]
    for i in range(size):
        for c in range(size):
            node.coupling[i, c] = w[i, c] * inverse_pivot[i, 0]


@inlined
def _set_next_block(axes, w, inverse_pivot, block):
    """block = -W^T D^-1 W: what a node leaves to the next one; lower triangle."""
    size = 2 * len(axes)
    for i in range(size):
        for j in range(i + 1):
            product = 0.0
            for r in range(size):
                product += w[r, i] * inverse_pivot[r, 0] * w[r, j]
            block[i, j] = -product


@inlined
def factorise(axes, nodes, elements, q):
    """L D L^T at q (n, 2, dim); the `gradient` of the elements must be set, see `assembly`."""
    size = 2 * len(axes)
    block, w, inverse_pivot = local_array(6, 6), local_array(6, 6), local_array(6, 1)
    for i in range(size):
        for j in range(size):
            block[i, j] = 0.0
            w[i, j] = 0.0
    for k in range(len(nodes)):
        for i in range(len(axes)):
            nodes[k].slope[i] = q[k, 1, i]
        _set_basis(axes, nodes[k])
    for k in range(len(nodes)):
        node = nodes[k]
        _add_mass(axes, node, block)
        if k > 0:
            _add_gradient(axes, node, elements[k - 1], block)
        if k < len(elements):
            _set_coupling(axes, node, elements[k], nodes[k + 1], w)
        handed_on = 0.0
        if not node.ends_group:
            handed_on = _hand_on_multiplier(axes, block, w)
        _eliminate(axes, node, block, w, inverse_pivot)
        _set_next_block(axes, w, inverse_pivot, block)
        block[size - 1, size - 1] += handed_on


@inlined
def _set_along(axes, node, column):
    """p of a node: 2 r_x . (along r_x) = target."""
    square = 0.0
    for i in range(len(axes)):
        square += node.slope[i] * node.slope[i]
    node.along[column] = node.free[1] * node.target[column] / (2.0 * square)


@inlined
def _subtract_along(axes, column, node, position_mass, slope_mass, on_position, on_slope):
    """(on_position, on_slope) -= M p of one node.   on_...: (3, 1) local arrays."""
    for i in range(len(axes)):
        p = node.along[column] * node.slope[i]
        on_position[i, 0] -= position_mass * p
        on_slope[i, 0] -= slope_mass * p


@inlined
def _length_target(axes, column, left, element, right):
    """Target of an element's length constraint less the share of the known p of both nodes."""
    target = element.target[column]
    for i in range(len(axes)):
        target -= left.along[column] * left.slope[i] * element.gradient[1, i]
        target -= right.along[column] * right.slope[i] * element.gradient[3, i]
    return target


@inlined
def reduce_right_hand_side(axes, nodes, elements, column):
    """`solution` = [f_r, N^T f_s, b] less the share of the known p, from `force` and `target`."""
    dim = len(axes)
    on_position, on_slope = local_array(3, 1), local_array(3, 1)
    for k in range(len(nodes)):
        _set_along(axes, nodes[k], column)
    for k in range(len(nodes)):
        node = nodes[k]
        for i in range(dim):
            on_position[i, 0] = node.force[column, 0, i]
            on_slope[i, 0] = node.force[column, 1, i]
        _subtract_along(axes, column, node, node.mass[1], node.mass[2], on_position, on_slope)
        node.solution[column, 2 * dim - 1] = 0.0
        if k > 0:
            m = elements[k - 1].mass
            _subtract_along(axes, column, nodes[k - 1], m[2], m[3], on_position, on_slope)
            node.solution[column, 2 * dim - 1] = _length_target(
                axes, column, nodes[k - 1], elements[k - 1], node
            )
        if k < len(elements):
            m = elements[k].mass
            _subtract_along(axes, column, nodes[k + 1], m[1], m[3], on_position, on_slope)
        for j in range(dim - 1):
            transverse = 0.0
            for i in range(dim):
                transverse += node.basis[i, j] * on_slope[i, 0]
            node.solution[column, dim + j] = node.free[1] * transverse
        for i in range(dim):
            node.solution[column, i] = node.free[0] * on_position[i, 0]


@inlined
def _apply_inverse_lower(axes, columns, node, z):
    """z = L^-1 z of one node."""
    for j in range(2 * len(axes)):
        for i in range(j + 1, 2 * len(axes)):
            for c in range(len(columns)):
                z[c, i] -= node.lower[i, j] * z[c, j]


@inlined
def _apply_inverse_lower_transposed(axes, columns, node, z):
    """z = L^-T z of one node."""
    for i in range(2 * len(axes) - 1, -1, -1):
        for j in range(i):
            for c in range(len(columns)):
                z[c, j] -= node.lower[i, j] * z[c, i]


@inlined
def _substitute_forward(axes, nodes, columns, first):
    size = 2 * len(axes)
    z, passed_on = local_array(2, 6), local_array(2, 6)
    for c in range(len(columns)):
        for i in range(size):
            passed_on[c, i] = 0.0
    for k in range(len(nodes)):
        node = nodes[k]
        for c in range(len(columns)):
            for i in range(size):
                z[c, i] = node.solution[first + c, i] + passed_on[c, i]
                passed_on[c, i] = 0.0
            if not node.ends_group:
                passed_on[c, size - 1] = z[c, size - 1]
                z[c, size - 1] = 0.0
        _apply_inverse_lower(axes, columns, node, z)
        for c in range(len(columns)):
            for i in range(size):
                node.solution[first + c, i] = z[c, i] * node.inverse_pivot[i]
                for r in range(size):
                    passed_on[c, i] -= node.coupling[r, i] * z[c, r]


@inlined
def _substitute_backward(axes, nodes, columns, first):
    size = 2 * len(axes)
    z, right = local_array(2, 6), local_array(2, 6)
    for c in range(len(columns)):
        for i in range(size):
            right[c, i] = 0.0
    for k in range(len(nodes) - 1, -1, -1):
        node = nodes[k]
        for c in range(len(columns)):
            for i in range(size):
                z[c, i] = node.solution[first + c, i]
                for j in range(size):
                    z[c, i] -= node.coupling[i, j] * right[c, j]
        _apply_inverse_lower_transposed(axes, columns, node, z)
        for c in range(len(columns)):
            if not node.ends_group:
                z[c, size - 1] = right[c, size - 1]
            for i in range(size):
                right[c, i] = z[c, i]
                node.solution[first + c, i] = z[c, i]


@inlined
def substitute(axes, nodes, columns, first):
    """Solve for the reduced right-hand sides in `solution`.

    Args:
        axes, nodes: of a chain that is factorised.
        columns: (0,) or (0, 1): how many right-hand sides, as a compile-time constant.
        first: the first of them.
    """
    _substitute_forward(axes, nodes, columns, first)
    _substitute_backward(axes, nodes, columns, first)


@inlined
def expand_solution(axes, nodes, elements, column, x):
    """x = [r, N beta + p] (n, 2, dim), zero where a support holds, and the length multipliers."""
    dim = len(axes)
    for k in range(len(nodes)):
        node = nodes[k]
        for i in range(dim):
            x[k, 0, i] = node.solution[column, i]
            x[k, 1, i] = node.along[column] * node.slope[i]
            for j in range(dim - 1):
                x[k, 1, i] += node.basis[i, j] * node.solution[column, dim + j]
        if k > 0:
            elements[k - 1].multiplier[column] = node.solution[column, 2 * dim - 1]


@kernel
def solve(chain, x):
    """Solve M x + C_q^T lam = f, C_q x = b for column 0 of `force` and `target`.

    Args:
        chain: factorised.
        x: (n, 2, dim) solution; the multipliers are left in the elements.
    """
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    reduce_right_hand_side(axes, nodes, elements, 0)
    substitute(axes, nodes, (0,), 0)
    expand_solution(axes, nodes, elements, 0, x)


@kernel
def apply_mass(chain, x, y):
    """y = M x with the supports taken out.   x, y: (n, 2, dim)."""
    for k in range(len(x)):
        m = chain.nodes[k].mass
        for i in range(len(chain.axes)):
            y[k, 0, i] = m[0] * x[k, 0, i] + m[1] * x[k, 1, i]
            y[k, 1, i] = m[1] * x[k, 0, i] + m[2] * x[k, 1, i]
    for k in range(len(chain.elements)):
        m = chain.elements[k].mass
        for i in range(len(chain.axes)):
            y[k, 0, i] += m[0] * x[k + 1, 0, i] + m[1] * x[k + 1, 1, i]
            y[k, 1, i] += m[2] * x[k + 1, 0, i] + m[3] * x[k + 1, 1, i]
            y[k + 1, 0, i] += m[0] * x[k, 0, i] + m[2] * x[k, 1, i]
            y[k + 1, 1, i] += m[1] * x[k, 0, i] + m[3] * x[k, 1, i]


@kernel
def nodal_multipliers(chain, x, momentum, multiplier):
    """Multipliers of the nodal constraints that `solve` eliminated, from the balance along r_x.

    Args:
        chain: solved for column 0.
        x: (n, 2, dim) what `solve` returned.
        momentum: (n, 2, dim) memory.
        multiplier: (n,) output; zero where a support holds the slope.
    """
    apply_mass(chain, x, momentum)
    elements = chain.elements
    for k in range(len(x)):
        node = chain.nodes[k]
        balance = 0.0
        square = 0.0
        for i in range(len(chain.axes)):
            rest = node.force[0, 1, i] - momentum[k, 1, i]
            if k > 0:
                rest -= elements[k - 1].gradient[3, i] * elements[k - 1].multiplier[0]
            if k < len(elements):
                rest -= elements[k].gradient[1, i] * elements[k].multiplier[0]
            balance += rest * node.slope[i]
            square += node.slope[i] * node.slope[i]
        multiplier[k] = node.free[1] * balance / (2.0 * square)
