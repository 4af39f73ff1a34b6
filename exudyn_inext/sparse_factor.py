"""L D L^T of a sparse symmetric matrix whose pattern never changes, in an order found once.

No pivoting: it exists in any order for matrices that are definite, or positive definite on some unknowns and
negative definite on the others (quasidefinite, R. J. Vanderbei, SIAM J. Optimization 5 (1995) 100-113).
Columns that follow each other and have the same rows below them are a group: what they do to later columns is
summed up first, and then done once (J. W. H. Liu, SIAM Review 34 (1992) 82-109: supernodes).
"""

import heapq
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .arrays import Array
from .compiled import inlined

FEW = 8  # unknowns whose order does not matter
NOTHING = np.zeros(0)


class SparseFactor(NamedTuple):
    """n unknowns in their order of elimination.

    start: (n + 1,) where each column of L begins in `rows` and `values`, its diagonal first.
    rows: (nnz,).   values: (nnz,) the matrix, then D and L.
    begin, end: (n,) first column of the group of each column, and after its last one.
    into: for each group, and each pair of rows below it, where in `values` their product goes.
    first_into: (n,) where that begins for the group of each column.
    sums: (n,) memory.
    """

    start: np.ndarray
    rows: np.ndarray
    values: Array
    begin: np.ndarray
    end: np.ndarray
    into: np.ndarray
    first_into: np.ndarray
    sums: Array


def find_order(pairs: np.ndarray, number: int) -> np.ndarray:
    """(n,) the place of each unknown, such that few entries are filled; few unknowns as they are.

    pairs: (P, 2) unknowns that meet in an entry.   number: n.
    """
    return np.arange(number) if number <= FEW else _order_of(pairs.tobytes(), number)


@lru_cache(maxsize=16)
def _order_of(meetings: bytes, number: int) -> np.ndarray:
    """Unknowns that meet the same ones, as those of a joint do, are one block."""
    pairs = np.frombuffer(meetings, np.int64).reshape(-1, 2)
    meets = [{unknown} for unknown in range(number)]
    for one, other in pairs.tolist():
        meets[one].add(other)
        meets[other].add(one)
    numbers: dict[frozenset[int], int] = {}
    block = np.array([numbers.setdefault(frozenset(own), len(numbers)) for own in meets])
    return places_in_blocks(block, order_of_blocks(block[pairs], len(numbers)))


def places_in_blocks(block: np.ndarray, order: Sequence[int]) -> np.ndarray:
    """(n,) the place of each unknown.   block: (n,) of each.   order: of blocks."""
    place = np.empty(len(block), np.int64)
    place[np.argsort(np.argsort(order)[block], kind="stable")] = np.arange(len(block))
    return place


def order_of_blocks(pairs: np.ndarray, number: int, early: int = 0) -> list[int]:
    """Blocks by least degree; those from number `early` on after their neighbours before it.

    pairs: (P, 2) blocks that meet.   number: of blocks.
    """
    neighbours: list[set[int]] = [set() for _ in range(number)]
    for key in np.unique(pairs @ [number, 1]).tolist():  # blocks meet in many entries
        one, other = divmod(key, number)
        if one != other:
            neighbours[one].add(other)
            neighbours[other].add(one)
    followers = [[other for other in neighbours[one] if other >= early] for one in range(early)]
    waiting = [0] * early + [sum(one < early for one in own) for own in neighbours[early:]]
    todo = [(len(own), one) for one, own in enumerate(neighbours) if not waiting[one]]
    heapq.heapify(todo)
    order: list[int] = []
    is_done = [False] * number
    while todo:
        degree, one = heapq.heappop(todo)
        if is_done[one] or degree != len(neighbours[one]):
            continue
        order.append(one)
        is_done[one] = True
        own = neighbours[one]
        for other in own:
            neighbours[other] |= own
            neighbours[other] -= {one, other}
        for other in followers[one] if one < early else ():
            waiting[other] -= 1
        for other in own.union(followers[one] if one < early else ()):
            if not waiting[other]:
                heapq.heappush(todo, (len(neighbours[other]), other))
    return order


def build_factor(pairs: np.ndarray, number: int) -> SparseFactor:
    """Zero matrix.   pairs: (P, 2) places of unknowns that meet.   number: n."""
    pattern = _pattern_of(pairs.tobytes(), number)
    return pattern._replace(values=np.zeros(len(pattern.rows)), sums=np.zeros(number))


