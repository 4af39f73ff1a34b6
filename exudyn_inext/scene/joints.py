"""Joints: constraints c(q, t) = 0 between parts, by a Schur complement on the parts' own solves.

With A the saddle-point matrices of all parts, side by side, and J the Jacobian of the joints,

    [A J^T; J 0] [y; nu] = [f; b]:    S nu = J A^-1 f - b,  S = J A^-1 J^T,  y = A^-1 f - A^-1 J^T nu.

Two rows are coupled in S if they meet on a part: S is sparse, and factorised as such.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial, singledispatch
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.linear_response import respond
from ..called_system import called
from ..compiled import Prepared, inlined, inlined_kernel, kernel, placed
from ..sparse_factor import SparseFactor, build_factor, eliminate_column, find_order, places_of, substitute
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
    """All blocks, one after the other, and S, for the kernels.

    Entry e of a block's Jacobian starts at `first[e]`, has `width[e]` numbers, belongs to row `row[e]` and to
    the coordinates from `dof[e]` on; the entries of block b end before `end[b]`. What is not zero of it lies
    from `begin[e]` to `stop[e]`.

    jacobian, response: J and A^-1 J^T of all entries.
    into: for each entry, and each one of its block up to it, where in the factor their product goes.
    place: (m,) of each row in the factor.   diagonal, unknowns: (m,) of S, and memory of a solve.
    """

    first: np.ndarray
    width: np.ndarray
    row: np.ndarray
    dof: np.ndarray
    end: np.ndarray
    begin: np.ndarray
    stop: np.ndarray
    jacobian: Array
    response: Array
    into: np.ndarray
    place: np.ndarray
    diagonal: Array
    unknowns: Array
    factor: SparseFactor


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
        self._blocks, self._names = blocks, names
        self._rows = _rows_of(blocks, len(names))
        _share(blocks, self._rows.jacobian, self._rows.response)
        self._responders = list(self._responders_of(blocks))
        rows = placed(self._rows)
        kernels = (_set_factor, _apply, _add_times)
        self._set_factor, self._apply, self._add_times = (partial(Prepared(one), rows) for one in kernels)

    def _responders_of(self, blocks: Sequence[JointBlock]) -> Iterator[Callable[[], None]]:
        """What sets the responses: one call for all blocks of a whole."""
        begin = 0
        for _, together in groupby(blocks, key=lambda block: id(block.whole or block)):
            alike = list(together)
            end = begin + sum(len(block.rows) for block in alike)
            whole, rows, own = alike[0].whole or alike[0], self._rows, slice(begin, end)
            entries = rows.first[own], rows.width[own], rows.dof[own] - whole.dofs.start
            system = called(whole.system, respond)
            yield partial(respond_to_rows, system, *entries, rows.jacobian, rows.response)
            begin = end

    def factorise(self) -> None:
        """S of the present Jacobians; the parts are factorised.

        Raises:
            RedundantConstraintError: names the rows that depend on others.
        """
        for respond_now in self._responders:
            respond_now()
        if not self._set_factor():
            raise dependent_rows(self._dense_schur(), self._names)

    def _dense_schur(self) -> Array:
        """(m, m) its lower triangle."""
        schur: Array = np.zeros((len(self._names), len(self._names)))
        for block in self._blocks:
            schur[np.ix_(block.rows, block.rows)] += block.jacobian @ block.response.T
        return np.tril(schur)

    def times_jacobian(self, x: Array) -> Array:
        """J x (m,).   x: (n,)."""
        result = np.zeros(len(self._names))
        self._add_times(x, result)
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
        nu: Array = -target
        self._apply(x, nu)
        return nu


def _rows_of(blocks: Sequence[JointBlock], number: int) -> _Rows:
    """number: of rows."""
    rows = [(row, block.dofs.start, block.jacobian.shape[1]) for block in blocks for row in block.rows]
    row, dof, width = np.array(rows, dtype=np.int64).reshape(-1, 3).T.copy()
    of_blocks = (block.rows[np.stack(np.tril_indices(len(block.rows)), axis=1)] for block in blocks)
    pairs = np.concatenate([np.zeros((0, 2), np.int64), *of_blocks])
    place = find_order(pairs, number)
    factor = build_factor(place[pairs], number)
    columns, below = np.sort(place[pairs], axis=1).T
    entries, vectors = np.zeros((2, int(width.sum()))), np.zeros((2, number))
    return _Rows(
        first=np.cumsum(width) - width,
        width=width,
        row=row,
        dof=dof,
        end=np.cumsum([len(block.rows) for block in blocks], dtype=np.int64),
        begin=np.zeros_like(row),
        stop=width.copy(),
        jacobian=entries[0],
        response=entries[1],
        into=places_of(factor, columns, below),
        place=place,
        diagonal=vectors[0],
        unknowns=vectors[1],
        factor=factor,
    )


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


@inlined
def _find_nonzeros(rows):
    """`begin` and `stop` of all entries: a joint holds few coordinates of a cable."""
    for e in range(len(rows.row)):
        begin, stop = rows.width[e], 0
        for i in range(rows.width[e]):
            if rows.jacobian[rows.first[e] + i] != 0.0:
                begin, stop = min(begin, i), i + 1
        rows.begin[e], rows.stop[e] = begin, stop


@inlined
def _set_schur(rows):
    """S = J A^-1 J^T, and its diagonal."""
    values, begin, pair = rows.factor.values, 0, 0
    for i in range(len(values)):
        values[i] = 0.0
    for end in rows.end:
        for e in range(begin, end):
            for f in range(begin, e + 1):
                total = 0.0
                for i in range(rows.begin[e], rows.stop[e]):
                    total += rows.jacobian[rows.first[e] + i] * rows.response[rows.first[f] + i]
                values[rows.into[pair]] += total
                pair += 1
        begin = end
    for j in range(len(rows.diagonal)):
        rows.diagonal[j] = values[rows.factor.start[j]]


@kernel
def _set_factor(rows):
    """S and its factor; returns whether all rows are independent."""
    _find_nonzeros(rows)
    _set_schur(rows)
    for j in range(len(rows.diagonal)):
        if not rows.factor.values[rows.factor.start[j]] > PIVOT_TOLERANCE * rows.diagonal[j]:
            return False
        eliminate_column(rows.factor, j)
    return True


@inlined_kernel
def _add_times(rows, x, result):
    """result += J x."""
    for e in range(len(rows.row)):
        total = 0.0
        for i in range(rows.begin[e], rows.stop[e]):
            total += rows.jacobian[rows.first[e] + i] * x[rows.dof[e] + i]
        result[rows.row[e]] += total


@kernel
def _apply(rows, x, nu):
    """x -= A^-1 J^T S^-1 (J x + nu); nu becomes S^-1 (J x + nu)."""
    _add_times(rows, x, nu)
    for r in range(len(nu)):
        rows.unknowns[rows.place[r]] = nu[r]
    substitute(rows.factor, rows.unknowns)
    for r in range(len(nu)):
        nu[r] = rows.unknowns[rows.place[r]]
    for e in range(len(rows.row)):
        for i in range(rows.width[e]):
            x[rows.dof[e] + i] -= rows.response[rows.first[e] + i] * nu[rows.row[e]]
