"""From cables with many joints to the unknowns of their nodes, see `nodes`."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..cable.index_reduction import CableSystem
from ..sparse_factor import SparseFactor, order_of_blocks, places_in_blocks, places_of
from .joints import Entries
from .nodes import NONE, Nodes

MANY = 24  # rows on a cable, from which on its nodes are unknowns


class Ends(NamedTuple):
    """Cables whose nodes can be unknowns, by numbers: (n,) `ends_group`, see `records.node_type`."""

    dimension: int
    of_cables: dict[int, np.ndarray]


def ends_of_cables(systems: Sequence[Any], places: Sequence[slice]) -> Ends:
    """Those in chains without links and axial stiffness.

    Args:
        systems: of all cables, see `in_few_chains`.   places: of each cable among the coordinates.
    """
    found: dict[int, np.ndarray] = {}
    dimension, end = 2, 0
    for one in systems:
        offset, end = end, end + one.chain.nodes.size * 2 * len(one.chain.axes)
        is_plain = isinstance(one, CableSystem) and not one.chain.elements["axial"].size
        if is_plain and (not found or len(one.chain.axes) == dimension):
            dimension = len(one.chain.axes)
            ends, size = one.chain.nodes["ends_group"], 2 * dimension
            for cable, place in enumerate(places):
                own = ends[max(0, place.start - offset) // size : max(0, place.stop - offset) // size]
                if offset <= place.start and len(own) * size == place.stop - place.start and own[-1]:
                    found[cable] = own
    return Ends(dimension, found)


class Layout(NamedTuple):
    """Unknowns of the nodes of some cables.

    cables: which ones.   begin: (C + 1,) see `Nodes`.   dimension: of the cables.
    unknown: (K, 2 dim) numbers of unknowns; a multiplier over several elements has one.
    is_owner: (K, 2 dim) False where a later node has the unknown.
    """

    cables: Sequence[int]
    begin: np.ndarray
    dimension: int
    unknown: np.ndarray
    is_owner: np.ndarray


def lay_out(ends: Ends, cables: Sequence[int], first: int) -> Layout:
    """The unknowns of these cables.   first: number of the first one."""
    begin = np.cumsum([0, *(len(ends.of_cables[cable]) for cable in cables)])
    size = 2 * ends.dimension
    is_owner = np.ones((begin[-1], size), dtype=bool)
    for cable, start, end in zip(cables, begin, begin[1:], strict=False):
        is_owner[start:end, -1] = ends.of_cables[cable]
    unknown = first - 1 + np.cumsum(is_owner).reshape(is_owner.shape)
    last = np.where(is_owner[:, -1], np.arange(len(is_owner)), len(is_owner))
    ending = np.minimum.accumulate(last[::-1])[::-1]  # node that ends the group
    unknown[:, -1] = unknown[ending, -1] if len(ending) else 0
    return Layout(cables, begin, ends.dimension, unknown, is_owner)


def _pairs_of_blocks(layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """(K, 2, s, s) unknowns of the rows and columns of each block, NONE where there is no entry."""
    unknown, (number, size) = layout.unknown, layout.unknown.shape
    if not number:
        return (np.zeros((0, 2, size, size), np.int64),) * 2
    following = np.roll(unknown, -1, axis=0)
    shape = (number, 2, size, size)
    rows = np.broadcast_to(unknown[:, None, :, None], shape).copy()
    columns = np.stack([unknown, following], axis=1)[:, :, None, :] + np.zeros(shape, np.int64)
    is_there = np.ones(shape, dtype=bool)
    is_there[:, 0] = np.tri(size, dtype=bool)
    is_there[:, 1, -1] = False
    is_there[layout.begin[1:] - 1, 1] = False
    is_there[layout.begin[:-1], 0, -1] = False
    is_there[:, 0, -1, -1] = False
    rows[~is_there], columns[~is_there] = NONE, NONE
    return rows, columns


class RowsOnNodes(NamedTuple):
    """See `Nodes`.   row, unknown: (E,) unknowns of a row, and of a node that it acts on."""

    entry: np.ndarray
    node: np.ndarray
    base: np.ndarray
    first: np.ndarray
    unknown: np.ndarray
    row: np.ndarray


def rows_on_nodes(
    layout: Layout, entries: Entries, owners: Any, unknown_of_row: dict[int, int]
) -> RowsOnNodes:
    """Rows on the cables of a layout.   owners: of entries."""
    size = 2 * layout.dimension
    found, unknowns, rows = [], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for cable, begin in zip(layout.cables, layout.begin.tolist(), strict=False):
        for e in np.flatnonzero(owners == cable).tolist():
            start, stop = int(entries.begin[e]) // size, -(-int(entries.stop[e]) // size)
            found.append((e, begin + start, begin + stop, start * size, (stop - start) * (size - 1)))
            unknowns.append(layout.unknown[begin + start : begin + stop, :-1].ravel())
            rows.append(np.full(len(unknowns[-1]), unknown_of_row[int(entries.row[e])]))
    table = np.array(found, dtype=np.int64).reshape(-1, 5)
    first = np.cumsum(table[:, 4]) - table[:, 4]
    entry, node, base = table[:, 0].copy(), table[:, 1:3].copy(), table[:, 3].copy()
    return RowsOnNodes(entry, node, base, first, np.concatenate(unknowns), np.concatenate(rows))


def pairs_on_nodes(layout: Layout, rows: RowsOnNodes) -> np.ndarray:
    """(Q, 2) of unknowns that meet on nodes."""
    one, other = (side.ravel() for side in _pairs_of_blocks(layout))
    is_there = one >= 0
    return np.concatenate(
        [np.stack([one[is_there], other[is_there]], axis=1), np.stack([rows.row, rows.unknown], axis=1)]
    )


def order_with_nodes(pairs: np.ndarray, number: int, layout: Layout) -> np.ndarray:
    """(n,) the place of each unknown: few entries are filled, and multipliers follow their coordinates.

    pairs: (P, 2) unknowns that meet in an entry.   number: n.
    """
    coordinates = layout.unknown[:, :-1]
    block = np.full(number, NONE)
    block[coordinates] = np.arange(len(coordinates))[:, None]
    others = np.flatnonzero(block < 0)
    block[others] = len(coordinates) + np.arange(len(others))
    number_of_blocks = len(coordinates) + len(others)
    return places_in_blocks(block, order_of_blocks(block[pairs], number_of_blocks, len(coordinates)))


def build_nodes(
    layout: Layout, rows: RowsOnNodes, starts: np.ndarray, place: np.ndarray, factor: SparseFactor
) -> Nodes:
    """Memory, and where everything goes.

    Args:
        starts: first coordinate of each owner.   place: of each unknown in the factor.
    """
    one, other = _pairs_of_blocks(layout)
    into, is_there = np.full(one.shape, NONE), one >= 0
    into[is_there] = _lower_places(factor, place[one[is_there]], place[other[is_there]])
    number, dim = len(layout.unknown), layout.dimension
    return Nodes(
        dof=starts[list(layout.cables)],
        begin=layout.begin,
        place=place[layout.unknown],
        block=np.zeros(one.shape),
        into=into,
        basis=np.zeros((number, dim, dim - 1)),
        free=np.zeros((number, 2)),
        entry=rows.entry,
        node=rows.node,
        base=rows.base,
        first=rows.first,
        row_into=_lower_places(factor, place[rows.row], place[rows.unknown]),
    )


def _lower_places(factor: SparseFactor, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return places_of(factor, np.minimum(one, other), np.maximum(one, other))
