"""Jumps of supports and joints that move by functions of time, seen between neighbouring samples of steps.

Steps would go over them: no velocity takes a place to the one behind the jump.
"""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array
from ..constraints.motion import AT_ONCE, FASTEST, find_jump

UNEVEN = 0.1  # share of the way of a step that is not that of its velocities, where a jump may be


class JumpError(Exception):
    """Something moves at once in the steps to come.   begin, end: times around the jump [s]."""

    def __init__(self, begin: float, end: float) -> None:
        super().__init__(f"between {begin:g} and {end:g} s")
        self.begin, self.end = begin, end


class JumpSight:
    """Compares places in samples of functions of time with those that their velocities lead to.

    places, rates: (k,) columns of the samples that are places [m, -], and velocities of the same.
    """

    def __init__(
        self, places: Sequence[int], rates: Sequence[int], sample: Callable[[list[float]], Array]
    ) -> None:
        """sample: times (T,) [s] -> (T, P)."""
        self.places, self.rates = np.array(places, int), np.array(rates, int)
        self._sample = sample
        self._time, self._last = np.nan, np.zeros((1, 0))  # of the last sample

    def look(self, since: float, times: list[float], samples: Array) -> None:
        """Look at the samples (T, P) at these times (T,) of the steps from `since` on [s].

        Raises:
            JumpError: a place jumps.
        """
        if not self.places.size:
            return
        last = self._last if since == self._time else self._sample([since])
        self._time, self._last = times[-1], samples[-1:]
        values, times = np.concatenate([last, samples]), [since, *times]
        ways, rates = np.diff(values[:, self.places], axis=0), values[:, self.rates]
        h = np.diff(times)[:, np.newaxis]
        before, after = h * rates[:-1], h * rates[1:]
        missed, largest = np.abs(ways - 0.5 * (before + after)), np.maximum(np.abs(before), np.abs(after))
        is_uneven = missed > UNEVEN * largest + FASTEST * AT_ONCE
        for k in np.flatnonzero(is_uneven.any(axis=1)).tolist():
            if find_jump(self._places_at, times[k], times[k + 1]):
                raise JumpError(times[k], times[k + 1])

    def _places_at(self, t: float) -> Array:
        return self._sample([t])[0, self.places]
