"""Solution file and sensors of an equilibrium, written by Exudyn's static solver."""

from collections.abc import Sequence
from typing import Any

import exudyn

from ..native.surroundings import state_kept, switched_off


def write_equilibrium(mbs: Any, settings: Any, cables: Sequence[int]) -> None:
    """Write the present state of mbs, where settings ask for it, as mbs.SolveStatic does its last load step.

    Args:
        mbs: at rest.   settings: exudyn.SimulationSettings.   cables: see `switched_off`.
    """
    current, static = exudyn.ConfigurationType.Current, settings.staticSolver
    end = static.loadStepStart + static.loadStepDuration
    with switched_off(mbs, cables), state_kept(mbs):
        found = mbs.systemData.GetSystemState(current)
        solver: Any = exudyn.MainSolverStatic()
        solver.InitializeSolver(mbs, settings)
        mbs.systemData.SetSystemState(found, current)
        mbs.systemData.SetTime(end)
        solver.it.currentTime = end
        solver.FinishStep(mbs, settings)
        solver.FinalizeSolver(mbs, settings)
