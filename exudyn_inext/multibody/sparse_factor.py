"""L D L^T of a sparse symmetric matrix whose pattern never changes, in an order found once.

No pivoting: it exists in any order for matrices that are definite, or positive definite on some unknowns and
negative definite on the others (quasidefinite, R. J. Vanderbei, SIAM J. Optimization 5 (1995) 100-113).
A column's rows that follow each other are a run: what a column does to later ones is done run by run.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import inlined
from ..sparse import order_of

FEW = 8  # unknowns whose order does not matter


class SparseFactor(NamedTuple):
    """n unknowns in their order of elimination.

    start: (n + 1,) where each column of L begins in `rows` and `values`, its diagonal first.
    rows: (nnz,).   values: (nnz,) the matrix, then D and L.
    first_run: (n + 1,) of each column.   run: (R + 1,) where each run begins below the diagonal in `rows`.
    into: for each entry below the diagonal and each later run of its column: where in `values` the product
        of both goes.   first_into: (n,) of each column.
    """

    start: np.ndarray
    rows: np.ndarray
    values: Array
    first_run: np.ndarray
    run: np.ndarray
    into: np.ndarray
    first_into: np.ndarray


def find_order(pairs: np.ndarray, number: int) -> np.ndarray:
    """(n,) the place of each unknown, such that few entries are filled; few unknowns as they are.

    pairs: (P, 2) unknowns that meet in an entry.   number: n.
    """
    if number <= FEW:
        return np.arange(number)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    return order_of(rows, columns, number)


def build_factor(pairs: np.ndarray, number: int) -> SparseFactor:
    """Zero matrix.   pairs: (P, 2) places of unknowns that meet.   number: n."""
    columns = _filled(pairs, number)
    sizes = np.array([len(column) for column in columns], dtype=np.int64)
    start = np.concatenate([[0], np.cumsum(sizes)])
    rows = np.fromiter((row for column in columns for row in column), np.int64, start[-1])
    follows = np.zeros(len(rows), dtype=bool)  # the entry before it, in a run
    follows[1:] = np.diff(rows) == 1
    follows[start[:-1]] = False
    follows[(start[:-1] + 1)[sizes > 1]] = False
    is_below = np.ones(len(rows), dtype=bool)
    is_below[start[:-1]] = False
    run = np.flatnonzero(is_below & ~follows)
    first_run = np.searchsorted(run, start)
    key = _keys(start, rows)
    into, first_into = [np.zeros(0, np.int64)], np.zeros(number, np.int64)
    done = 0
    for j in range(number):
        first_into[j] = done
        own = run[first_run[j] : first_run[j + 1]]
        for k in range(len(own) - 1):
            end, later = own[k + 1], rows[own[k + 1 :]]
            wanted = rows[own[k] : end, np.newaxis] * number + later
            into.append(np.searchsorted(key, wanted).ravel())
            done += wanted.size
    return SparseFactor(
        start,
        rows,
        np.zeros(len(rows)),
        first_run,
        np.append(run, len(rows)),
        np.concatenate(into),
        first_into,
    )


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
    """What column j leaves to later ones; it becomes one of L."""
    values, rows, run = factor.values, factor.rows, factor.run
    begin, end = factor.start[j] + 1, factor.start[j + 1]
    inverse = 1.0 / values[begin - 1]
    into = factor.first_into[j]
    last = factor.first_run[j + 1]
    for r in range(factor.first_run[j], last):
        stop = min(run[r + 1], end)
        for a in range(run[r], stop):
            multiple = values[a] * inverse
            target = factor.start[rows[a]] - a
            for i in range(a, stop):
                values[target + i] -= multiple * values[i]
            for later in range(r + 1, last):
                target = factor.into[into] - run[later]
                into += 1
                for i in range(run[later], min(run[later + 1], end)):
                    values[target + i] -= multiple * values[i]
    for a in range(begin, end):
        values[a] *= inverse


@inlined
def substitute(factor, x):
    """x = S^-1 x.   x: (n,) in the order of elimination."""
    values, rows, start = factor.values, factor.rows, factor.start
    for j in range(len(x)):
        for i in range(start[j] + 1, start[j + 1]):
            x[rows[i]] -= values[i] * x[j]
    for j in range(len(x) - 1, -1, -1):
        total = x[j] / values[start[j]]
        for i in range(start[j] + 1, start[j + 1]):
            total -= values[i] * x[rows[i]]
        x[j] = total
