"""Steps of Exudyn's time loop, and the integrator's steps within them."""

import math
from dataclasses import dataclass
from typing import Any

from ..errors import InputError

_ROUND_OFF = 1.0 - 1e-9


@dataclass(frozen=True)
class TimeGrid:
    """Equal steps of Exudyn's time loop, each cut into equal steps of the integrator.

    start: [s].   loop_steps: number of Exudyn steps.   substeps: integrator steps in each of them.
    h: step of the integrator [s].
    """

    start: float
    loop_steps: int
    substeps: int
    h: float

    def time(self, loop_step: int) -> float:
        """Time after that many steps of the loop [s]."""
        return self.start + loop_step * self.substeps * self.h


def time_grid(mbs: Any, settings: Any, wanted: float) -> TimeGrid:
    """As few loop steps as the outputs allow, each with equal integrator steps of at most `wanted`.

    Args:
        mbs: its sensors decide whether their write period counts.
        settings: exudyn.SimulationSettings.
        wanted: largest step of the integrator [s].

    Raises:
        InputError: the end time is not after the start time.
    """
    time = settings.timeIntegration
    duration = time.endTime - time.startTime
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(
            f"endTime - startTime = {duration} s: must be a finite number > 0; set timeIntegration.endTime."
        )
    longest = duration / time.numberOfSteps
    interval = min(longest, max(_output_period(mbs, settings), min(wanted, longest)))
    loop_steps = math.ceil(duration / interval * _ROUND_OFF)
    substeps = math.ceil(duration / loop_steps / wanted * _ROUND_OFF)
    return TimeGrid(time.startTime, loop_steps, substeps, duration / (loop_steps * substeps))


def _output_period(mbs: Any, settings: Any) -> float:
    """Shortest write period of the active outputs [s]."""
    period = math.inf
    if settings.solution.file.write:
        period = settings.solution.file.writePeriod
    if settings.solution.sensors.active and mbs.systemData.NumberOfSensors() > 0:
        period = min(period, settings.solution.sensors.writePeriod)
    return period
