"""Cables, bodies, springs and joints of a scene at rest, as one system of the search for an equilibrium.

Cables know their energy and its derivatives. Of other items only forces are known: the energy falls by the
work that they do along a step, and what they add to the Hessian is found by differences of

    G(q) = J(q)^T nu - F(q)

over those coordinates on which it depends.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..arrays import Array, SparseArray
from ..sparse import Entries, block_diagonal, entries_of, one_below_another, sum_of
from .potential import Potential
from .saddle_point import order_of_elimination
from .static_system import StaticSystem


class Round(NamedTuple):
    """Coordinates that are moved together.

    places: (k,) of them.   rows, columns: (e,) entries of the Jacobian that this tells of.
    """

    places: np.ndarray
    rows: np.ndarray
    columns: np.ndarray


def rounds_of(groups: Iterable[np.ndarray], first_shared: int) -> list[Round]:
    """Rounds in which each row depends on one coordinate at most, of a symmetric Jacobian.

    groups: coordinates of each item, each of which may act on all others of it.
    first_shared: coordinates from this one on are in many groups: rounds of the others leave their rows out.

    Source: A. R. Curtis, M. J. D. Powell, J. K. Reid, IMA J. Applied Mathematics 13 (1974) 117-119. That
    symmetric ones need fewer: M. J. D. Powell, P. L. Toint, SIAM J. Numerical Analysis 16 (1979) 1060-1074.
    """
    reach: dict[int, frozenset[int]] = {}  # rows that a coordinate acts on
    read: dict[int, frozenset[int]] = {}  # and those of them that it is asked for
    for group in groups:
        own = frozenset(group.tolist())
        alone = frozenset(place for place in own if place < first_shared)
        for place in own:
            reach[place] = reach.get(place, frozenset()) | own
            read[place] = read.get(place, frozenset()) | (alone if place in alone else own)
    rounds: list[tuple[list[int], set[int], set[int]]] = []  # places, all that they reach and read
    for place in sorted(reach):
        free = [one for one in rounds if one[1].isdisjoint(read[place]) and one[2].isdisjoint(reach[place])]
        if not free:
            rounds.append(([], set(), set()))
        places, reached, asked = free[0] if free else rounds[-1]
        places.append(place)
        reached |= reach[place]
        asked |= read[place]
    return [_round(places, [sorted(read[place]) for place in places]) for places, _, _ in rounds]


def _round(places: list[int], reached: list[list[int]]) -> Round:
    at = np.array(places, dtype=np.int64)
    return Round(at, np.concatenate(reached), np.repeat(at, [len(rows) for rows in reached]))


STEP = 1e-6  # of differences [m, -]
ROUGH_STEP = 1e-8  # of one-sided ones, near the root of round-off [m, -]
SHARE = 1e-9  # of the usual shift, by which all Hessians are made regular: bodies may be free to turn
INDIFFERENT = -1e-6  # eigenvalue, relative to the usual shift
OF_WAYS = 0.2  # turn as which a way of a body counts that is as long as a cable [-]


class JoinedPotential(StaticSystem):
    """Of a scene; states are (n,).

    Args:
        cables: of the scene, in their order.   others: all other items, see `native.static_scene`.
        start: (n,) where it begins.
    """

    def __init__(self, cables: Sequence[Potential], others: Any, start: Array) -> None:
        self._cables, self._others = cables, others
        ends = np.cumsum([0, *(cable.scale.size for cable in cables)])
        self._places = [slice(a, b) for a, b in pairwise(ends.tolist())]
        self._bodies = slice(int(ends[-1]), len(start))
        coordinates = self._bodies.stop - self._bodies.start
        self._no_rows_of_bodies = [scipy.sparse.csr_array((0, coordinates))] if coordinates else []
        self._number_of_joints = len(others.values(start))
        self._rounds = rounds_of(others.varying, self._bodies.start)
        self.length = max(cable.length for cable in cables)
        self.mass = block_diagonal([*(cable.mass for cable in cables), scipy.sparse.csr_array(others.mass)])
        self.metric = block_diagonal(
            [*(cable.metric for cable in cables), scipy.sparse.csr_array(others.mass)]
        )
        self.order = order_of_elimination(self.metric, self.jacobian(start))
        self._scale = np.ones(len(start))
        for cable, place in zip(cables, self._places, strict=True):
            self._scale[place] = cable.scale
        self._scale[others.turning] = 1.0 / self.length
        self._moves = np.setdiff1d(np.arange(self._bodies.start, len(start)), others.turning)
        self.largest_load = max(*(cable.largest_load for cable in cables), self.size(others.force(start)))
        self.shift = self.largest_load / max(cable.inertia for cable in cables)
        self.indifferent = INDIFFERENT * self.shift + min(cable.indifferent for cable in cables)
        self.round_off = max(cable.round_off for cable in cables)

    def _parts(self, q: Array) -> list[tuple[Potential, Array]]:
        pairs = zip(self._cables, self._places, strict=True)
        return [(cable, q[place].reshape(cable.shape)) for cable, place in pairs]

    def turn_with(self, q: Array) -> None:
        for cable, own in self._parts(q):
            cable.turn_with(own)
        if self._others.slides:
            self._others.turn_with(q)
            self._rounds = rounds_of(self._others.varying, self._bodies.start)

    def fall(self, q: Array, trial: Array) -> float:
        """See `StaticSystem`; other items by the trapezoidal rule."""
        pairs = zip(self._parts(q), self._parts(trial), strict=True)
        of_cables = sum(cable.fall(before, after) for (cable, before), (_, after) in pairs)
        mean = 0.5 * (self._others.force(q) + self._others.force(trial))
        return float(of_cables + (mean * (trial - q)).sum())

    def scale_of_energy(self, q: Array) -> float:
        return (
            sum(cable.scale_of_energy(own) for cable, own in self._parts(q)) + self.largest_load * self.length
        )

    def is_blocked(self, q: Array, trial: Array) -> bool:
        pairs = zip(self._parts(q), self._parts(trial), strict=True)
        inside_out = any(cable.is_blocked(before, after) for (cable, before), (_, after) in pairs)
        return inside_out or self._others.is_blocked(q, trial)

    def turn(self, step: Array) -> float:
        """See `StaticSystem`: what is free to move, as along a cable, would be sent to infinity."""
        of_cables = [cable.turn(own) for cable, own in self._parts(step)]
        ways = OF_WAYS / self.length * np.abs(step[self._moves]).max(initial=0.0)
        return max(*of_cables, float(ways), float(np.abs(step[self._others.turning]).max(initial=0.0)))

    def excursion(self, step: Array) -> float:
        return float(np.abs(step / self._scale).max())

    def bowed(self, q: Array) -> Array:
        return np.concatenate([*(cable.bowed(own).ravel() for cable, own in self._parts(q)), q[self._bodies]])

    def force(self, q: Array) -> Array:
        total = self._others.force(q).copy()
        for (cable, own), place in zip(self._parts(q), self._places, strict=True):
            total[place] += cable.force(own)
        return total

    def size(self, force: Array) -> float:
        return float(np.abs(force * self._scale).max(initial=0.0))

    def least_balanced(self, q: Array, multipliers: Array) -> int:
        """The coordinate with the largest force that multipliers of the constraints leave unbalanced."""
        unbalanced = self.force(q) - self.jacobian(q).T @ multipliers
        return int(np.argmax(np.abs(unbalanced * self._scale)))

    def _euler_parameters(self, q: Array) -> Array:
        """(Q, 4)"""
        return q[self._others.quaternions] + self._others.references

    def values(self, q: Array) -> Array:
        """Of the cables, the Euler parameters, the joints."""
        norms = 0.5 * ((self._euler_parameters(q) ** 2).sum(axis=1) - 1.0)
        return np.concatenate(
            [*(cable.values(own) for cable, own in self._parts(q)), norms, self._others.values(q)]
        )

    def jacobian(self, q: Array) -> SparseArray:
        places, size = self._others.quaternions, len(q)
        of_cables = block_diagonal(
            [*(cable.jacobian(own) for cable, own in self._parts(q)), *self._no_rows_of_bodies]
        )
        found = [of_cables]
        if len(places):
            at = np.repeat(np.arange(len(places)), 4), places.ravel()
            found.append(scipy.sparse.csr_array((self._euler_parameters(q).ravel(), at), (len(places), size)))
        if self._number_of_joints:
            found.append(self._others.jacobian(q))
        return one_below_another(found)

    def strains(self, q: Array) -> Array:
        return np.concatenate([cable.strains(own) for cable, own in self._parts(q)])

    def strain_rows(self, q: Array) -> SparseArray:
        of_cables = (cable.strain_rows(own) for cable, own in self._parts(q))
        return block_diagonal([*of_cables, *self._no_rows_of_bodies])

    def hessian(self, q: Array, multipliers: Array, is_rough: bool = False) -> SparseArray:
        """See `StaticSystem`; slightly regular."""
        own = self._multipliers(multipliers)
        blocks = [cable.hessian(at, lam) for (cable, at), lam in zip(self._parts(q), own, strict=True)]
        first, places = sum(map(len, own)), self._others.quaternions
        of_norms = np.repeat(multipliers[first : first + len(places)], 4)
        self.of_others = self._of_others(q, multipliers[first + len(places) :], is_rough)
        parts = [entries_of(block, place.start) for block, place in zip(blocks, self._places, strict=True)]
        parts += [(places.ravel(), places.ravel(), of_norms), entries_of(self.of_others), self._regular]
        return sum_of(parts, len(q))

    @cached_property
    def _regular(self) -> Entries:
        """Of the mass that makes all Hessians regular."""
        rows, columns, values = entries_of(self.mass)
        return rows, columns, SHARE * self.shift * values

    def _of_others(self, q: Array, nu: Array, is_rough: bool) -> SparseArray:
        """Derivatives of G, by differences; those of forces on bodies along cables by symmetry.

        is_rough: the differences are one-sided, which takes half of the time, and does for a step.
        """
        ahead, back = (ROUGH_STEP, 0.0) if is_rough else (STEP, STEP)
        values = [np.zeros(0)]
        at_q = self._out_of_balance(q, nu) if is_rough and self._rounds else None
        for one in self._rounds:
            moved = q.copy()
            moved[one.places] += ahead
            change = self._out_of_balance(moved, nu)
            moved[one.places] -= ahead + back
            change -= self._out_of_balance(moved, nu) if at_q is None else at_q
            values.append(change[one.rows] / (ahead + back))
        none = np.zeros(0, np.int64)
        rows = np.concatenate([none, *(one.rows for one in self._rounds)])
        columns = np.concatenate([none, *(one.columns for one in self._rounds)])
        entries, first = np.concatenate(values), self._bodies.start
        above = (rows < first) & (columns >= first)
        places = np.append(rows, columns[above]), np.append(columns, rows[above])
        found = scipy.sparse.csr_array((np.append(entries, entries[above]), places), (len(q), len(q)))
        found.eliminate_zeros()
        return found

    def _out_of_balance(self, q: Array, nu: Array) -> Array:
        """G (n,) of other items.   nu: (m,) of joints."""
        return self._others.pulls(q, nu) - self._others.force(q)

    def multipliers_of_cables(self, multipliers: Array) -> list[Array]:
        """Those of the constraints of each cable, which come first."""
        return _parts_of(multipliers, [n for cable in self._cables for n in cable.numbers_of_constraints])

    def _multipliers(self, multipliers: Array) -> list[Array]:
        """Those of the constraints of cables of one kind, which come first."""
        return _parts_of(multipliers, [cable.constraints.number for cable in self._cables])

    def convex_model(self, multipliers: Array, shift: float) -> SparseArray:
        own = self._multipliers(multipliers)
        blocks = [cable.convex_model(lam, shift) for cable, lam in zip(self._cables, own, strict=True)]
        return block_diagonal([*blocks, scipy.sparse.csr_array(shift * self._others.mass)])


def _parts_of(values: Array, numbers: Sequence[int]) -> list[Array]:
    """The first values, so many for each part."""
    return [values[a:b] for a, b in pairwise(accumulate(numbers, initial=0))]
