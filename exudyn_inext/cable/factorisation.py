"""L D L^T of what the elimination of the nodal constraints leaves of Eq. (29), see `saddle_point`.

With the unknowns y_k = [r_k, beta_k, lam_(k-1)] of a node each length multiplier follows all coordinates
that it touches, so that a block tridiagonal LDL^T needs no pivoting. A length constraint over several
elements is carried from node to node and eliminated at its last one.
"""

import numpy as np

from ..compiled import clear, inlined
from ..lowered import local_array, set_multiple, subtract_multiple
from .contact_mass import add_contact_mass, couple_by_contact


@inlined
def set_frame(axes, node, slope):
    """The slope of a node, and what is transverse to it, into its record.   slope: (dim,) r_x."""
    for i in range(len(axes)):
        node.slope[i] = slope[i]
    _set_basis(axes, node)


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
def add_blocks(axes, nodes, elements, k, block, w):
    """block += that of node k, lower triangle; w = what couples it with the next one."""
    _add_mass(axes, nodes[k], block)
    if k > 0:
        _add_gradient(axes, nodes[k], elements[k - 1], block)
        add_contact_mass(axes, nodes, elements, k - 1, 1, block)
    if k < len(elements):
        _set_coupling(axes, nodes[k], elements[k], nodes[k + 1], w)
        add_contact_mass(axes, nodes, elements, k, 0, block)
        couple_by_contact(axes, nodes, elements, k, w)


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
def place_in_lower(i, j):
    """Of L_ij, i > j, in `lower`."""
    return (i * (i - 1) >> 1) + j


@inlined
def _eliminate_unknown(axes, node, block, w, following, j):
    """Column j of L, row j of W = L^-1 E, and its share of -W^T D^-1 W; lower triangles count."""
    unknowns = axes + axes
    size = len(unknowns)
    inverse = 1.0 / block[j, j]
    node.inverse_pivot[j] = inverse
    for i in range(j + 1, size):
        multiple = block[i, j] * inverse
        node.lower[place_in_lower(i, j)] = multiple
        for r in range(j + 1, i + 1):
            block[i, r] -= multiple * block[r, j]
        subtract_multiple(unknowns, w[i], multiple, w[j])
    set_multiple(unknowns, node.coupling[j], inverse, w[j])
    for i in range(size):
        subtract_multiple(unknowns, following[i], w[j, i] * inverse, w[j])


@inlined
def eliminate_node(axes, node, block, w, following):
    """L D L^T of the block, and what the node leaves to the next one, which becomes the block."""
    size = 2 * len(axes)
    clear(following)
    for j in range(size):
        _eliminate_unknown(axes, node, block, w, following, j)
    for i in range(size):
        for j in range(i + 1):
            block[i, j] = following[i, j]


@inlined
def factorise(axes, nodes, elements):
    """Frames of the nodes and Jacobians of the elements must be set, see `assembly`."""
    size = 2 * len(axes)
    block, w, following = local_array(6, 6), local_array(6, 6), local_array(6, 6)
    clear(block)
    clear(w)
    for k in range(len(nodes)):
        node = nodes[k]
        add_blocks(axes, nodes, elements, k, block, w)
        handed_on = 0.0
        if not node.ends_group:
            handed_on = _hand_on_multiplier(axes, block, w)
        eliminate_node(axes, node, block, w, following)
        block[size - 1, size - 1] += handed_on
