"""Nodes of cables with many joints: unknowns of the joints' factor, beside the forces.

C = J A^-1 J^T of a cable with m joints is dense: m^2 numbers, m solves. With its corrections d = A^-1 J^T nu
as unknowns,

    [-A J^T; J S'] [d; nu] = [0; J y - b],   S' of all other parts,

is sparse, and its factor costs as much as the cable and its joints have nodes and rows. A has 2 dim unknowns
a node, see `cable.saddle_point`. Multipliers follow the coordinates that they act on in the order of
elimination, so that no pivot vanishes: what is left of A among coordinates is positive definite.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.factorisation import add_blocks
from ..compiled import clear, inlined
from ..lowered import local_array

NONE = -1


class Nodes(NamedTuple):
    """K nodes of C cables, and R entries of rows on them.

    dof: (C,) first coordinate of each cable.   begin: (C + 1,) its first one of the K nodes.
    place: (K, 2 dim) of its unknowns, NONE: none, or one of a later node.
    block: (K, 2, 2 dim, 2 dim) of A: a node with itself, lower half, and with the next one.
    into: the same shape, where that goes in the factor, or NONE.
    basis: (K, dim, dim - 1) transverse to slopes.   free: (K, 2) see `records.node_type`.
    entry: (R,).   node: (R, 2) first of its nodes, and after the last.   base: (R,) first coordinate of its
        first node on the cable.   first: (R,) where its places begin in `row_into`, 2 dim - 1 a node.
    """

    dof: np.ndarray
    begin: np.ndarray
    place: np.ndarray
    block: Array
    into: np.ndarray
    basis: Array
    free: Array
    entry: np.ndarray
    node: np.ndarray
    base: np.ndarray
    first: np.ndarray
    row_into: np.ndarray


@inlined
def copy_chain(axes, nodes, elements, block, basis, free):
    """Blocks of A of one cable, and its frames, see `Nodes`.   nodes, elements: of it."""
    dim = len(axes)
    own, coupling = local_array(6, 6), local_array(6, 6)
    for k in range(len(nodes)):
        node = nodes[k]
        clear(own)
        add_blocks(axes, nodes, elements, k, own, coupling)
        for i in range(2 * dim):
            for j in range(2 * dim):
                block[k, 0, i, j] = own[i, j]
                block[k, 1, i, j] = coupling[i, j]
        for i in range(dim):
            for j in range(dim - 1):
                basis[k, i, j] = node.basis[i, j]
        free[k, 0], free[k, 1] = node.free[0], node.free[1]


@inlined
def _add_blocks(held, values, diagonal):
    """values -= A; the `diagonal` of a multiplier is the size of its pivot."""
    size = held.place.shape[1]
    for k in range(len(held.place)):
        for side in range(2):
            for i in range(size):
                for j in range(size):
                    into = held.into[k, side, i, j]
                    if into >= 0:
                        values[into] -= held.block[k, side, i, j]
        for i in range(size - 1):
            mass, before, after = (
                held.block[k, 0, i, i],
                held.block[k, 0, size - 1, i],
                held.block[k, 1, i, size - 1],
            )
            if held.into[k, 0, size - 1, i] >= 0:
                diagonal[held.place[k, size - 1]] += before * before / mass
            if held.into[k, 1, i, size - 1] >= 0:
                diagonal[held.place[k + 1, size - 1]] += after * after / mass


@inlined
def _jacobian_of(entries, e, i):
    """Of coordinate i on its cable; zero outside of the entry."""
    if i < entries.begin[e] or i >= entries.stop[e]:
        return 0.0
    return entries.jacobian[entries.first[e] + i]


@inlined
def _reduced(held, entries, e, k, base, i):
    """Unknown i of node k, the coordinates of which begin at `base`."""
    dim = held.basis.shape[1]
    if i < dim:
        return held.free[k, 0] * _jacobian_of(entries, e, base + i)
    total = 0.0
    for j in range(dim):
        total += held.basis[k, j, i - dim] * _jacobian_of(entries, e, base + dim + j)
    return held.free[k, 1] * total


@inlined
def add_nodes(held, entries, places, values, diagonal):
    """A and J into the factor; the size of J A^-1 J^T added to the `diagonal` (n,) of the rows.

    places: (m,) of the rows.
    """
    _add_blocks(held, values, diagonal)
    dim = held.basis.shape[1]
    for r in range(len(held.entry)):
        e, into, base = held.entry[r], held.first[r], held.base[r]
        place = places[entries.row[e]]
        for k in range(held.node[r, 0], held.node[r, 1]):
            for i in range(2 * dim - 1):
                share = _reduced(held, entries, e, k, base, i)
                values[held.row_into[into + i]] += share
                diagonal[place] += share * share / held.block[k, 0, i, i]
            into += 2 * dim - 1
            base += 2 * dim


@inlined
def add_rates_of_nodes(held, entries, places, x, unknowns):
    """unknowns += J x of the rows on the cables.   x: (n,)."""
    for r in range(len(held.entry)):
        e, total = held.entry[r], 0.0
        first, dof = entries.first[e], entries.dof[e]
        for i in range(entries.begin[e], entries.stop[e]):
            total += entries.jacobian[first + i] * x[dof + i]
        unknowns[places[entries.row[e]]] += total


@inlined
def correct_nodes(held, unknowns, x):
    """x -= d.   x: (n,)."""
    dim = held.basis.shape[1]
    for c in range(len(held.dof)):
        at = held.dof[c]
        for k in range(held.begin[c], held.begin[c + 1]):
            for i in range(dim):
                turn = 0.0
                for j in range(dim - 1):
                    turn += held.basis[k, i, j] * unknowns[held.place[k, dim + j]]
                x[at + i] -= unknowns[held.place[k, i]]
                x[at + dim + i] -= turn
            at += 2 * dim
