"""Damping of contact, implicit: a symmetric matrix beside the effective mass of each element that touches.

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


@optional("contact")
def add_contact_mass(axes, nodes, elements, k, first, block):
    """block += that of element k on its left node (first = 0) or right one (4); lower triangle."""
    element = elements[k]
    if element.touches:
        for i in range(SIDE):
            for j in range(i + 1):
                block[i, j] += element.contact[first + i, first + j]


@optional("contact")
def couple_by_contact(axes, nodes, elements, k, w):
    """w += that of element k between its nodes."""
    element = elements[k]
    if element.touches:
        for i in range(SIDE):
            for j in range(SIDE):
                w[i, j] += element.contact[i, SIDE + j]
