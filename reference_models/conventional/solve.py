"""One run of a built native model."""

from collections.abc import Iterator
from contextlib import contextmanager

import exudyn
import numpy as np

from exudyn_inext.errors import DivergenceError

from ..trajectory import Trajectory
from .model import Model
from .settings import Solver, simulation_settings


def solve(model: Model, solver: Solver, end_time: float | None = None) -> Trajectory:
    """Run to end_time [s] (default: the scene's) and return the scene's main point.

    Raises:
        DivergenceError: Exudyn gave up. A run that ends in NaN is returned as it is.
    """
    settings = simulation_settings(solver, model.scene.end_time if end_time is None else end_time)
    try:
        with silence():
            model.mbs.SolveDynamic(settings)
    except exudyn.ExudynError as error:
        raise DivergenceError(f"{solver} stopped early: {error}; use a smaller step.") from error
    return sensor_trajectory(model, model.scene.main_point)


def sensor_trajectory(model: Model, point: str) -> Trajectory:
    """What the sensor of an observed point has stored."""
    stored = np.asarray(model.mbs.GetSensorStoredData(model.sensors[point]))
    return Trajectory(times=stored[:, 0].copy(), positions=stored[:, 1:4].copy())


@contextmanager
def silence() -> Iterator[None]:
    """Keep Exudyn's notes and failure reports off the console; errors still come as exceptions."""
    before = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = before
