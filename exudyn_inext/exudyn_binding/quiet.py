"""Runs that print nothing and write no files."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import exudyn


def quiet_settings(end_time: float, steps: int, period: float) -> Any:
    """exudyn.SimulationSettings: silent, no files, sensors every `period` [s]."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = period
    settings.timeIntegration.endTime = end_time
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.verboseMode = 0
    return settings


@contextmanager
def silence() -> Iterator[None]:
    """Keep Exudyn's notes and failure reports off the console; errors still come as exceptions."""
    before = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = before
