"""Places that functions of the user set step by step, and how they are reached within each step."""

import numpy as np

from ..arrays import Array

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
        self._rates, self._changes = self._history
        self._times = self.memory[:3]  # duration of the step before, begin and end of this one [s]
        self._nothing, *self._powers = np.zeros((4, 3, size))  # of the time that is left
        self._end = 0.0
        self._asked, self._left = np.nan, self._nothing  # the last time [s], and what `at` said then
        self.moves = False

    def aim(self, left: Array, time: float, end: float) -> None:
        """So much (n,) is left at `time` [s], and nothing at `end` [s] of the same step."""
        self._turn_over(time, end)
        self._end, duration = end, end - time
        before = float(self._times[0]) or duration
        self._rates[1] = rates = left / duration
        self._changes[1] = 2.0 * (rates - self._rates[0]) / (before + duration)
        bend = _smaller(self._changes[1], _GROWTH * self._changes[0])
        steady, linear, quadratic = self._powers
        linear[0], linear[1] = rates + 0.5 * duration * bend, bend
        steady[1], steady[2], quadratic[0] = -linear[0], -bend, -0.5 * bend
        self.moves, self._asked = any(left.tolist()), np.nan

    def _turn_over(self, time: float, end: float) -> None:
        """What is known of the step so far becomes that of the step before, if this one is another."""
        nearly = _SAME * (end - time)
        last_begin, last_end = self._times[1:].tolist()
        if abs(time - last_begin) <= nearly and abs(end - last_end) <= nearly:
            return
        follows = abs(time - last_end) <= nearly
        self._history[:, 0] = self._history[:, 1] if follows else 0.0
        self._times[:] = last_end - last_begin if follows else 0.0, time, end

    def rest(self) -> None:
        """Stay there."""
        self.moves = False

    def at(self, t: float) -> Array:
        """(3, n) what is left at t [s], within the step or later, and its derivatives; to be read only."""
        if not self.moves:
            return self._nothing
        if t != self._asked:
            rest, (steady, linear, quadratic) = max(self._end - t, 0.0), self._powers
            self._asked, self._left = t, steady + rest * (linear + rest * quadratic)
        return self._left


def _smaller(one: Array, other: Array) -> Array:
    """That which is nearer to zero, where both have the same sign; elsewhere zero."""
    return np.maximum(np.minimum(one, other), np.minimum(np.maximum(one, other), 0.0))
