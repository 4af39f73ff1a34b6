"""Structured solve of [M C_q^T; C_q 0] [x; lam] = [f; b], Eq. (29), in O(N) operations.

The nodal constraints (18) are eliminated: a slope's increment is x_s = N beta + p, where the columns
of N are transverse to the slope and p, along it, is known from the constraint. What is left has
2 dim unknowns a node, y_k = [r_k, beta_k, lam_(k-1)], and is factorised node by node, see `factorisation`.

Everything that a solve needs and gives lies in the records of the chain, see `records`. A node is visited
as rarely as possible: loops over few nodes cost as much as what they do.
"""

import numpy as np

from ..arrays import Array
from ..compiled import clear, inlined, optional
from ..lowered import local_array, subtract_multiple
from .chain import Chain
from .contact_mass import subtract_contact_along
from .factorisation import place_in_lower


@inlined
def _set_along(axes, columns, first, node):
    """p of a node: 2 r_x . (along r_x) = target."""
    square = 0.0
    for i in range(len(axes)):
        square += node.slope[i] * node.slope[i]
    share = node.free[1] / (2.0 * square)
    for c in range(len(columns)):
        node.along[first + c] = share * node.target[first + c]


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
def _set_all_along(axes, nodes, elements, columns, first):
    """`along` of all nodes."""
    for k in range(len(nodes)):
        _set_along(axes, columns, first, nodes[k])


@optional("axial", otherwise=_set_all_along)
def _prepare(axes, nodes, elements, columns, first):
    """With axial stiffness, nothing is known along the slopes before the solve."""


@inlined
def _reduce_constrained(axes, nodes, elements, k, column, c, z):
    """z[c] = [f_r, N^T f_s, b] of node k less the share of the known p, from `force` and `target`."""
    dim = len(axes)
    node = nodes[k]
    on_position, on_slope = local_array(3, 1), local_array(3, 1)
    for i in range(dim):
        on_position[i, 0] = node.force[column, 0, i]
        on_slope[i, 0] = node.force[column, 1, i]
    _subtract_along(axes, column, node, node.mass[1], node.mass[2], on_position, on_slope)
    z[c, 2 * dim - 1] = 0.0
    if k > 0:
        m = elements[k - 1].mass
        _subtract_along(axes, column, nodes[k - 1], m[2], m[3], on_position, on_slope)
        z[c, 2 * dim - 1] = _length_target(axes, column, nodes[k - 1], elements[k - 1], node)
    if k < len(elements):
        m = elements[k].mass
        _subtract_along(axes, column, nodes[k + 1], m[1], m[3], on_position, on_slope)
    subtract_contact_along(axes, nodes, elements, k, column, on_position, on_slope)
    for i in range(dim):
        z[c, i] = node.free[0] * on_position[i, 0]
    for j in range(dim - 1):
        transverse = 0.0
        for i in range(dim):
            transverse += node.basis[i, j] * on_slope[i, 0]
        z[c, dim + j] = node.free[1] * transverse


@inlined
def free_force(axes, nodes, elements, k, column, force):
    """force (2, dim) = f - J^T target of node k of a chain with axial stiffness, supports taken out."""
    node = nodes[k]
    for i in range(len(axes)):
        force[0, i] = node.force[column, 0, i]
        force[1, i] = node.force[column, 1, i] - node.slope[i] * node.target[column]
        if k > 0:
            force[0, i] -= elements[k - 1].gradient[2, i] * elements[k - 1].target[column]
            force[1, i] -= elements[k - 1].gradient[3, i] * elements[k - 1].target[column]
        if k < len(elements):
            force[0, i] -= elements[k].gradient[0, i] * elements[k].target[column]
            force[1, i] -= elements[k].gradient[1, i] * elements[k].target[column]
        force[0, i] *= node.free[0]
        force[1, i] *= node.free[1]


@optional("axial", otherwise=_reduce_constrained)
def _reduce(axes, nodes, elements, k, column, c, z):
    """z[c] = f - J^T target of node k."""
    force = local_array(2, 3)
    free_force(axes, nodes, elements, k, column, force)
    for i in range(len(axes)):
        z[c, i] = force[0, i]
        z[c, len(axes) + i] = force[1, i]


@inlined
def _pass_forward(axes, columns, first, node, z, passed_on):
    """`solution` = D^-1 L^-1 z of a node with what the last one passed on to z; passes on -E^T A^-1 z."""
    size = 2 * len(axes)
    for c in range(len(columns)):
        for i in range(size):
            z[c, i] += passed_on[c, i]
            passed_on[c, i] = 0.0
        if not node.ends_group:
            passed_on[c, size - 1] = z[c, size - 1]
            z[c, size - 1] = 0.0
    for j in range(size):
        for i in range(j + 1, size):
            for c in range(len(columns)):
                z[c, i] -= node.lower[place_in_lower(i, j)] * z[c, j]
    for c in range(len(columns)):
        for i in range(size):
            node.solution[first + c, i] = z[c, i] * node.inverse_pivot[i]
            subtract_multiple(axes + axes, passed_on[c], z[c, i], node.coupling[i])


