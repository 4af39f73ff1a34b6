"""Exudyn's own integrator, which does nothing while ours takes the steps of its loop."""

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import exudyn


def idle_integrator(settings: Any) -> AbstractContextManager[None]:
    """No initial accelerations and no dense matrix are computed meanwhile; ours are not reset."""
    unused = "computeInitialAccelerations", "resetAccelerations", "useIndex2Constraints"
    return changed(
        [
            *((settings.timeIntegration.generalizedAlpha, name, False) for name in unused),
            (settings.linearSolver, "solverType", exudyn.LinearSolverType.EigenSparse),
        ]
    )


@contextmanager
def changed(wanted: Iterable[tuple[Any, str, Any]]) -> Iterator[None]:
    """Settings have other values meanwhile.   wanted: (part of the settings, name, value)."""
    wanted = list(wanted)
    saved = [(part, name, getattr(part, name)) for part, name, _ in wanted]
    try:
        for part, name, value in wanted:
            setattr(part, name, value)
        yield
    finally:
        for part, name, value in saved:
            setattr(part, name, value)


def nothing(solver: Any, mbs: Any, settings: Any) -> bool:
    """The user function of a solver whose steps have ended, so that mbs does not keep itself alive."""
    return True
