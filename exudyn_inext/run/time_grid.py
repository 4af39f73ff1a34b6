"""Steps of Exudyn's time loop, and the integrator's steps within them."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, Places
from ..checks import SMALLEST, require_finite, require_positive
from ..errors import InputError

_ROUND_OFF = 1.0 - 1e-9
_LARGEST_FRACTION = 20
MOST_LOOP_STEPS = 2**31 - 1  # Exudyn counts them
MOST_STEPS = 1e13  # months


@dataclass(frozen=True)
class TimeGrid:
    """Equal steps of Exudyn's time loop, each cut into equal steps of the integrator.

    start: [s].   loop_steps: number of Exudyn steps.   substeps: integrator steps in each of them.
    h: step of the integrator [s].   first: step of the loop that a continued run begins with.
    before: steps of the integrator since `start`, before the first step of the loop.
    """

    start: float
    loop_steps: int
    substeps: int
    h: float
    first: int = 0
    before: int = 0

    def steps_until(self, loop_step: int) -> int:
        """Steps of the integrator since `start`, at the end of that many steps of the loop."""
        return self.before + loop_step * self.substeps

    def begins_with(self, loop_step: int) -> bool:
        """Whether no step has been taken before that step of the loop."""
        return loop_step == self.first and not self.before

    def time(self, loop_step: int) -> float:
        """Time after that many steps of the loop [s]."""
        return self.start + (self.before + loop_step * self.substeps) * self.h

    def times(self, loop_steps: Places) -> Array:
        """As `time`, after each of these numbers of steps (k,)."""
        return np.asarray(self.start + (self.before + loop_steps * self.substeps) * self.h)


def time_grid(mbs: Any, settings: Any, wanted: float) -> TimeGrid:
    """As few loop steps as the outputs allow, each with equal integrator steps of at most `wanted` [s].

    Args:
        mbs: its sensors decide whether their write period counts.   settings: exudyn.SimulationSettings.

    Raises:
        InputError: the end time is not after the start time, or there are more steps than can be counted.
    """
    period, solution = math.inf, settings.solution
    if solution.file.write:
        period = solution.file.writePeriod
    if solution.sensors.active and mbs.systemData.NumberOfSensors() > 0:
        period = min(period, solution.sensors.writePeriod)
    return grid_of_period(settings, wanted, period)


def loop_interval(mbs: Any, settings: Any) -> float:
    """Of the loop, if no step of the integrator had to be shorter [s]; see `time_grid`."""
    return time_grid(mbs, settings, math.inf).h


def grid_of_period(settings: Any, wanted: float, period: float) -> TimeGrid:
    """The grid of `time_grid` for outputs at a given period [s]; 0: at every step of the integrator.

    Raises:
        InputError: the end is not after the start.
    """
    time = settings.timeIntegration
    duration = time.endTime - time.startTime
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(
            f"endTime - startTime = {duration} s: must be a finite number > 0; set timeIntegration.endTime."
        )
    require_positive("endTime - startTime [s]", duration)
    require_finite("timeIntegration.startTime", time.startTime, "s")
    if not 1 <= time.numberOfSteps <= MOST_LOOP_STEPS:
        raise InputError(
            f"timeIntegration.numberOfSteps = {time.numberOfSteps!r}: must be from 1 to {MOST_LOOP_STEPS}."
        )
    interval = min(duration / time.numberOfSteps, period or wanted)
    _require_countable("endTime - startTime", duration, "outputs or loop steps", interval, MOST_LOOP_STEPS)
    _require_countable("endTime - startTime", duration, "steps", wanted, MOST_STEPS)
    loop_steps = _commensurate_steps(duration, interval)
    substeps = steps_within(duration / loop_steps, wanted)
    return TimeGrid(time.startTime, loop_steps, substeps, duration / (loop_steps * substeps))


def _require_countable(name: str, duration: float, what: str, interval: float, most: float) -> None:
    if not duration / max(interval, SMALLEST) <= most:
        raise InputError(
            f"{name} = {duration:g} s in {what} of {interval:g} s: these are more than "
            f"{most:g}; check the units of times, steps and write periods."
        )


def steps_within(duration: float, largest: float) -> int:
    """Number of equal steps, of at most `largest` [s] (may be infinite), that make up a duration [s]."""
    return max(1, math.ceil(duration / largest * _ROUND_OFF))


def steps_of_interval(interval: float | None, largest: float, most: int) -> tuple[int, float]:
    """Number, `most` at most, and size [s] of equal steps in an interval [s]; None: one of the largest."""
    if interval is None:
        return 1, largest
    _require_countable("interval", interval, "steps", largest, most)
    number = steps_within(interval, largest)
    return number, interval / number


def _commensurate_steps(duration: float, interval: float) -> int:
    """Number of equal steps, of `interval` or a small fraction of it, that end with the duration."""
    for fraction in range(1, _LARGEST_FRACTION + 1):
        steps = duration / interval * fraction
        if abs(steps - round(steps)) < 1e-6:
            return round(steps)
    return math.ceil(duration / interval)
