"""Steps of Exudyn's time loop: as few as the outputs allow."""

import math
from typing import Any

from ..run.time_grid import TimeGrid, grid_of_period


def time_grid(mbs: Any, settings: Any, wanted: float) -> TimeGrid:
    """As few loop steps as the outputs allow, each with equal integrator steps of at most `wanted`.

    Args:
        mbs: its sensors decide whether their write period counts.
        settings: exudyn.SimulationSettings.
        wanted: largest step of the integrator [s].

    Raises:
        InputError: the end time is not after the start time, or there are more steps than can be counted.
    """
    return grid_of_period(settings, wanted, _output_period(mbs, settings))


def _output_period(mbs: Any, settings: Any) -> float:
    """Shortest write period of the active outputs [s]; 0: at every step."""
    period = math.inf
    if settings.solution.file.write:
        period = settings.solution.file.writePeriod
    if settings.solution.sensors.active and mbs.systemData.NumberOfSensors() > 0:
        period = min(period, settings.solution.sensors.writePeriod)
    return period
