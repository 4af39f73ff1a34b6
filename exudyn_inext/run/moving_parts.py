"""How fast each cable and each body of a scene moves.

A light part has no share in the energy of a scene with heavy ones, but it may be what somebody looks at: the
step must resolve the motion of each part, see `watch`. Its error is relative to its own way.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import clear, inlined, inlined_kernel, kernel
from ..sparse import Entries
from .watch import ALL_IS_WELL, NOW, OF_EXTENT, SMALL, verdict_after_work

MOTION = ("forces", "speeds", "time", "extent", "floor")  # of each part, see `Watch`
_FORCES, _SPEEDS, _TIME, _EXTENT, _FLOOR = range(5)


class Motions(NamedTuple):
    """Of P parts.

    part: (n,) number of the part of each coordinate.
    start, columns, values: (n + 1,), (E,), (E,) rows and entries of the mass, which some do not have.
    least: (P,) extent of a motion.   motion: (5, P) so far, see `MOTION`.   others: memory.
    """

    part: np.ndarray
    start: np.ndarray
    columns: np.ndarray
    values: Array
    least: Array
    motion: Array
    gone_on: Array
    energies: Array
    fastest: Array


@inlined
def _add_energies(parts, v, factor, energies):
    """energies (P,) += factor v . M v / 2 of each part."""
    for i in range(len(parts.start) - 1):
        total = 0.0
        for k in range(parts.start[i], parts.start[i + 1]):
            total += parts.values[k] * v[parts.columns[k]]
        energies[parts.part[i]] += 0.5 * factor * v[i] * total


@inlined_kernel
def see(parts, way):
    """A way x - x_0 (n,), which may be the farthest one so far.   parts: `Motions`."""
    parts.energies.fill(0.0)
    _add_energies(parts, way, 1.0, parts.energies)
    for p in range(len(parts.least)):
        parts.motion[_EXTENT, p] = max(parts.motion[_EXTENT, p], parts.energies[p])


@inlined
def _go_on(parts, a, v, spins, duration):
    """`gone_on` becomes `motion` after another duration [s]."""
    least, motion, gone_on = parts.least, parts.motion, parts.gone_on
    clear(gone_on)
    _add_energies(parts, a, duration, gone_on[_FORCES])
    _add_energies(parts, v, duration, gone_on[_SPEEDS])
    for i in range(len(spins)):
        gone_on[_FORCES, parts.part[i]] += duration * spins[i]
    for p in range(len(least)):
        lasts = motion[_EXTENT, p] > least[p]
        for row in range(_TIME):
            gone_on[row, p] = motion[row, p] + (gone_on[row, p] if lasts else 0.0)
        gone_on[_TIME, p] = motion[_TIME, p] + (duration if lasts else 0.0)
        gone_on[_EXTENT, p] = motion[_EXTENT, p]
        gone_on[_FLOOR, p] = least[p] / OF_EXTENT**2


@inlined
def _find_fastest(least, motion, h, fastest):
    """(5,) motion of the part of which steps of h [s] make the largest error; of none: zeros."""
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


@kernel
def verdict_with_parts(parts, way, spins, h, watch, q, v, a, seen, constant, work, scatter, steps, duration):
    """As `verdict_after_work`, of the fastest part; what rests has not begun to move.

    Args:
        parts: `Motions` so far; they go on if all is well.
        way, v: (n,) x - x_0, which may be the farthest one so far, and velocities, as `seen`.
        spins: (n,) what a . M a / 2 lacks, at the first coordinate of each body that turns [J/s^2].
        h: step [s].   q, a: (n,) present state.   others: see `verdict_after_work`.
    """
    see(parts, way)
    _go_on(parts, a, v, spins, duration)
    _find_fastest(parts.least, parts.gone_on, h, parts.fastest)
    account = watch.account[NOW]
    account.forces, account.speeds = parts.fastest[_FORCES], parts.fastest[_SPEEDS]
    account.time = parts.fastest[_TIME]
    account.extent, account.floor = parts.fastest[_EXTENT], parts.fastest[_FLOOR]
    trouble = verdict_after_work(watch, q, seen, constant, work, scatter, steps, duration)
    if trouble == ALL_IS_WELL:
        for row in range(len(MOTION)):
            for p in range(len(parts.least)):
                parts.motion[row, p] = parts.gone_on[row, p]
    return trouble


def motions_of(part: np.ndarray, mass: Entries, length: float) -> Motions:
    """That of all parts, which have not begun to move.

    Args:
        part: (n,) a number for each coordinate, the same for those of one part.
        mass: at the start, of all coordinates that have one.
        length: of the longest cable [m]: of it, an error of `SMALL` counts for nothing.
    """
    numbers, part = np.unique(part, return_inverse=True)
    rows, columns, values = mass
    start = np.searchsorted(rows, np.arange(len(part) + 1))
    motion, gone_on = np.zeros((2, len(MOTION), len(numbers)))
    least, energies = np.zeros((2, len(numbers)))
    of_parts = least, motion, gone_on, energies, np.zeros(len(MOTION))
    found = Motions(part, start, columns, values, *of_parts)
    see(found, np.full(len(part), SMALL * length))
    least[:], motion[:] = motion[_EXTENT], 0.0
    return found
