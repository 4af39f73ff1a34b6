"""What Exudyn prints on an explicit run: its own look, with the integrator that takes the steps."""

from collections.abc import Callable
from typing import Any

import exudyn

from ..run.settings import ExplicitSettings
from .idle_integrator import changed

_OF_NEWTON = 2 | 4 | 8  # flags of stepInformation: iterations and Jacobians, of which there are none


def initialized(solver: Any, initialize: Callable[[], bool], settings: Any, header: str) -> bool:
    """As solver.InitializeSolver, which would speak of an implicit solver, and leave its clock at zero.

    Args:
        solver: of Exudyn.   initialize: calls that method.   settings: simulation settings.
        header: see `header_of`; printed from verboseMode = 1 on.
    """
    time, output = settings.timeIntegration, solver.output
    verbose = time.verboseMode
    with changed([(time, "verboseMode", 0)]):
        if not initialize():
            return False
    output.verboseMode = verbose
    output.stepInformation &= ~_OF_NEWTON
    output.cpuSolverStartTime = output.cpuLastTimePrinted = output.cpuStartTime
    if verbose:
        exudyn.Print(header)  # type: ignore[call-arg]
    return True


def header_of(explicit: ExplicitSettings, h: float, decided_by: str, steps: int | None = None) -> str:
    """Lines as Exudyn prints them at the start of a run.

    Args:
        explicit: settings, as taken.   h: step [s].   decided_by: what bounds it.
        steps: explicit steps in each step of Exudyn's loop, if it is known.
    """
    scaling = f", massScaling = {explicit.massScaling:g}" if explicit.massScaling else ""
    count = f"; explicit steps in each STEP = {steps}" if steps else ""
    return (
        "+++++++++++++++++++++++++++++++\n"
        f"EXUDYN V{exudyn.__version__} solver: explicit time integration ({explicit.integratorName}, "
        "exudyn_inext)\n"
        f"  h = {h:.4g}s (decided by {decided_by}){scaling}{count}"
    )
