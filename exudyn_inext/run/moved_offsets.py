"""Offsets of compiled joints that are set between steps: they get there along straight lines."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array


class MovedOffset:
    """What an offset differs by, until the end of a step of the time loop, from where it is to be then.

    row: of the joint.   given: its offset as it is set at present [m].
    """

    def __init__(self, row: int, given: Callable[[], float]) -> None:
        self.row, self.given = row, given
        self._left, self._end, self._duration = 0.0, 0.0, 1.0

    @property
    def moves(self) -> bool:
        """Whether it has moved through the last step."""
        return self._left != 0.0

    def aim(self, left: float, time: float, end: float) -> None:
        """So much is left at `time`, and nothing at `end` [m, s]."""
        self._left, self._end, self._duration = left, end, end - time

    def rest(self) -> None:
        """Stay there."""
        self._left = 0.0

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3) what is left, and its derivatives [m, m/s, m/s^2]."""
        result = np.zeros((len(times), 3))
        if not self.moves:
            return result
        rate = self._left / self._duration
        result[:, 0] = [rate * max(self._end - t, 0.0) for t in times]
        result[:, 1] = -rate
        return result
