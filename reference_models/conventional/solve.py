"""One run of a built native model."""

import exudyn

from exudyn_inext.errors import DivergenceError

from ..model import Model, sensor_trajectory, silence
from ..trajectory import Trajectory
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
