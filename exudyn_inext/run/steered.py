"""Places that functions of the user set step by step, and how they are reached within each step."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..compiled import Prepared, inlined, kernel

_SAME = 1e-6  # of times, in steps
_GROWTH = 2.0  # of the acceleration from one step to the next, at most


class Steered:
    """How much is left of the way to values that are set at each step of the time loop, for its end.

    Places that are set step by step say nothing of velocities and accelerations. The mean velocity of a step
    is known, and the acceleration by which it differs from that of the step before: the way is the parabola
    through three places. Jumps, and what else is not steady, go along straight lines: the acceleration has
    the sign of that of the step before, and is at most twice as large, or it is none.

    moves: whether something is left.   memory: what the next steps depend on, always the same array.
    """

    def __init__(self, size: int) -> None:
        """size: number n of values."""
        self.memory = np.zeros(4 * size + 3)
        self._history = self.memory[3:].reshape(2, 2, size)  # rates and changes, before and in this step
        self._times = self.memory[:3]  # duration of the step before, begin and end of this one [s]
        self._powers = np.zeros((3, 3, size))  # of the time that is left
        self._set, self._evaluate = Prepared(_set_powers), Prepared(_evaluate)
        self._end = 0.0
        self.moves = False

    def aim(self, left: Array, time: float, end: float) -> None:
        """So much (n,) is left at `time` [s], and nothing at `end` [s] of the same step."""
        self._end = end
        self.moves = bool(self._set(self._times, self._history, self._powers, left, time, end))

    def rest(self) -> None:
        """Stay there."""
        self.moves = False

    def left_at(self, times: Sequence[float]) -> Array:
        """(T, 3, n) what is left at these times [s], within the step or later, and its derivatives."""
        values = np.zeros((len(times), self._powers.shape[2], 3))
        if self.moves:
            self._evaluate(self._powers, np.array([max(self._end - t, 0.0) for t in times]), values)
        return values.transpose(0, 2, 1)


def parabola(powers: Array, times: Sequence[float]) -> Array:
    """(T, k, n) p_0 + p_1 t + p_2 t^2 at these times.   powers: (3, k, n)."""
    values = np.empty((len(times), *powers.shape[:0:-1]))
    _evaluate(powers, np.array(times, dtype=float), values)
    return values.transpose(0, 2, 1)


@kernel
def _evaluate(powers, times, values):
    """See `parabola`.   values: (T, n, k) output."""
    for k in range(len(times)):
        for i in range(powers.shape[1]):
            for j in range(powers.shape[2]):
                rise = powers[1, i, j] + times[k] * powers[2, i, j]
                values[k, j, i] = powers[0, i, j] + times[k] * rise


@inlined
def _turn_over(times, history, time, end):
    """What is known of the step so far becomes that of the step before, if this one is another."""
    nearly = _SAME * (end - time)
    if abs(time - times[1]) <= nearly and abs(end - times[2]) <= nearly:
        return
    follows = 1.0 if abs(time - times[2]) <= nearly else 0.0
    times[0] = follows * (times[2] - times[1])
    times[1], times[2] = time, end
    for kind in range(2):
        for i in range(history.shape[2]):
            history[kind, 0, i] = follows * history[kind, 1, i]


@kernel
def _set_powers(times, history, powers, left, time, end):
    """Set the powers (3, 3, n) of the time that is left; returns whether anything is."""
    _turn_over(times, history, time, end)
    duration = end - time
    before = times[0] if times[0] > 0.0 else duration
    moves = False
    for i in range(len(left)):
        rate = left[i] / duration
        change = 2.0 * (rate - history[0, 0, i]) / (before + duration)
        history[0, 1, i], history[1, 1, i] = rate, change
        bend = _smaller(change, _GROWTH * history[1, 0, i])
        linear = rate + 0.5 * duration * bend
        powers[0, 1, i], powers[0, 2, i] = -linear, -bend
        powers[1, 0, i], powers[1, 1, i] = linear, bend
        powers[2, 0, i] = -0.5 * bend
        moves = moves or left[i] != 0.0
    return moves


@inlined
def _smaller(one, other):
    """That which is nearer to zero, where both have the same sign; elsewhere zero."""
    return max(min(one, other), min(max(one, other), 0.0))
