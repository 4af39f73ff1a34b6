"""Jumps of supports and joints that move by functions of time, seen in the steps to come.

Steps would go over them: no velocity takes a place to the one behind the jump.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, kernel
from ..constraints.motion import STEP, find_jump

SMALL = 1e-5  # jump, over the length of a cable, that counts for nothing, as where pieces of a function meet
SEEN_AHEAD = 3.0 * STEP  # how far differences see jumps before they happen [s]
UNEVEN = 0.1  # share of the way of a step that is not that of its velocities, where a jump may be


class JumpError(Exception):
    """Something moves at once in the steps to come.   begin, end: times around the jump [s]."""

    def __init__(self, begin: float, end: float) -> None:
        super().__init__(f"between {begin:g} and {end:g} s")
        self.begin, self.end = begin, end


def look_between(places: Callable[[float], Array], times: Sequence[float], least: float) -> None:
    """Look between these times of the steps to come [s], in the state before them, without velocities.

    places: t [s] -> (k,) [m, -].   least: that jumps are [m, -].

    Raises:
        JumpError: a place jumps: its ways in both halves between two times differ.
    """
    before = places(times[0])
    for begin, end in pairwise([*times[:-1], times[-1] + SEEN_AHEAD]):
        middle, after = places(0.5 * (begin + end)), places(end)
        ways = np.abs([middle - before, after - middle])
        uneven = np.abs(before - 2.0 * middle + after) > least + 2.0 * UNEVEN * ways.max(axis=0)
        if uneven.any() and (jump := find_jump(places, begin, end)) and jump.size > least:
            raise JumpError(begin, end)
        before = after


class JumpSight:
    """Compares places in samples of functions of time with those that their velocities lead to.

    places, rates: (k,) columns of the samples that are places [m, -], and velocities of the same.
    least: that jumps are [m, -].
    """

    def __init__(
        self,
        columns: tuple[Sequence[int], Sequence[int]],
        least: float,
        sample: Callable[[list[float]], Array],
    ) -> None:
        """columns: places and rates.   sample: times (T,) [s] -> (T, P)."""
        places, rates = columns
        self.places, self.rates, self.least = np.array(places, int), np.array(rates, int), least
        self._sample, self._find = sample, Prepared(_find_uneven)
        self._time, self._last = np.nan, np.zeros((1, 0))  # of the last sample

    def look(self, since: float, times: list[float]) -> Array:
        """Samples (T, P) at these times (T,) of the steps from `since` on [s].

        Raises:
            JumpError: a place jumps.
        """
        if not self.places.size:
            return self._sample(times)
        last = self._last if since == self._time else self._sample([since])
        samples = self._sample(times)
        self._time, self._last = times[-1], samples[-1:]
        values, at = np.concatenate([last, samples]), np.array([since, *times])
        k = self._find(values, at, self.places, self.rates, self.least, 0)
        while k < len(times):
            begin, end = at[k], at[k + 1] + SEEN_AHEAD
            if (jump := find_jump(self._places_at, begin, end)) and jump.size > self.least:
                raise JumpError(begin, end)
            k = self._find(values, at, self.places, self.rates, self.least, k + 1)
        return samples

    def forget(self) -> None:
        """The functions read something else from now on."""
        self._time = np.nan

    def _places_at(self, t: float) -> Array:
        return self._sample([t])[0, self.places]


@kernel
def _find_uneven(values, times, places, rates, least, first):
    """The first interval of times (T + 1,), from that number on, that may have a jump; T if none has.

    values: (T + 1, P) samples.   places, rates: (k,) columns of these.   least: that jumps are [m, -].
    """
    for k in range(first, len(times) - 1):
        half = 0.5 * (times[k + 1] - times[k])
        for number in range(len(places)):
            before, after = half * values[k, rates[number]], half * values[k + 1, rates[number]]
            missed = abs(values[k + 1, places[number]] - values[k, places[number]] - before - after)
            if missed > least + 2.0 * UNEVEN * max(abs(before), abs(after)):
                return k
    return len(times) - 1
