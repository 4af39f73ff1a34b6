"""A line on the console that kernels are compiled, which only the first run of a kind does."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import exudyn

from .. import compiled
from ..lowered import Compilation


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
