"""What Exudyn prints on an explicit run: its own look, with the integrator that takes the steps."""

import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import exudyn

from .. import compiled
from ..lowered import Compilation
from ..run.settings import ExplicitSettings
from .idle_integrator import changed


@contextmanager
def compile_notice(settings: Any = None, solver: Any = None) -> Iterator[None]:
    """Before the first kernel that is compiled within; from verboseMode = 1 on also how long it took.

    Args:
        settings: simulation settings, or None.
        solver: of Exudyn, whose clock stands still meanwhile; or None.
    """

    def stop_the_clock(seconds: float) -> None:
        if solver is not None:
            solver.output.cpuSolverStartTime += seconds

    compilation = Compilation(_announce, stop_the_clock)
    try:
        with compilation.listening():
            yield
    finally:
        if compilation.seconds and settings is not None and settings.timeIntegration.verboseMode:
            print(f"exudyn_inext: kernels compiled in {compilation.seconds:.1f} s", flush=True)


def _announce() -> None:
    """On stderr, as results of scripts go to stdout; silent where Exudyn is."""
    if not exudyn.config.printToConsole:
        return
    folder = compiled.CACHE_FOLDER
    kept = f"once: they are kept in {folder}" if folder else "in each process: no cache can be written to"
    print(
        "exudyn_inext: compiling kernels for this kind of scene (some 20 s, among bodies up to a minute), "
        f"{kept}",
        file=sys.stderr,
        flush=True,
    )


def quiet_settings(end_time: float, steps: int, period: float) -> Any:
    """exudyn.SimulationSettings: silent, no files, sensors every `period` [s]."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = period
    settings.timeIntegration.endTime = end_time
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.verboseMode = 0
    return settings


def silence() -> AbstractContextManager[None]:
    """Keep Exudyn's notes and failure reports off the console; errors still come as exceptions."""
    return changed([(exudyn.config, "printToConsole", False)])


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