@lru_cache(maxsize=16)
def _pattern_of(pairs: bytes, number: int) -> SparseFactor:
    """Without its own memory."""
    columns = _filled(np.frombuffer(pairs, np.int64).reshape(-1, 2), number)
    sizes = np.array([len(column) for column in columns], dtype=np.int64)
    start = np.concatenate([[0], np.cumsum(sizes)])
    rows = np.fromiter((row for column in columns for row in column), np.int64, start[-1])
    first = _groups(start, rows)
    of_column = np.repeat(np.arange(len(first) - 1), np.diff(first))
    wanted = [np.zeros(0, np.int64)]
    for last in (first[1:] - 1).tolist():
        below = rows[start[last] + 1 : start[last + 1]]
        column = below[:, np.newaxis]
        wanted.append((column * number + below)[column <= below])
    first_into = np.cumsum([len(some) for some in wanted])[:-1]
    return SparseFactor(
        start,
        rows,
        NOTHING,
        first[of_column],
        first[of_column + 1],
        np.searchsorted(_keys(start, rows), np.concatenate(wanted)),
        first_into[of_column],
        NOTHING,
    )


def _groups(start: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(G + 1,) first columns of groups, and n: a column goes on if the next one has its other rows."""
    sizes = np.diff(start)
    following = np.append(rows, -1)[start[:-1] + 1]
    goes_on = (sizes[:-1] == sizes[1:] + 1) & (following[:-1] == np.arange(1, len(sizes)))
    begins = np.ones(len(start), dtype=bool)
    begins[1:-1] = ~goes_on
    return np.flatnonzero(begins)


def _filled(pairs: np.ndarray, number: int) -> list[list[int]]:
    """Rows of all columns of L, by elimination of the graph."""
    below: list[set[int]] = [set() for _ in range(number)]
    for one, other in pairs.tolist():
        if one != other:
            below[min(one, other)].add(max(one, other))
    for column in below:
        if column:
            parent = min(column)
            below[parent] |= column - {parent}
    return [[j, *sorted(column)] for j, column in enumerate(below)]


def places_of(factor: SparseFactor, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Where entries lie in `values`.   columns, rows: (k,) places, rows not above the diagonal."""
    return np.searchsorted(_keys(factor.start, factor.rows), columns * (len(factor.start) - 1) + rows)


def _keys(start: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(nnz,) column times n plus row: rising."""
    number = len(start) - 1
    return np.repeat(np.arange(number), np.diff(start)) * number + rows


@inlined
def eliminate_column(factor, j):
    """What column j leaves to later ones; with the last one of a group, all of it become columns of L."""
    values, start, end = factor.values, factor.start, factor.end[j]
    own = values[start[j] : start[j + 1]]
    inverse = 1.0 / own[0]
    for k in range(j + 1, end):
        later, mine = values[start[k] : start[k + 1]], own[k - j :]
        multiple = mine[0] * inverse
        for i in range(len(later)):
            later[i] -= multiple * mine[i]
    if j == end - 1:
        _eliminate_group(factor, factor.begin[j], end)


@inlined
def _eliminate_group(factor, begin, end):
    """What a group leaves to columns after it."""
    values, start = factor.values, factor.start
    number, into = start[end] - start[end - 1] - 1, factor.first_into[begin]
    for a in range(number):
        sums = factor.sums[a:number]
        for i in range(len(sums)):
            sums[i] = 0.0
        for j in range(begin, end):
            below = values[start[j] + end - j + a : start[j + 1]]
            multiple = below[0] / values[start[j]]
            for i in range(len(sums)):
                sums[i] += multiple * below[i]
        for i in range(len(sums)):
            values[factor.into[into + i]] -= sums[i]
        into += len(sums)
    for j in range(begin, end):
        column = values[start[j] : start[j + 1]]
        inverse = 1.0 / column[0]
        for i in range(1, len(column)):
            column[i] *= inverse


@inlined
def _substitute_forward(factor, x):
    values, start, begin = factor.values, factor.start, 0
    while begin < len(x):
        end = factor.end[begin]
        rows = factor.rows[start[end - 1] + 1 : start[end]]
        sums = factor.sums[: len(rows)]
        for i in range(len(rows)):
            sums[i] = 0.0
        for j in range(begin, end):
            for k in range(j + 1, end):
                x[k] -= values[start[j] + k - j] * x[j]
            below, multiple = values[start[j] + end - j : start[j + 1]], x[j]
            for i in range(len(rows)):
                sums[i] += below[i] * multiple
        for i in range(len(rows)):
            x[rows[i]] -= sums[i]
        begin = end


@inlined
def _substitute_backward(factor, x):
    values, start, end = factor.values, factor.start, len(x)
    while end > 0:
        begin = factor.begin[end - 1]
        rows = factor.rows[start[end - 1] + 1 : start[end]]
        later = factor.sums[: len(rows)]
        for i in range(len(rows)):
            later[i] = x[rows[i]]
        for j in range(end - 1, begin - 1, -1):
            below, total = values[start[j] + end - j : start[j + 1]], x[j] / values[start[j]]
            for k in range(j + 1, end):
                total -= values[start[j] + k - j] * x[k]
            for i in range(len(rows)):
                total -= below[i] * later[i]
            x[j] = total
        end = begin


@inlined
def substitute(factor, x):
    """x = S^-1 x.   x: (n,) in the order of elimination."""
    _substitute_forward(factor, x)
    _substitute_backward(factor, x)
