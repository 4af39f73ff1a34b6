"""Joints: constraints c(q, t) = 0 between parts, by a Schur complement on the parts' own solves.

With A the saddle-point matrices of all parts, side by side, and J the Jacobian of the joints,

    [A J^T; J 0] [y; nu] = [f; b]:    S nu = J A^-1 f - b,  S = J A^-1 J^T,  y = A^-1 f - A^-1 J^T nu.

Two rows are coupled in S if they meet on a part. In the order of Cuthill and McKee, found once, S is a band:
narrow for trees and chains of parts, as wide as a side for nets.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial, singledispatch
from itertools import groupby, pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..arrays import Array
from ..cable.linear_response import respond
from ..called_system import called
from ..compiled import kernel
from .redundant_rows import PIVOT_TOLERANCE, dependent_rows


@singledispatch
def respond_to_rows(system, first, width, dof, jacobian, response):
    """response_r = A^-1 J_r^T: acceleration of a part, on its own constraints, under a unit joint force.

    Args:
        system: just evaluated by a protocol of `system`, so that it is factorised.
        first, width: (rows,) where each row begins in `jacobian` and `response`, and how long it is.
        dof: (rows,) the first coordinate in the system of the cable or body that the row is on.
        jacobian, response: (sum of the widths of all parts,); output.
    """
    _respond_with_cables(called(system, respond), first, width, dof, jacobian, response)


@kernel
def _respond_with_cables(system, first, width, dof, jacobian, response):
    for row in range(len(first)):
        begin, end = first[row], first[row] + width[row]
        respond(system, dof[row], jacobian[begin:end], response[begin:end])


FEW = 24  # rows whose order does not matter


class JointBlock:
    """Rows of the joints on one part.

    Args:
        system: of the part.   dofs: its place in the coupled vectors.   rows: (k,) which rows.
        whole: see `Part`.

    Attributes:
        jacobian: (k, n_dof), set by whoever knows the joints.   response: (k, n_dof) A^-1 J^T.
    """

    def __init__(self, system: Any, dofs: slice, rows: np.ndarray, whole: Any = None) -> None:
        self.system = system
        self.whole = whole
        self.dofs = dofs
        self.rows = rows
        self.jacobian: Array = np.zeros((len(rows), dofs.stop - dofs.start))
        self.response: Array = np.zeros_like(self.jacobian)


class _Rows(NamedTuple):
    """All blocks, one after the other, for the kernels.

    Entry e of a block's Jacobian starts at `first[e]`, has `width[e]` numbers, belongs to row `row[e]` and to
    the coordinates from `dof[e]` on; the entries of block b end before `end[b]`. In the band it is row
    `place[e]`. What is not zero of it lies from `begin[e]` to `stop[e]`.
    """

    first: np.ndarray
    width: np.ndarray
    row: np.ndarray
    dof: np.ndarray
    end: np.ndarray
    place: np.ndarray
    begin: np.ndarray
    stop: np.ndarray


@dataclass(frozen=True, eq=False)
class JointTerms:
    """Joints at (t, q, v).

    value: c (m,) [m, rad].   drift: c_t (m,).   gamma: -(d2c/dt2 at zero acceleration) (m,), Eq. (27).
    """

    value: Array
    drift: Array
    gamma: Array


class JointSolve:
    """The solve of S.   names: of the rows, for messages.   blocks: J by parts, whose memory is shared."""

    def __init__(self, blocks: Sequence[JointBlock], names: Sequence[str]) -> None:
        self._blocks = blocks
        self._names = names
        self._rows = _rows_of(blocks)
        size = sum(block.jacobian.size for block in blocks)
        self._jacobian, self._response = np.zeros(size), np.zeros(size)
        _share(blocks, self._jacobian, self._response)
        self._responders = list(self._responders_of(blocks))
        entries = np.arange(len(self._rows.row))
        owner = np.searchsorted(self._rows.end, entries, side="right")
        self._order = order_of_band(self._rows.row, owner, len(names))
        self._rows = self._rows._replace(place=np.argsort(self._order)[self._rows.row])
        self._schur: Array = np.zeros((_width_of_band(self._rows), len(names)), order="F")
        self._factor = self._schur

    def _responders_of(self, blocks: Sequence[JointBlock]) -> Iterator[Callable[[], None]]:
        """What sets the responses: one call for all blocks of a whole."""
        begin = 0
        for _, together in groupby(blocks, key=lambda block: id(block.whole or block)):
            alike = list(together)
            end = begin + sum(len(block.rows) for block in alike)
            whole, rows, own = alike[0].whole or alike[0], self._rows, slice(begin, end)
            entries = rows.first[own], rows.width[own], rows.dof[own] - whole.dofs.start
            system = called(whole.system, respond)
            yield partial(respond_to_rows, system, *entries, self._jacobian, self._response)
            begin = end

    def factorise(self) -> None:
        """S of the present Jacobians; the parts are factorised.

        Raises:
            RedundantConstraintError: names the rows that depend on others.
        """
        for respond_now in self._responders:
            respond_now()
        _find_nonzeros(self._rows, self._jacobian)
        _set_schur(self._rows, self._jacobian, self._response, self._schur)
        self._factor, info = scipy.linalg.lapack.dpbtrf(self._schur, lower=1)
        squares = self._factor[0] * self._factor[0]
        if info or not (squares > PIVOT_TOLERANCE * self._schur[0]).all():
            raise dependent_rows(_dense(self._schur, self._order), self._names)

    def times_jacobian(self, x: Array) -> Array:
        """J x (m,).   x: (n,)."""
        result = np.zeros(len(self._names))
        _add_times(self._rows, self._jacobian, x, result)
        return result

    def joint_force(self, nu: Array, dofs: slice) -> Array:
        """J^T nu on one part.   nu: (m,).   dofs: its place."""
        force = np.zeros(dofs.stop - dofs.start)
        for block in self._blocks:
            if block.dofs == dofs:
                force += nu[block.rows] @ block.jacobian
        return force

    def apply(self, x: Array, target: Array) -> Array:
        """x -= A^-1 J^T nu in place, such that J x = target; returns nu (m,)."""
        nu = self.times_jacobian(x) - target
        nu[self._order], _ = scipy.linalg.lapack.dpbtrs(self._factor, nu[self._order], lower=1, overwrite_b=1)
        _subtract_times(self._rows, self._response, nu, x)
        return nu


def _rows_of(blocks: Sequence[JointBlock]) -> _Rows:
    rows = [(row, block.dofs.start, block.jacobian.shape[1]) for block in blocks for row in block.rows]
    row, dof, width = np.array(rows, dtype=np.int64).reshape(-1, 3).T.copy()
    first = np.cumsum(width) - width
    ends = np.cumsum([len(block.rows) for block in blocks], dtype=np.int64)
    return _Rows(first, width, row, dof, ends, place=row, begin=np.zeros_like(row), stop=width.copy())


def order_of_band(row: np.ndarray, owner: np.ndarray, number: int) -> np.ndarray:
    """Rows in an order in which S is a narrow band; few of them as they are.

    row, owner: (E,) of all entries, two of which meet if one part owns both.   number: of rows.
    """
    if number <= FEW:
        return np.arange(number)
    meets = scipy.sparse.coo_array(
        (np.ones(len(row)), (row, owner)), shape=(number, int(owner.max(initial=-1)) + 1)
    )
    return np.asarray(
        scipy.sparse.csgraph.reverse_cuthill_mckee(
            scipy.sparse.csr_array(meets @ meets.T), symmetric_mode=True
        ),
        dtype=np.int64,
    )


def _width_of_band(rows: _Rows) -> int:
    """Of the lower half of S, its diagonal included."""
    of_blocks = [rows.place[a:b] for a, b in pairwise([0, *rows.end]) if b > a]
    return max((int(np.ptp(places)) + 1 for places in of_blocks), default=1)


def _share(blocks: Sequence[JointBlock], jacobian: Array, response: Array) -> None:
    """Let the blocks' arrays be parts of these."""
    start = 0
    for block in blocks:
        end = start + block.jacobian.size
        for name, memory in (("jacobian", jacobian), ("response", response)):
            shared = memory[start:end].reshape(block.jacobian.shape)
            shared[:] = getattr(block, name)
            setattr(block, name, shared)
        start = end