@inlined
def _pass_backward(axes, columns, first, node, z, right):
    """z = the solution of a node, from its `solution` so far and that of the node to its `right`."""
    size = 2 * len(axes)
    for c in range(len(columns)):
        for i in range(size):
            z[c, i] = node.solution[first + c, i]
            for j in range(size):
                z[c, i] -= node.coupling[i, j] * right[c, j]
    for i in range(size - 1, -1, -1):
        for j in range(i):
            for c in range(len(columns)):
                z[c, j] -= node.lower[place_in_lower(i, j)] * z[c, i]
    for c in range(len(columns)):
        if not node.ends_group:
            z[c, size - 1] = right[c, size - 1]
        for i in range(size):
            right[c, i] = z[c, i]


@inlined
def _expand_constrained(axes, nodes, elements, k, column, c, z, x):
    """x[k] = [r, N beta + p] and the multiplier of the element to the left, from z[c]."""
    dim = len(axes)
    node = nodes[k]
    for i in range(dim):
        x[k, 0, i] = z[c, i]
        x[k, 1, i] = node.along[column] * node.slope[i]
        for j in range(dim - 1):
            x[k, 1, i] += node.basis[i, j] * z[c, dim + j]
    if k > 0:
        elements[k - 1].multiplier[column] = z[c, 2 * dim - 1]


@optional("axial", otherwise=_expand_constrained)
def _expand(axes, nodes, elements, k, column, c, z, x):
    """x[k] = z[c]."""
    for i in range(len(axes)):
        x[k, 0, i] = z[c, i]
        x[k, 1, i] = z[c, len(axes) + i]


@inlined
def substitute_forward(axes, nodes, elements, columns, first):
    """First half of a solve, for the right-hand sides in `force` and `target`; leaves `solution`.

    Args:
        axes, nodes, elements: of a chain that is factorised.
        columns: (0,) or (0, 1): how many right-hand sides, as a compile-time constant.
        first: the first of them.
    """
    z, passed_on = local_array(2, 6), local_array(2, 6)
    clear(passed_on)
    _prepare(axes, nodes, elements, columns, first)
    for k in range(len(nodes)):
        for c in range(len(columns)):
            _reduce(axes, nodes, elements, k, first + c, c, z)
        _pass_forward(axes, columns, first, nodes[k], z, passed_on)


@inlined
def substitute_backward(axes, nodes, columns, first):
    """Second half of a solve, in `solution`; arguments: see `substitute_forward`."""
    z, right = local_array(2, 6), local_array(2, 6)
    clear(right)
    for k in range(len(nodes) - 1, -1, -1):
        _pass_backward(axes, columns, first, nodes[k], z, right)
        for c in range(len(columns)):
            for i in range(2 * len(axes)):
                nodes[k].solution[first + c, i] = z[c, i]


@inlined
def solve_reduced(axes, nodes, columns, x):
    """Solve for reduced right-hand sides that stand in `solution`.

    x: (columns, n, 2 dim) output, the reduced unknowns.   Other arguments: see `substitute_forward`.
    """
    z, passed_on, right = local_array(2, 6), local_array(2, 6), local_array(2, 6)
    clear(passed_on)
    clear(right)
    for k in range(len(nodes)):
        for c in range(len(columns)):
            for i in range(2 * len(axes)):
                z[c, i] = nodes[k].solution[c, i]
        _pass_forward(axes, columns, 0, nodes[k], z, passed_on)
    for k in range(len(nodes) - 1, -1, -1):
        _pass_backward(axes, columns, 0, nodes[k], z, right)
        for c in range(len(columns)):
            for i in range(2 * len(axes)):
                x[c, k, i] = z[c, i]


@inlined
def expand_solution(axes, nodes, elements, column, x):
    """x = [r, N beta + p] (n, 2, dim), zero where a support holds, and the length multipliers."""
    z = local_array(1, 6)
    for k in range(len(nodes)):
        for i in range(2 * len(axes)):
            z[0, i] = nodes[k].solution[column, i]
        _expand(axes, nodes, elements, k, column, 0, z, x)


@inlined
def _expand_backward(axes, nodes, elements, column, x):
    """Second half of a solve for one column, and its solution x (n, 2, dim)."""
    z, right = local_array(2, 6), local_array(2, 6)
    clear(right)
    for k in range(len(nodes) - 1, -1, -1):
        _pass_backward(axes, (0,), column, nodes[k], z, right)
        _expand(axes, nodes, elements, k, column, 0, z, x)


@inlined
def solve_column(axes, nodes, elements, column, x):
    """Solve M x + C_q^T lam = f, C_q x = b for one column of `force` and `target`.

    Args:
        axes, nodes, elements: of a chain that is factorised.
        column: of the right-hand sides.
        x: (n, 2, dim) solution; the multipliers are left in the elements.
    """
    substitute_forward(axes, nodes, elements, (0,), column)
    _expand_backward(axes, nodes, elements, column, x)


