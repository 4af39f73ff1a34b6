"""What sensors and solution files show in their first row: accelerations at the start."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from .cable_run import CableRun
from .general.coupled_run import CoupledRun
from .general.surroundings import evaluator, state_kept
from .native_run import NativeRun
from .time_loop import Run

_INITIAL = exudyn.ConfigurationType.Initial


@contextmanager
def first_row(mbs: Any, runs: Sequence[Run], time: float) -> Iterator[None]:
    """Exudyn copies its initial state to the current one, and writes it before the first step.

    Args:
        mbs: the system; its initial state is afterwards what it was before.
        runs: have been started.   time: of the start [s].
    """
    data = mbs.systemData
    before = data.GetODE2Coordinates_tt(_INITIAL)
    shown = np.array(before)
    for run in runs:
        shown[run.indices] = _accelerations(mbs, run, time)
    data.SetODE2Coordinates_tt(shown, _INITIAL)
    try:
        yield
    finally:
        data.SetODE2Coordinates_tt(before, _INITIAL)


def _is_implicit(run: CableRun | CoupledRun) -> bool:
    """Whether its accelerations are those of a mass with bending in it."""
    return any(cable.has_implicit_bending for cable in run.cable_runs)


def _accelerations(mbs: Any, run: Run, time: float) -> Array:
    """(n,) of all coordinates of a run that has been started."""
    if isinstance(run, CableRun | CoupledRun):
        return run.accelerations(time) if _is_implicit(run) else run.state.a[: len(run.indices)]
    if not isinstance(run, NativeRun):
        raise AssertionError(type(run))
    with state_kept(mbs):  # the solver of the time loop evaluates nothing before it runs
        mbs.systemData.SetTime(time)
        return run.accelerations(evaluator(mbs))
