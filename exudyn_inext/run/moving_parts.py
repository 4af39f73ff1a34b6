"""How fast each cable and each body of a scene moves.

A light part has no share in the energy of a scene with heavy ones, but it may be what somebody looks at: the
step must resolve the motion of each part, see `watch`. Its error is relative to its own way.
"""

import numpy as np

from ..arrays import Array, SparseArray
from .watch import OF_EXTENT, SMALL

MOTION = ("forces", "speeds", "time", "extent")  # of each part, see `Watch`
_EXTENT = 3


class MovingParts:
    """The motion of all parts.

    Args:
        part: (n,) a number for each coordinate, the same for those of one part.
        mass: (n, n) at the start.
        length: of the longest cable [m]: of it, an error of `SMALL` counts for nothing.

    motion: (4, P) so far, see `MOTION`.
    """

    def __init__(self, part: np.ndarray, mass: SparseArray, length: float) -> None:
        numbers, self._part = np.unique(part, return_inverse=True)
        self._mass = mass
        self.motion = np.zeros((len(MOTION), len(numbers)))
        self._least = self._energies(np.full(len(part), SMALL * length))

    def _energies(self, v: Array) -> Array:
        """(P,) v . M v / 2 of v (n,)."""
        return np.asarray(np.bincount(self._part, 0.5 * v * (self._mass @ v)), dtype=float)

    def see(self, way: Array) -> None:
        """A way x - x_0 (n,), which may be the farthest one so far."""
        extent = self.motion[_EXTENT]
        np.maximum(extent, self._energies(way), out=extent)

    def going_on(self, a: Array, v: Array, spins: Array, duration: float) -> Array:
        """The motion after another duration [s] with a, v (n,); what rests has not begun.

        spins: (n,) what a . M a / 2 lacks, at the first coordinate of each body that turns [J/s^2].
        """
        lasts = duration * (self.motion[_EXTENT] > self._least)
        forces = self._energies(a) + np.bincount(self._part, spins)
        return self.motion + np.stack([forces * lasts, self._energies(v) * lasts, lasts, 0.0 * lasts])

    def fastest(self, motion: Array, h: float) -> Array:
        """(4,) motion of the part of which steps of h [s] make the largest error; of none: zeros."""
        moving = np.flatnonzero(motion[1] * motion[0] > 0.0)
        if not len(moving):
            return np.zeros(len(motion))
        parts = motion[:, moving]
        forces, speeds, time, extent = parts
        np.maximum(extent, self._least[moving] / OF_EXTENT**2, out=extent)
        squared = forces / speeds
        made = h**2 / 24.0 * squared**1.5 * time
        error = np.sqrt(speeds / (time * extent * squared)) * np.minimum(made, np.cbrt(made))
        fastest: Array = parts[:, np.argmax(error)]
        return fastest
