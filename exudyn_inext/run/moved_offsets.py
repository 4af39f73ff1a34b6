"""Offsets of compiled joints that are set between steps: they get there along straight lines."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array


class MovedOffsets:
    """What offsets differ by, until the end of a step of the time loop, from where they are to be then.

    joints: numbers of the k joints.   rows: (k,) of these.
    moves: whether one of them has moved through the last step.
    """

    def __init__(
        self, joints: Sequence[int], rows: Sequence[int], given: Sequence[Callable[[], float]]
    ) -> None:
        """given: offset of each joint as it is set at present [m]."""
        self.joints, self.rows, self._given = joints, np.array(rows, dtype=int), given
        self._end, self._rest = 0.0, np.zeros(3 * len(rows))
        self.rest()

    @property
    def given(self) -> list[float]:
        """Offsets as they are set at present [m]."""
        return [one() for one in self._given]

    def aim(self, left: Array, time: float, end: float) -> None:
        """So much is left at `time`, and nothing at `end`.   left: (k,) [m].   time, end: [s]."""
        self.moves, self._end = any(left.tolist()), end
        self._rates, self._steady = np.zeros((2, 3 * len(left)))
        self._rates[::3] = left / (end - time)
        self._steady[1::3] = -self._rates[::3]

    def rest(self) -> None:
        """Stay there."""
        self.moves, self._rates, self._steady = False, self._rest, self._rest

    def at(self, t: float) -> Array:
        """(3 k,) what is left at t [s], and its derivatives [m, m/s, m/s^2], of one after the other."""
        values: Array = max(self._end - t, 0.0) * self._rates + self._steady
        return values

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3 k) as `at`, at all of them."""
        if len(times) == 1:
            return self.at(times[0])[np.newaxis]
        left: Array = np.maximum(self._end - np.array(times), 0.0)
        return left[:, np.newaxis] * self._rates + self._steady
