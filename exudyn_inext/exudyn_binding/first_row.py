"""What sensors and solution files show in their first row: accelerations at the start."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
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
        shown[run.indices] = _accelerations(run, time)
    data.SetODE2Coordinates_tt(shown, _INITIAL)
    try:
        yield
    finally:
        data.SetODE2Coordinates_tt(before, _INITIAL)


def _accelerations(run: Run, time: float) -> Array:
    """(n,) of all coordinates of a run that has been started, by the masses as they are."""
    is_implicit = any(cable.has_implicit_bending for cable in run.cable_runs)
    return run.accelerations(time) if is_implicit else run.state.a[: len(run.indices)]
