"""How fast each cable and each body of a scene moves.

A light part has no share in the energy of a scene with heavy ones, but it may be what somebody looks at: the
step must resolve the motion of each part, see `watch`. Its error is relative to its own way.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, clear, inlined, kernel
from ..sparse import Entries
from .watch import OF_EXTENT, SMALL

MOTION = ("forces", "speeds", "time", "extent", "floor")  # of each part, see `Watch`
_FORCES, _SPEEDS, _TIME, _EXTENT, _FLOOR = range(5)


class _Mass(NamedTuple):
    """Of n coordinates, some of which have none.

    part: (n,) number of the part of each.   start: (n + 1,) of the rows.   columns, values: of the entries.
    """

    part: np.ndarray
    start: np.ndarray
    columns: np.ndarray
    values: Array


@inlined
def _add_energies(mass, v, factor, energies):
    """energies (P,) += factor v . M v / 2 of each part."""
    for i in range(len(mass.start) - 1):
        total = 0.0
        for k in range(mass.start[i], mass.start[i + 1]):
            total += mass.values[k] * v[mass.columns[k]]
        energies[mass.part[i]] += 0.5 * factor * v[i] * total


@kernel
def _see(mass, way, energies, extent):
    """extent: (P,) that of the way (n,), if it is larger.   energies: (P,) memory."""
    energies.fill(0.0)
    _add_energies(mass, way, 1.0, energies)
    for p in range(len(extent)):
        extent[p] = max(extent[p], energies[p])


@kernel
def _go_on(mass, least, motion, a, v, spins, duration, gone_on):
    """gone_on: (5, P) output, see `MovingParts.going_on`.   least: (P,) extent of a motion."""
    clear(gone_on)
    _add_energies(mass, a, duration, gone_on[_FORCES])
    _add_energies(mass, v, duration, gone_on[_SPEEDS])
    for i in range(len(spins)):
        gone_on[_FORCES, mass.part[i]] += duration * spins[i]
    for p in range(len(least)):
        lasts = motion[_EXTENT, p] > least[p]
        for row in range(_TIME):
            gone_on[row, p] = motion[row, p] + (gone_on[row, p] if lasts else 0.0)
        gone_on[_TIME, p] = motion[_TIME, p] + (duration if lasts else 0.0)
        gone_on[_EXTENT, p] = motion[_EXTENT, p]
        gone_on[_FLOOR, p] = least[p] / OF_EXTENT**2


@kernel
def _find_fastest(least, motion, h, fastest):
    """fastest: (5,) output, see `MovingParts.fastest`."""
    largest, found = -1.0, -1
    for p in range(len(least)):
        forces, speeds, time = motion[_FORCES, p], motion[_SPEEDS, p], motion[_TIME, p]
        if speeds * forces > 0.0:
            squared, extent = forces / speeds, max(motion[_EXTENT, p], motion[_FLOOR, p])
            made = h**2 / 24.0 * squared**1.5 * time
            error = np.sqrt(speeds / (time * extent * squared)) * min(made, made ** (1.0 / 3.0))
            if error > largest:
                largest, found = error, p
    for row in range(len(fastest)):
        fastest[row] = motion[row, found] if found >= 0 else 0.0


class MovingParts:
    """The motion of all parts.

    Args:
        part: (n,) a number for each coordinate, the same for those of one part.
        mass: at the start, of all coordinates that have one.
        length: of the longest cable [m]: of it, an error of `SMALL` counts for nothing.

    motion: (5, P) so far, see `MOTION`.
    """

    def __init__(self, part: np.ndarray, mass: Entries, length: float) -> None:
        numbers, part = np.unique(part, return_inverse=True)
        rows, columns, values = mass
        self._mass = _Mass(part, np.searchsorted(rows, np.arange(len(part) + 1)), columns, values)
        self.motion = np.zeros((len(MOTION), len(numbers)))
        self._least, self._energies = np.zeros((2, len(numbers)))
        self._gone_on, self._fastest = np.zeros_like(self.motion), np.zeros(len(MOTION))
        self._see, self._go_on, self._find = Prepared(_see), Prepared(_go_on), Prepared(_find_fastest)
        self._see(self._mass, np.full(len(part), SMALL * length), self._energies, self._least)

    def see(self, way: Array) -> None:
        """A way x - x_0 (n,), which may be the farthest one so far."""
        self._see(self._mass, way, self._energies, self.motion[_EXTENT])

    def going_on(self, a: Array, v: Array, spins: Array, duration: float) -> Array:
        """The motion after another duration [s] with a, v (n,); what rests has not begun.

        spins: (n,) what a . M a / 2 lacks, at the first coordinate of each body that turns [J/s^2].
        """
        self._go_on(self._mass, self._least, self.motion, a, v, spins, duration, self._gone_on)
        return self._gone_on

    def fastest(self, motion: Array, h: float) -> Array:
        """(5,) motion of the part of which steps of h [s] make the largest error; of none: zeros."""
        self._find(self._least, motion, h, self._fastest)
        return self._fastest
