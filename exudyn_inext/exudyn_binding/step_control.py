"""Steps that follow the present stability limit of a cable."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import record_type
from ..chain.frequency import FrequencyTracker
from .time_grid import steps_within

STEPS_BETWEEN = 32  # two looks at the frequency
SMALLEST = 1e-3  # step, relative to the first one, below which a run has diverged

_LOG = record_type(
    [
        ("frequency", np.float64),
        ("first", np.float64),
        ("last", np.float64),
        ("smallest", np.float64),
        ("largest", np.float64),
        ("steps", np.int64),
    ]
)


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

    smallest, largest, last: steps so far [s].   steps: how many.
    gave_up: whether the next one would have to be too small.
    """

    def __init__(self, rule: StepRule, tracker: FrequencyTracker) -> None:
        self._rule = rule
        self._tracker = tracker
        self._log = np.zeros(1, _LOG)[0]
        self._log.smallest = math.inf
        self.gave_up = False

    @property
    def smallest(self) -> float:
        return float(self._log.smallest)

    @property
    def largest(self) -> float:
        return float(self._log.largest)

    @property
    def last(self) -> float:
        return float(self._log.last)

    @property
    def steps(self) -> int:
        return int(self._log.steps)

    def memory(self) -> dict[str, Any]:
        """What the next steps depend on, to be kept or set."""
        return {"log": self._log.base, "vibration": self._tracker.vibration}

    def next_steps(self, remaining: float, q: Any, a: Any) -> tuple[int, float, float]:
        """How many steps to take before asking again, their size [s], and its ratio to that of the last ones.

        No steps if they would have to be so small that the run must have diverged.

        Equal steps of this size would end with the `remaining` time [s].

        Args:
            q, a: (n, 2, dim) at present, where the cable's system was evaluated last.
        """
        frequency = self._tracker.frequency(q, a)
        if not math.isfinite(frequency):
            self.gave_up = True
            return 0, 0.0, 1.0
        log = self._log
        growth = max(0.0, frequency - log.frequency) if log.frequency else 0.0
        log.frequency = frequency
        allowed = self._rule.safety * self._rule.limit / max(frequency + growth, 1e-300)
        number = steps_within(remaining, min(allowed, self._rule.largest))
        step = remaining / number
        log.first = log.first or step
        if not step > SMALLEST * min(log.first, remaining):
            self.gave_up = True
            return 0, step, 1.0
        ratio = step / log.last if log.last else 1.0
        log.last = step
        log.smallest, log.largest = min(log.smallest, step), max(log.largest, step)
        taken = min(number, STEPS_BETWEEN)
        log.steps += taken
        return taken, step, ratio
