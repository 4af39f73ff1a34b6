"""Sparse matrices that are built again and again with entries in the same places.

SciPy's own ways to put them together take longer than to solve with them, if they are small.
"""

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from itertools import accumulate
from typing import TypeAlias

import numpy as np
import scipy

from .arrays import Array, SparseArray

Entries: TypeAlias = tuple[np.ndarray, np.ndarray, Array]
"""Rows, rising, columns and values of what is not zero in a matrix."""


class Pattern:
    """Where entries are; those in one place are added.   rows, columns: (E,).   shape: of the matrix."""

    def __init__(self, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> None:
        place, self._slot = np.unique(rows.astype(np.int64) * shape[1] + columns, return_inverse=True)
        self._row, self._column = np.divmod(place, max(shape[1], 1))
        self._shape = shape

    @cached_property
    def _matrix(self) -> SparseArray:
        start = np.searchsorted(self._row, np.arange(self._shape[0] + 1))
        places = self._column.astype(np.int32), start.astype(np.int32)
        return scipy.sparse.csr_array((np.zeros(len(self._column)), *places), shape=self._shape)

    def matrix(self, values: Array) -> SparseArray:
        """Of entries (E,); zeros among them are kept."""
        result = copy(self._matrix)  # shares the places, which are checked once
        result.data = self._sums(values)
        return result

    def entries(self, values: Array) -> Entries:
        """The same without SciPy's matrices, which take long to import."""
        return self._row, self._column, self._sums(values)

    def _sums(self, values: Array) -> Array:
        return np.bincount(self._slot, values, len(self._column)).astype(float, copy=False)


def rows_of(matrix: SparseArray) -> np.ndarray:
    """(nnz,) row of each entry."""
    return np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))


def entries_of(matrix: SparseArray, first: int = 0) -> Entries:
    """Of a square matrix whose unknowns are those from `first` on in another one."""
    return rows_of(matrix) + first, matrix.indices + first, matrix.data


def sum_of(parts: Sequence[Entries], size: int) -> SparseArray:
    """(n, n) with the entries of all, whose rows need not rise; those in one place are added."""
    rows, columns, values = map(np.concatenate, zip(*parts, strict=True))
    return scipy.sparse.csr_array((values, (rows, columns)), shape=(size, size))


def block_diagonal(blocks: Sequence[SparseArray]) -> SparseArray:
    """Blocks one after the other; a single one that is not empty is the result."""
    blocks = [block for block in blocks if block.shape != (0, 0)]
    if len(blocks) == 1:
        return blocks[0]
    ends = [0, *accumulate(block.shape[1] for block in blocks)]
    return _one_below_another(blocks, ends[:-1], ends[-1])


def one_below_another(blocks: Sequence[SparseArray]) -> SparseArray:
    """The rows of all blocks; a single one that has any is the result."""
    with_rows = [block for block in blocks if block.shape[0]]
    if len(with_rows) == 1:
        return with_rows[0]
    return _one_below_another(blocks, [0] * len(blocks), blocks[0].shape[1])


def _one_below_another(blocks: Sequence[SparseArray], columns: Sequence[int], width: int) -> SparseArray:
    """columns: where those of each block begin.   width: number of all."""
    ends = [0, *accumulate(block.nnz for block in blocks)]
    indices = [block.indices + first for block, first in zip(blocks, columns, strict=True)]
    start = [*(block.indptr[:-1] + end for block, end in zip(blocks, ends, strict=False)), ends[-1:]]
    places = np.concatenate(indices).astype(np.int32), np.concatenate(start).astype(np.int32)
    data = np.concatenate([block.data for block in blocks])
    return scipy.sparse.csr_array((data, *places), shape=(len(places[1]) - 1, width))


def bordered(model: SparseArray, jacobian: SparseArray) -> tuple[np.ndarray, np.ndarray, Array]:
    """Rows, columns and values of the entries of [B J^T; J 0]."""
    of_rows = rows_of(jacobian)
    below = of_rows + np.int32(jacobian.shape[1])
    rows = np.concatenate([rows_of(model), below, jacobian.indices])
    columns = np.concatenate([model.indices, jacobian.indices, below])
    return rows, columns, np.concatenate([model.data, jacobian.data, jacobian.data])


def order_of(rows: np.ndarray, columns: np.ndarray, number: int) -> np.ndarray:
    """(n,) the place of each unknown in an order of elimination that fills few entries, of least degree.

    rows, columns: (E,) entries of a symmetric pattern.   number: n.
    """
    own = np.arange(number)
    places = np.append(rows, own), np.append(columns, own)
    values = np.append(np.full(len(rows), -1.0), np.full(number, 1.0 + len(rows)))
    options = {"SymmetricMode": True}
    matrix = scipy.sparse.csc_array((values, places), shape=(number, number))
    found = scipy.sparse.linalg.splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
    )
    return np.asarray(found.perm_c, dtype=np.int64)
