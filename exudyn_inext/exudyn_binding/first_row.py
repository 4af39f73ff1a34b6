"""What sensors and solution files show in their first row: accelerations and multipliers at the start."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any

from ..run.coupled_run import Run
from .mbs_state import INITIAL, initial_state, state_of


def first_row(mbs: Any, runs: Sequence[Run], time: float) -> AbstractContextManager[None]:
    """Exudyn copies its initial state to the current one, and writes it before the first step.

    Args:
        mbs: the system; its initial state is afterwards what it was before.
        runs: have been started.   time: of the start [s].
    """
    state = state_of(mbs, INITIAL)
    state["AE"][:] = 0.0
    for run in runs:
        state["ODE2_tt"][run.indices] = run.accelerations(time, state["AE"])
    return initial_state(mbs, state)
