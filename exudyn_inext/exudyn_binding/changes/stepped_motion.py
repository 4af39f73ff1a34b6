"""A point that is told where to be at the end of each step: it gets there along a straight line."""

import numpy as np

from ...arrays import Array
from ...cable.link import Motion


class Way:
    """From where a point was told to be to where it shall be.

    A function of the user that gives positions step by step gives no velocities; those of the straight lines
    between them are those that a cable needs.

    motion: of the point.
    """

    def __init__(self, point: Array) -> None:
        """point: (dim,) where it is [m]."""
        self._values = np.zeros((3, len(point)))
        self._values[0] = point
        self._end = 0.0
        self.motion = Motion(self.at, is_pure=False, is_smooth=False)

    @property
    def moves(self) -> bool:
        return bool(self._values[1].any())

    def aim(self, point: Array, time: float, end: float) -> None:
        """Be at `point` (dim,) [m] at the time `end` [s] of the step from `time` [s]."""
        self._values[1] = (point - self._values[0]) / (end - time)
        self._values[0] = point
        self._end = end

    def stop(self) -> None:
        """Stay there."""
        self._values[1] = 0.0

    def at(self, t: float) -> Array:
        """(3, dim) p, p_t, p_tt at t [s], within the step or later."""
        values = self._values.copy()
        values[0] -= max(self._end - t, 0.0) * values[1]
        return values
