"""The cable's own constraints (18), (19) as rows, for solvers that keep multipliers themselves."""

from typing import NamedTuple

import numpy as np

from ..compiled import inlined, inlined_kernel, kernel
from ..element.inextensibility import contract, length_gradient, nodal_constraint, nodal_rate
from ..lowered import local_array
from .assembly import differences, leave_targets, set_gradient
from .cable import Cable
from .chain import Chain, build_chain
from .index_reduction import assemble_forces


class ConstraintRows(NamedTuple):
    """A chain and which of its nodes have a nodal constraint.

    chain: coefficients and memory; nothing is held by supports.
    nodal: (m,) nodes with a constraint (18); its rows come first, those of (19) follow.
    number: of rows.
    """

    chain: Chain
    nodal: np.ndarray
    number: int


def build_rows(cable: Cable, held: np.ndarray) -> ConstraintRows:
    """The rows of `cable` where all supports are constraints of somebody else.

    Args:
        cable: without supports and links.
        held: (n, 2, dim) held coordinates; (18) is redundant where they are all of a slope.
    """
    needed: np.ndarray = np.logical_not(np.all(held[:, 1], axis=1))
    if cable.closed:
        needed = np.append(needed[:-1], False)
    nodal = np.flatnonzero(needed)
    return ConstraintRows(build_chain(cable), nodal, len(nodal) + cable.length_constraints)


@inlined
def set_length_gradients(axes, nodes, elements, q):
    """Jacobian of the length of each element at q into the records."""
    e, gradient = local_array(3, 3), local_array(3, 3)
    for k in range(len(elements)):
        differences(axes, q, k, e)
        length_gradient(axes, elements[k].slope_gram, e, gradient)
        set_gradient(axes, nodes[k].free, nodes[k + 1].free, gradient, elements[k].gradient)


@inlined_kernel
def unconstrained_force(chain, external, q, v, force):
    """force = Q_ext + Q_el(q) + Q_damping(q, v), without any constraint.

    Args:
        chain: coefficients and memory.
        external: (n, 2, dim) [N, Nm].
        q, v: (n, 2, dim) coordinates and velocities.
        force: (n, 2, dim) output [N, Nm].
    """
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    assemble_forces(axes, nodes, elements, external, q, v, 0.0, v, leave_targets, 0.0)
    for k in range(len(nodes)):
        for i in range(len(axes)):
            force[k, 0, i] = nodes[k].force[0, 0, i]
            force[k, 1, i] = nodes[k].force[0, 1, i]


@kernel
def constraint_values(rows, q, v, values):
    """Constraints and their rates, Eqs. (18), (19).

    Args:
        rows: which ones.
        q, v: (n, 2, dim) coordinates and velocities.
        values: (2, number) output: c [-, m], c_q v [1/s, m/s].
    """
    axes, nodes, elements = rows.chain.axes, rows.chain.nodes, rows.chain.elements
    row = 0
    for k in rows.nodal:
        values[0, row] = nodal_constraint(axes, q[k, 1])
        values[1, row] = nodal_rate(axes, q[k, 1], v[k, 1])
        row += 1
    e, e_t, gradient = local_array(3, 3), local_array(3, 3), local_array(3, 3)
    value = rate = 0.0
    for k in range(len(elements)):
        differences(axes, q, k, e)
        differences(axes, v, k, e_t)
        length_gradient(axes, elements[k].slope_gram, e, gradient)
        value += 0.5 * contract(axes, e, gradient) - elements[k].reference_length
        rate += contract(axes, e_t, gradient)
        if nodes[k + 1].ends_group:
            values[0, row], values[1, row] = value, rate
            row += 1
            value = rate = 0.0


@kernel
def constraint_jacobian(rows, q, jacobian):
    """Jacobian of the constraints.

    Args:
        rows: which ones.
        q: (n, 2, dim) coordinates.
        jacobian: (number, n, 2, dim) output.
    """
    axes, nodes, elements = rows.chain.axes, rows.chain.nodes, rows.chain.elements
    jacobian[:] = 0.0
    row = 0
    for k in rows.nodal:
        for i in range(len(axes)):
            jacobian[row, k, 1, i] = 2.0 * q[k, 1, i]
        row += 1
    set_length_gradients(axes, nodes, elements, q)
    for k in range(len(elements)):
        if row == len(jacobian):
            break
        add_gradient(axes, elements[k].gradient, jacobian[row, k], jacobian[row, k + 1])
        if nodes[k + 1].ends_group:
            row += 1


@inlined
def add_gradient(axes, gradient, left, right):
    """Add an element's (4, dim) gradient to what belongs to its nodes, (2, dim) each."""
    for i in range(len(axes)):
        left[0, i] += gradient[0, i]
        left[1, i] += gradient[1, i]
        right[0, i] += gradient[2, i]
        right[1, i] += gradient[3, i]
