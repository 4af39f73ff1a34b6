"""How values that are set between two steps of the loop act within the next one: along a line.

Exudyn's implicit solvers take the mean of the forces at both ends of a step. So forces that functions of the
user set step by step change along a line there, from those of the step before. Held through the step, they
would be ahead by half of it.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array

ROUND_OFF = 1e-9  # of a share
NO_STEP = 0.0, 0.0


class Line(NamedTuple):
    """Along which parameters get to values that have been set.

    start, end: of the step of the loop [s].   before: values there, by parameters.
    """

    start: float
    end: float
    before: Mapping[Any, Any]

    @property
    def step(self) -> tuple[float, float]:
        """Its start and end [s]."""
        return self.start, self.end


class Ramp:
    """The line from the values before a step of the loop to those that were set.

    start, end: of the step [s]; beyond it, the new values act.
    """

    start, end = NO_STEP

    def begin(self, start: float, end: float) -> None:
        """The step from `start` to `end` [s] is the next one."""
        self.start, self.end = start, end

    @property
    def step(self) -> list[float]:
        """Its start and end [s]."""
        return [self.start, self.end]

    def missing(self, times: Sequence[float]) -> Array:
        """(T,) share of the change that is missing at these times [s]: 1 at the start, 0 at the end."""
        if not times[0] < self.end:
            return np.zeros(len(times))
        return np.array([self.share(time) for time in times])

    def share(self, time: float) -> float:
        """See `missing`."""
        share = (self.end - time) / (self.end - self.start) if time < self.end else 0.0
        if share < ROUND_OFF:
            return 0.0
        return 1.0 if share > 1.0 - ROUND_OFF else share
