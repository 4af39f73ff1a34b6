"""Constraints as quadratic forms: every kind has its values, rates, Jacobian and Hessian by one formula.

    c_r = sum f y_a . y_b + c_0,    y = W x - p(t)

x are the positions and slopes of the nodes in turn, p points that are given or move. A constant vector is a
y with weights of zero.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, SparseArray
from ..cable.link import Motion
from ..sparse import Pattern

_WIDTH = 4  # most weights of a vector: positions and slopes of two nodes


class Kind(NamedTuple):
    """The constraints of one kind, m rows with Y vectors y.

    name: what they are called.
    where: row -> what it holds, with {k} for the name of node k.
    constant: (m,) c_0.
    places, weights: (Y, up to 4) which x each y is made of.
    points: (Y, dim) p at rest.   moving: numbers of vectors, and what their p follows.
    products: row, a, b, f, (E,) each.
    """

    name: str
    where: Callable[[int], str]
    constant: Array
    places: np.ndarray
    weights: Array
    points: Array
    products: tuple[np.ndarray, ...]
    moving: Sequence[tuple[int, Motion]] = ()


class Constraints:
    """c(q, t) = 0 with everything that the index reduction needs, Eqs. (27), (28).

    Coordinates and velocities are (n, 2, dim); the Jacobian's columns are the coordinates in C order.

    Args:
        kinds: each with one row at least.   shape: (n, 2, dim).

    Attributes:
        rows: indices of those of each kind, by its name.   number: of all rows.
    """

    def __init__(self, kinds: Sequence[Kind], shape: tuple[int, ...]) -> None:
        self._kinds, self._nodes, self._dim = kinds, 2 * shape[0], shape[2]
        ends = list(accumulate((len(kind.constant) for kind in kinds), initial=0))
        firsts = list(accumulate((len(kind.places) for kind in kinds), initial=0))
        self.number, vectors, self._ends = ends[-1], firsts[-1], ends
        own: dict[str, list[np.ndarray]] = {}
        for kind, a, b in zip(kinds, ends, ends[1:], strict=False):
            own.setdefault(kind.name, []).append(np.arange(a, b))
        self.rows = {name: np.concatenate(rows) for name, rows in own.items()}
        self._constant = np.zeros(self.number)
        self._places = np.zeros((vectors, _WIDTH), dtype=np.int64)
        self._weights = np.zeros((vectors, _WIDTH))
        self._points = np.zeros((3, vectors, self._dim))
        for kind, end, first in zip(kinds, ends, firsts, strict=False):
            of, width = slice(first, first + len(kind.places)), kind.places.shape[1]
            self._constant[end : end + len(kind.constant)] = kind.constant
            self._places[of, :width], self._weights[of, :width] = kind.places, kind.weights
            self._points[0, of] = kind.points
        counted = list(zip(kinds, ends, firsts, strict=False))
        self._moving = [(first + y, motion) for kind, _, first in counted for y, motion in kind.moving]
        products = [
            (row + end, left + first, right + first, factor)
            for (*_, (row, left, right, factor), _), end, first in counted
        ]
        none = np.zeros(0, dtype=np.int64)
        columns = zip((none,) * 4, *products, strict=True)
        self._row, self._left, self._right, self._factor = map(np.concatenate, columns)

    def _points_at(self, t: float) -> Array:
        """(3, Y, dim) p, p_t, p_tt."""
        if not self._moving:
            return self._points
        points = self._points.copy()
        for vector, motion in self._moving:
            points[:, vector] = motion.at(t)
        return points

    def _vectors(self, x: Array, points: Array) -> Array:
        """(Y, dim) W x - p."""
        own = x.reshape(-1, self._dim)[self._places]
        return np.einsum("yk,yki->yi", self._weights, own) - points

    def _sums(self, a: Array, b: Array) -> Array:
        """(m,) sum f a . b.   a, b: (Y, dim)."""
        products = self._factor * np.einsum("ei,ei->e", a[self._left], b[self._right])
        return np.asarray(np.bincount(self._row, products, self.number), dtype=float)

    def value(self, q: Array, t: float = 0.0) -> Array:
        """c (number,)."""
        y = self._vectors(q, self._points_at(t)[0])
        return self._sums(y, y) + self._constant

    def rate(self, q: Array, v: Array, t: float = 0.0) -> Array:
        """c_q v + c_t (number,)."""
        points = self._points_at(t)
        y, y_t = self._vectors(q, points[0]), self._vectors(v, points[1])
        return self._sums(y, y_t) + self._sums(y_t, y)

    def gamma(self, q: Array, v: Array, t: float = 0.0) -> Array:
        """-(c_q v)_q v - 2 c_qt v - c_tt (number,)."""
        points = self._points_at(t)
        y, y_t, p_tt = self._vectors(q, points[0]), self._vectors(v, points[1]), points[2]
        return self._sums(y, p_tt) + self._sums(p_tt, y) - 2.0 * self._sums(y_t, y_t)

    @cached_property
    def _derivatives(self) -> tuple[Pattern, Array, np.ndarray]:
        """Places and factors of dc / dx, and the other vector of the product that they multiply."""
        of, other = np.append(self._left, self._right), np.append(self._right, self._left)
        entry, k = np.nonzero(self._weights[of])
        factor = np.tile(self._factor, 2)[entry] * self._weights[of[entry], k]
        rows = np.repeat(np.tile(self._row, 2)[entry], self._dim)
        pattern = Pattern(rows, self._coordinates(self._places[of[entry], k]), (self.number, self._size))
        return pattern, factor, other[entry]

    def _coordinates(self, places: np.ndarray) -> np.ndarray:
        """(e dim,) of positions or slopes (e,)."""
        return (self._dim * places[:, None] + np.arange(self._dim)).ravel()

    @property
    def _size(self) -> int:
        return self._nodes * self._dim

    def jacobian(self, q: Array, t: float = 0.0) -> SparseArray:
        """c_q (number, n_dof)."""
        pattern, factor, other = self._derivatives
        entries = factor[:, None] * self._vectors(q, self._points_at(t)[0])[other]
        return pattern.matrix(entries.ravel())

    @cached_property
    def _second_derivatives(self) -> tuple[Pattern, Array, np.ndarray]:
        """Places and factors of d2c / dx2, and the constraint of each."""
        weights = self._weights[self._left][:, :, None] * self._weights[self._right][:, None, :]
        entry, k, m = np.nonzero(weights)
        left, right = (
            self._coordinates(self._places[vectors[entry], j])
            for vectors, j in ((self._left, k), (self._right, m))
        )
        pattern = Pattern(np.append(left, right), np.append(right, left), (self._size, self._size))
        factor = np.tile(np.repeat(self._factor[entry] * weights[entry, k, m], self._dim), 2)
        return pattern, factor, np.tile(np.repeat(self._row[entry], self._dim), 2)

    def hessian(self, multipliers: Array) -> SparseArray:
        """sum_r multipliers_r d2c_r/dq2 (n_dof, n_dof), constant in q."""
        pattern, factor, row = self._second_derivatives
        return pattern.matrix(factor * multipliers[row])

    def describe(self, row: int, node_names: Sequence[Any]) -> tuple[str, str]:
        """The kind of equation `row`, and where it acts, for messages; node_names: (n,) of the nodes."""
        k = next(k for k, end in enumerate(self._ends[1:]) if row < end)
        kind = self._kinds[k]
        return kind.name, kind.where(row - self._ends[k]).format(*node_names)
