"""The clock of Exudyn's time loop in a run that is continued: as if it had never been interrupted.

Exudyn counts equal steps from the start of the loop, and writes rows when they are due. Both depend on where
the loop began, in the last bits and in their phase.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from .time_grid import TimeGrid

_ROUND_OFF = 1e-10  # of times, in Exudyn [s]

StepFunction = Callable[[Any, Any, Any], bool]


@dataclass(frozen=True)
class LoopClock:
    """Times of a loop that goes on.

    grid: of the whole run; its `first` step is the one that the loop begins with.
    step: of the loop [s].   end: of the whole run [s].
    """

    grid: TimeGrid
    step: float
    end: float

    def time(self, steps: int) -> float:
        """Exudyn's time after that many steps of the whole run [s], to the last bit."""
        return min(self.grid.start + steps * self.step, self.end)

    def settings(self, time_integration: Any) -> Iterator[tuple[Any, str, Any]]:
        """What Exudyn has to be told: (part of the settings, name, value)."""
        remaining, now = self.grid.loop_steps - self.grid.first, self.time(self.grid.first)
        yield time_integration, "numberOfSteps", remaining
        yield time_integration, "startTime", now
        yield time_integration, "endTime", _end_of(now, self.time(self.grid.first + 1), remaining)

    def continued(self, function: StepFunction, solution: Any) -> StepFunction:
        """The function, which sets Exudyn's clock when it is called first.

        Args:
            function: f(solver, mbs, settings), called at each step of the loop.
            solution: settings of the outputs.
        """
        is_set = False

        def take_step(solver: Any, mbs: Any, settings: Any) -> bool:
            nonlocal is_set
            if not is_set:
                self._set(solver, solution)
                is_set = True
            return function(solver, mbs, settings)

        return take_step

    def _set(self, solver: Any, solution: Any) -> None:
        solver.it.startTime, solver.it.endTime = self.grid.start, self.end
        solver.it.currentStepSize = solver.it.maxStepSize = self.step
        solver.it.currentStepIndex += self.grid.first
        solver.output.lastSolutionWritten = self._due(solution.file.writePeriod)
        solver.output.lastSensorsWritten = self._due(solution.sensors.writePeriod)

    def _due(self, period: float) -> float:
        """When the next row is due that is written every `period` [s]; what Exudyn calls the last time."""
        now = self.time(self.grid.first)
        if period <= self.step:
            return now
        rows = math.floor((now - self.grid.start + _ROUND_OFF) / period)
        return self.grid.start + (rows + 1) * period


def _end_of(start: float, after_a_step: float, steps: int) -> float:
    """An end [s] for which the first of so many equal steps leads exactly to the given time."""
    end = start + steps * (after_a_step - start)
    for candidate in (end, np.nextafter(end, np.inf), np.nextafter(end, -np.inf)):
        if start + (candidate - start) / steps == after_a_step:
            return float(candidate)
    return end