@kernel
def _find_nonzeros(rows, jacobian):
    """`begin` and `stop` of all entries: a joint holds few coordinates of a cable."""
    for e in range(len(rows.row)):
        begin, stop = rows.width[e], 0
        for i in range(rows.width[e]):
            if jacobian[rows.first[e] + i] != 0.0:
                begin, stop = min(begin, i), i + 1
        rows.begin[e], rows.stop[e] = begin, stop


@kernel
def _set_schur(rows, jacobian, response, schur):
    """S = J R^T; the lower half of its band, by columns."""
    schur[:] = 0.0
    begin = 0
    for end in rows.end:
        for e in range(begin, end):
            for f in range(begin, end):
                if rows.place[f] <= rows.place[e]:
                    total = 0.0
                    for i in range(rows.begin[e], rows.stop[e]):
                        total += jacobian[rows.first[e] + i] * response[rows.first[f] + i]
                    schur[rows.place[e] - rows.place[f], rows.place[f]] += total
        begin = end


@kernel
def _add_times(rows, matrix, x, result):
    """result += J x."""
    for e in range(len(rows.row)):
        total = 0.0
        for i in range(rows.begin[e], rows.stop[e]):
            total += matrix[rows.first[e] + i] * x[rows.dof[e] + i]
        result[rows.row[e]] += total


@kernel
def _subtract_times(rows, matrix, nu, x):
    """x -= matrix^T nu."""
    for e in range(len(rows.row)):
        for i in range(rows.width[e]):
            x[rows.dof[e] + i] -= matrix[rows.first[e] + i] * nu[rows.row[e]]


def _dense(band: Array, order: np.ndarray) -> Array:
    """Lower triangle of S, its rows as they are numbered, from its band."""
    size = len(order)
    sorted_: Array = np.zeros((size, size))
    for below, diagonal in enumerate(band):
        places = np.arange(size - below)
        sorted_[places + below, places] = sorted_[places, places + below] = diagonal[: size - below]
    back = np.argsort(order)
    return np.tril(sorted_[np.ix_(back, back)])
