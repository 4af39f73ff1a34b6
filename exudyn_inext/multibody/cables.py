"""The cables of a scene: systems one after the other, called by address, and what joints ask of them."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..cable.index_reduction import CableSystem
from ..cable.linear_response import DAMPING, improve_damping, leave_to_joints, respond
from ..called_system import (
    MOST_PROTOCOLS,
    Called,
    addresses_of,
    called,
    called_by_address,
    implements,
    keep_with,
    provide,
)
from ..compiled import inlined, protocol
from ..lowered import COUNT, VECTOR
from ..system import accelerate, accelerate_and_project, correct_position, report_energy
from .nodes import copy_chain


class Cables(NamedTuple):
    """Systems of k chains.

    addresses: (k,), functions: (k, p), see `Called`.
    dofs, inputs: (k + 1,) where the coordinates of each begin, and what it takes as external force.
    """

    addresses: Any
    functions: np.ndarray
    dofs: np.ndarray
    inputs: np.ndarray


def cables_in_a_row(systems: Sequence[Any], inputs: Sequence[int]) -> Cables:
    """These systems, which are kept as long as the table.   inputs: how much external force each takes."""
    protocols = accelerate_and_project, correct_position, report_energy, respond
    row = [called(system, *protocols) for system in systems]
    functions = np.array([one.functions for one in row], np.int64).reshape(len(row), MOST_PROTOCOLS)
    keep_with(functions, row)
    sizes = [system.chain.nodes.size * 2 * len(system.chain.axes) for system in systems]
    ends = (np.cumsum([0, *numbers], dtype=np.int64) for numbers in (sizes, inputs))
    return Cables(addresses_of(row), functions, *ends)


def provide_cables(cables: Cables, systems: Sequence[Any], *protocols: Any) -> None:
    """Let these protocols be called, too, where they are implemented.   systems: those of the cables."""
    for functions, system in zip(cables.functions, systems, strict=True):
        provide(functions, system, *protocols)


def provide_damping(cables: Cables, systems: Sequence[Any]) -> None:
    """Let `improve_damping` be called of those that need it, as joints or dashpots act on them."""
    for functions, system in zip(cables.functions, systems, strict=True):
        if leave_to_joints(system):
            provide(functions, system, improve_damping)


@inlined
def provides(cables, k, place):
    """Whether the protocol at that place of the table can be called of chain k."""
    return cables.functions[k, place] != 0


@inlined
def one_chain(cables, k):
    """Chain k, to be called."""
    return Called(cables.addresses[k], cables.functions[k])


@inlined
def accelerate_cables(cables, external, q, v, duration, stabilises, acceleration, rate):
    """Arguments: see `accelerate`; arrays may be longer."""
    dofs, inputs = cables.dofs, cables.inputs
    for k in range(len(cables.functions)):
        i, j = dofs[k], dofs[k + 1]
        given = external[inputs[k] : inputs[k + 1]], q[i:j], v[i:j], duration, stabilises
        accelerate(one_chain(cables, k), *given, acceleration[i:j], rate[i:j])


@inlined
def correct_cables(cables, external, q, tolerance, learning, correction):
    """Arguments: see `correct_position`; arrays may be longer. The correction is set everywhere."""
    dofs, inputs, worst = cables.dofs, cables.inputs, 0.0
    for k in range(len(cables.functions)):
        i, j = dofs[k], dofs[k + 1]
        moves = external[inputs[k] : inputs[k + 1]]
        violation = correct_position(
            one_chain(cables, k), moves, q[i:j], tolerance, learning, correction[i:j]
        )
        if violation < tolerance:
            for d in range(i, j):
                correction[d] = 0.0
        if not violation <= worst:  # keeps a NaN
            worst = violation
    return worst


@inlined
def respond_with_cables(cables, joints):
    """A^-1 J^T of what the solve holds of cables, see `joints.Holds`, and A of its nodes.

    cables: factorised.   joints: with their Jacobian.
    """
    entries, holds, nodes, k = joints.entries, joints.holds, joints.nodes, 0
    for h in range(holds.on_cables):
        e = holds.entry[h]
        while entries.dof[e] >= cables.dofs[k + 1]:
            k += 1
        first, last = entries.first[e], entries.first[e] + entries.width[e]
        respond(
            one_chain(cables, k),
            entries.dof[e] - cables.dofs[k],
            entries.jacobian[first:last],
            entries.response[first:last],
        )
    k = 0
    for c in range(len(nodes.dof)):
        while nodes.dof[c] >= cables.dofs[k + 1]:
            k += 1
        places = slice(nodes.begin[c], nodes.begin[c + 1])
        show_matrix(
            one_chain(cables, k),
            nodes.dof[c] - cables.dofs[k],
            nodes.block[places].reshape(-1),
            nodes.basis[places].reshape(-1),
            nodes.free[places].reshape(-1),
        )


@inlined
def improve_cables(cables, q, x):
    """`improve_damping` of those that need it, zero of others; whether there are any.   q, x: (n,)."""
    dofs, improves = cables.dofs, False
    for k in range(len(cables.functions)):
        i, j = dofs[k], dofs[k + 1]
        if provides(cables, k, DAMPING):
            improve_damping(one_chain(cables, k), q[i:j], x[i:j])
            improves = True
        else:
            x[i:j] = 0.0
    return improves


@protocol
def show_matrix(system, first, block, basis, free):
    """The matrix of the solve of one cable of a chain, see `nodes.Nodes`.

    Args:
        system: of the chain, factorised.   first: coordinate of the cable in it.
        block, basis, free: output, one number after the other.
    """


called_by_address(show_matrix, COUNT, VECTOR, VECTOR, VECTOR)


@implements(show_matrix, CableSystem)
def show_matrix_of_chain(system, first, block, basis, free):
    axes, number, dim = system.chain.axes, len(free) // 2, len(system.chain.axes)
    left, size = first // (2 * dim), 2 * dim
    nodes = system.chain.nodes[left : left + number]
    elements = system.chain.elements[left : left + number - 1]
    blocks = block.reshape((number, 2, size, size))
    bases = basis.reshape((number, dim, dim - 1))
    copy_chain(axes, nodes, elements, blocks, bases, free.reshape((number, 2)))
