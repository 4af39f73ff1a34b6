"""What Exudyn prints on an explicit run: its own look, with the integrator that takes the steps."""

from typing import Any

import exudyn

from ..run.settings import ExplicitSettings
from ..run.time_grid import TimeGrid
from .idle_integrator import changed

_OF_NEWTON = 2 | 4 | 8  # flags of stepInformation: iterations and Jacobians, of which there are none


def initialize_solver(solver: Any, mbs: Any, settings: Any, header: str) -> bool:
    """As solver.InitializeSolver, which would speak of an implicit solver, and leave its clock at zero.

    header: see `header_of`; printed from verboseMode = 1 on.
    """
    time, output = settings.timeIntegration, solver.output
    verbose = time.verboseMode
    with changed([(time, "verboseMode", 0)]):
        if not solver.InitializeSolver(mbs, settings):
            return False
    output.verboseMode = verbose
    output.stepInformation &= ~_OF_NEWTON
    output.cpuSolverStartTime = output.cpuLastTimePrinted = output.cpuStartTime
    if verbose:
        exudyn.Print(header)  # type: ignore[call-arg]
    return True


def header_of(explicit: ExplicitSettings, grid: TimeGrid, decided_by: str) -> str:
    """Lines as Exudyn prints them at the start of a run.

    Args:
        explicit: settings, as taken.   grid: steps and outputs.   decided_by: what bounds the step.
    """
    scaling = f", massScaling = {explicit.massScaling:g}" if explicit.massScaling else ""
    return (
        "+++++++++++++++++++++++++++++++\n"
        f"EXUDYN V{exudyn.__version__} solver: explicit time integration ({explicit.integrator}, "
        "exudyn_inext)\n"
        f"  h = {grid.h:.4g}s (decided by {decided_by}){scaling}; "
        f"explicit steps in each STEP = {grid.substeps}"
    )
