"""The state of an mbs, and runs that begin in another one than the initial configuration."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..native.native_items import state_kept
from ..run.coupled_run import Run

State = Mapping[str, Array]
INITIAL = exudyn.ConfigurationType.Initial
_PARTS = ("ODE2", "ODE2_t", "ODE1", "AE", "Data", "ODE2_tt")  # as of GetSystemState, and accelerations


def state_of(mbs: Any, configuration: Any = exudyn.ConfigurationType.Current) -> dict[str, Array]:
    """Coordinates and their derivatives, by names."""
    data = mbs.systemData
    parts = [*data.GetSystemState(configuration), data.GetODE2Coordinates_tt(configuration)]
    return {name: np.array(part) for name, part in zip(_PARTS, parts, strict=True)}


@contextmanager
def at_start(mbs: Any, time: float) -> Iterator[None]:
    """Meanwhile, the current state of mbs is the initial one, at `time` [s]: not that of an earlier run."""
    data = mbs.systemData
    with state_kept(mbs):
        data.SetSystemState(data.GetSystemState(INITIAL), exudyn.ConfigurationType.Current)
        data.SetTime(time)
        yield


@contextmanager
def initial_state(mbs: Any, state: State) -> Iterator[None]:
    """Runs, ours and Exudyn's, begin from the initial configuration: meanwhile it is that state."""
    before = state_of(mbs, INITIAL)
    _set_initial(mbs, state)
    try:
        yield
    finally:
        _set_initial(mbs, before)


def _set_initial(mbs: Any, state: State) -> None:
    *parts, accelerations = (state[name] for name in _PARTS)
    mbs.systemData.SetSystemState(parts, INITIAL)
    mbs.systemData.SetODE2Coordinates_tt(accelerations, INITIAL)


def first_row(mbs: Any, runs: Sequence[Run], time: float) -> AbstractContextManager[None]:
    """What sensors and solution files show in their first row: accelerations and multipliers at the start.

    Exudyn copies its initial state to the current one, and writes it before the first step.

    Args:
        mbs: the system; its initial state is afterwards what it was before.
        runs: have been started.   time: of the start [s].
    """
    state = state_of(mbs, INITIAL)
    state["AE"][:] = 0.0
    for run in runs:
        state["ODE2_tt"][run.indices] = run.accelerations(time, state["AE"])
    return initial_state(mbs, state)
