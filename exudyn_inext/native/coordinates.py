"""Where the coordinates of an mbs lie in the parts of a coupled system."""

from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from ..arrays import Array


class CoordinateMap:
    """Between coordinates of the parts, one after the other, and the system vector of an mbs.

    A coordinate may stand twice (first and last node of a closed cable): values then come from the first
    one, and forces and Jacobians go to it.

    indices, reference: (n,) of all parts.   slices: of the parts.
    of_forces: (n,) as the indices, with -1 for coordinates that stand there already.
    """

    def __init__(self, size: int, parts: Sequence[tuple[np.ndarray, Array]]) -> None:
        """size: number of second order coordinates of the mbs.

        parts: of each one (n,) places in the system vector, and what separates its coordinates from Exudyn's
            displacements.
        """
        sizes = [len(indices) for indices, _ in parts]
        ends = [0, *accumulate(sizes)]
        self.size = size
        self.indices = np.concatenate([indices for indices, _ in parts]).astype(int)
        self.reference = np.concatenate([reference for _, reference in parts])
        self.slices = [slice(a, b) for a, b in pairwise(ends)]
        first = np.full(size, -1)
        first[self.indices[::-1]] = np.arange(len(self.indices))[::-1]
        self._first = first
        again = np.flatnonzero(first[self.indices] != np.arange(len(self.indices)))
        self.of_forces = self.indices.copy()
        self.of_forces[again] = -1
        self._own = np.flatnonzero(self.of_forces >= 0) if len(again) else slice(None)
        self._into = self.indices[self._own]
        self._vector = np.zeros(size)
        self._is_all = np.array_equal(self.indices, np.arange(size))  # in the order of the system vector
        self._part_of = np.repeat(np.arange(len(parts)), sizes)

    def displacements(self, q: Array) -> list[float]:
        """(size,) system vector of displacements from coordinates (n,)."""
        return self.rates(q - self.reference)

    def rates(self, v: Array) -> list[float]:
        """(size,) system vector of velocities or accelerations (n,)."""
        if not self._is_all:
            self._vector[self._into] = v[self._own]
            v = self._vector
        return v.tolist()

    def repeat(self, x: Array) -> None:
        """Give coordinates that stand twice the values that they have in their first place, in x (..., n)."""
        again = np.flatnonzero(self.of_forces < 0)
        x[..., again] = x[..., self._first[self.indices[again]]]

    def places(self, coordinates: np.ndarray) -> list[tuple[int, np.ndarray, np.ndarray]]:
        """(part, which of `coordinates` lie in it, their places there), for each part that is met."""
        at = self._first[coordinates]
        parts = np.where(at >= 0, self._part_of[at], -1)
        found = []
        for part in sorted(set(parts.tolist()) - {-1}):
            own = (parts == part).nonzero()[0]
            found.append((part, own, at[own] - self.slices[part].start))
        return found

    def place(self, coordinate: int) -> int:
        """Of a system coordinate in the vectors of all parts; -1 if it lies in none."""
        return int(self._first[coordinate])

    def all_places(self, coordinates: Any) -> np.ndarray:
        """As `place`, of an array or a list."""
        return self._first[np.asarray(coordinates, dtype=int)]

    def missing(self) -> np.ndarray:
        """System coordinates that lie in no part."""
        return np.flatnonzero(self._first < 0)
