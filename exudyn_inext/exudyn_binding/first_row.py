"""What sensors and solution files show in their first row: accelerations and multipliers at the start."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import exudyn
import numpy as np

from ..run.run import Run

_INITIAL = exudyn.ConfigurationType.Initial


@contextmanager
def first_row(mbs: Any, runs: Sequence[Run], time: float) -> Iterator[None]:
    """Exudyn copies its initial state to the current one, and writes it before the first step.

    Args:
        mbs: the system; its initial state is afterwards what it was before.
        runs: have been started.   time: of the start [s].
    """
    data = mbs.systemData
    before = data.GetODE2Coordinates_tt(_INITIAL), data.GetAECoordinates(_INITIAL)
    accelerations, multipliers = np.array(before[0]), np.zeros(len(before[1]))
    for run in runs:
        accelerations[run.indices] = run.accelerations(time, multipliers)
    data.SetODE2Coordinates_tt(accelerations, _INITIAL)
    data.SetAECoordinates(multipliers, _INITIAL)
    try:
        yield
    finally:
        data.SetODE2Coordinates_tt(before[0], _INITIAL)
        data.SetAECoordinates(before[1], _INITIAL)