@inlined
def _reduce_force_constrained(axes, nodes, elements, k, force, z):
    """z = [f_r, N^T f_s, 0] of node k.   force: (2, dim) on it."""
    dim, node = len(axes), nodes[k]
    for i in range(dim):
        z[i] = node.free[0] * force[0, i]
    for j in range(dim - 1):
        transverse = 0.0
        for i in range(dim):
            transverse += node.basis[i, j] * force[1, i]
        z[dim + j] = node.free[1] * transverse
    z[2 * dim - 1] = 0.0


@optional("axial", otherwise=_reduce_force_constrained)
def _reduce_force(axes, nodes, elements, k, force, z):
    """z = f of node k."""
    for i in range(len(axes)):
        z[i] = nodes[k].free[0] * force[0, i]
        z[len(axes) + i] = nodes[k].free[1] * force[1, i]


@inlined
def _acts(axes, force):
    """Whether there is any.   force: (2, dim)."""
    acts = False
    for i in range(len(axes)):
        acts = acts or force[0, i] != 0.0 or force[1, i] != 0.0
    return acts


@inlined
def solve_for_force(axes, nodes, elements, force, x):
    """Solve M x + C_q^T lam = force, C_q x = 0, of a chain that is factorised.   force, x: (n, 2, dim).

    Nodes before the first one on which the force acts have nothing to pass on.
    """
    size, acts = 2 * len(axes), False
    z, passed_on = local_array(1, 6), local_array(1, 6)
    clear(passed_on)
    for k in range(len(nodes)):
        nodes[k].along[0] = 0.0
        acts = acts or _acts(axes, force[k])
        if acts:
            _reduce_force(axes, nodes, elements, k, force[k], z[0])
            _pass_forward(axes, (0,), 0, nodes[k], z, passed_on)
        else:
            for i in range(size):
                nodes[k].solution[0, i] = 0.0
    _expand_backward(axes, nodes, elements, 0, x)


@inlined
def _solve_twice(axes, nodes, elements, x, y):
    """The same for both columns at once.   x, y: (n, 2, dim) solutions for columns 0 and 1."""
    substitute_forward(axes, nodes, elements, (0, 1), 0)
    z, right = local_array(2, 6), local_array(2, 6)
    clear(right)
    for k in range(len(nodes) - 1, -1, -1):
        _pass_backward(axes, (0, 1), 0, nodes[k], z, right)
        _expand(axes, nodes, elements, k, 0, 0, z, x)
        _expand(axes, nodes, elements, k, 1, 1, z, y)


@optional("axial", otherwise=_solve_twice)
def solve_both_columns(axes, nodes, elements, x, y):
    """With axial stiffness nothing is projected: y = 0."""
    solve_column(axes, nodes, elements, 0, x)
    for k in range(len(nodes)):
        for i in range(len(axes)):
            y[k, 0, i] = 0.0
            y[k, 1, i] = 0.0


@inlined
def multiply_by_mass(nodes, elements, x, y):
    """y = M x with the supports taken out.   nodes, elements: (n, 3), (N, 4) masses; x, y: (n, 2, dim)."""
    for k in range(len(x)):
        m = nodes[k]
        for i in range(x.shape[2]):
            y[k, 0, i] = m[0] * x[k, 0, i] + m[1] * x[k, 1, i]
            y[k, 1, i] = m[1] * x[k, 0, i] + m[2] * x[k, 1, i]
    for k in range(len(elements)):
        m = elements[k]
        for i in range(x.shape[2]):
            y[k, 0, i] += m[0] * x[k + 1, 0, i] + m[1] * x[k + 1, 1, i]
            y[k, 1, i] += m[2] * x[k + 1, 0, i] + m[3] * x[k + 1, 1, i]
            y[k + 1, 0, i] += m[0] * x[k, 0, i] + m[2] * x[k, 1, i]
            y[k + 1, 1, i] += m[1] * x[k, 0, i] + m[3] * x[k, 1, i]


def apply_mass(chain: Chain, x: Array) -> Array:
    """M x with the supports taken out.   x: (n, 2, dim)."""
    own, beside = chain.nodes["mass"].T[..., np.newaxis], chain.elements["mass"].T[..., np.newaxis]
    (r, s), y = (x[:, 0], x[:, 1]), np.empty_like(x)
    y[:, 0], y[:, 1] = own[0] * r + own[1] * s, own[1] * r + own[2] * s
    y[:-1, 0] += beside[0] * r[1:] + beside[1] * s[1:]
    y[:-1, 1] += beside[2] * r[1:] + beside[3] * s[1:]
    y[1:, 0] += beside[0] * r[:-1] + beside[2] * s[:-1]
    y[1:, 1] += beside[1] * r[:-1] + beside[3] * s[:-1]
    return y
