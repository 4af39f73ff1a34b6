"""Steps that follow the present stability limit of a cable."""

import math
from dataclasses import dataclass
from typing import Any

from ..chain.frequency import FrequencyTracker
from .time_grid import steps_within

STEPS_BETWEEN = 32  # two looks at the frequency
SMALLEST = 1e-3  # step, relative to the first one, below which a run has diverged


@dataclass(frozen=True)
class StepRule:
    """How long a step may be.

    limit: h w [-] up to which the scheme is stable.   safety: share of it that is used [-].
    largest: upper bound of the step [s].
    """

    limit: float
    safety: float
    largest: float


class StepControl:
    """Chooses the steps of a run, from the largest frequency at present.

    A cable that straightens, is wound up or is pulled tight vibrates faster: the frequency is followed,
    and its last growth counted once more.

    smallest, largest: steps so far [s].   steps: how many.
    """

    def __init__(self, rule: StepRule, tracker: FrequencyTracker) -> None:
        self._rule = rule
        self._tracker = tracker
        self._frequency = 0.0
        self._first = self._step = 0.0
        self.smallest, self.largest, self.steps = math.inf, 0.0, 0

    def next_steps(self, remaining: float, q: Any, a: Any) -> tuple[int, float, float]:
        """How many steps to take before asking again, their size [s], and its ratio to that of the last ones.

        No steps if they would have to be so small that the run must have diverged.

        Equal steps of this size would end with the `remaining` time [s].

        Args:
            q, a: (n, 2, dim) at present, where the cable's system was evaluated last.
        """
        frequency = self._tracker.frequency(q, a)
        if not math.isfinite(frequency):
            return 0, 0.0, 1.0
        growth = max(0.0, frequency - self._frequency) if self._frequency else 0.0
        self._frequency = frequency
        allowed = self._rule.safety * self._rule.limit / max(frequency + growth, 1e-300)
        number = steps_within(remaining, min(allowed, self._rule.largest))
        step = remaining / number
        self._first = self._first or step
        if not step > SMALLEST * min(self._first, remaining):
            return 0, step, 1.0
        ratio = step / self._step if self._step else 1.0
        self._step = step
        self.smallest, self.largest = min(self.smallest, step), max(self.largest, step)
        taken = min(number, STEPS_BETWEEN)
        self.steps += taken
        return taken, step, ratio
