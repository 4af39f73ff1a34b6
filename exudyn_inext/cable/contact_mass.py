"""Implicit contact: a symmetric matrix beside the mass, or the effective mass, of each element that touches.

What presses a planar cable sets it at each evaluation, see `multibody.implicit_contacts`.
"""

from ..compiled import inlined, optional

SIDE = 4  # coordinates of a node in the plane


@optional("contact")
def clear_contact_mass(axes, nodes, elements):
    """Nothing touches."""
    for k in range(len(elements)):
        element = elements[k]
        if element.touches:
            element.touches = False
            for i in range(2 * SIDE):
                for j in range(2 * SIDE):
                    element.contact[i, j] = 0.0


@inlined
def add_contact_row(nodes, element, k, mass, row):
    """mass b b^T beside the mass of element k.   row: (1, 8) b on its nodes, destroyed."""
    element.touches = True
    for i in range(2 * SIDE):
        row[0, i] *= nodes[k + i // SIDE].free[i % SIDE // 2]
    for i in range(2 * SIDE):
        for j in range(2 * SIDE):
            element.contact[i, j] += mass * row[0, i] * row[0, j]


@inlined
def _transverse(axes, nodes, elements, k, i):
    """The unknown that coordinate i of node k belongs to, and its share of it, see `saddle_point`."""
    return (i, 1.0) if i < 2 else (2, nodes[k].basis[i - 2, 0])


@optional("axial", otherwise=_transverse)
def _unknown(axes, nodes, elements, k, i):
    """With axial stiffness, coordinates are unknowns."""
    return i, 1.0


@inlined
def _add_part(axes, nodes, elements, k, left, right, block):
    """block += that of element k between its nodes k + left and k + right."""
    for i in range(SIDE):
        row, share = _unknown(axes, nodes, elements, k + left, i)
        for j in range(SIDE):
            column, weight = _unknown(axes, nodes, elements, k + right, j)
            block[row, column] += share * weight * elements[k].contact[SIDE * left + i, SIDE * right + j]


@optional("contact")
def add_contact_mass(axes, nodes, elements, k, side, block):
    """block += that of element k on its left node (side = 0) or right one (1); lower triangle counts."""
    if elements[k].touches:
        _add_part(axes, nodes, elements, k, side, side, block)


@optional("contact")
def couple_by_contact(axes, nodes, elements, k, w):
    """w += that of element k between its nodes."""
    if elements[k].touches:
        _add_part(axes, nodes, elements, k, 0, 1, w)


@optional("contact")
def subtract_contact_along(axes, nodes, elements, k, column, on_position, on_slope):
    """(on_position, on_slope) -= C p on node k, see `saddle_point`; arguments as there."""
    for side in range(2):
        e = k - side
        if 0 <= e < len(elements) and elements[e].touches:
            for other in range(2):
                node = nodes[e + other]
                for j in range(2):
                    p = node.along[column] * node.slope[j]
                    at = SIDE * other + 2 + j
                    for i in range(2):
                        on_position[i, 0] -= elements[e].contact[SIDE * side + i, at] * p
                        on_slope[i, 0] -= elements[e].contact[SIDE * side + 2 + i, at] * p
