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
_STEPS = "explicitSteps"  # in mbs.sys
SAME_TIME = 1e-3  # of an interval
INITIAL = exudyn.ConfigurationType.Initial
_PARTS = ("ODE2", "ODE2_t", "ODE1", "AE", "Data", "ODE2_tt")  # as of GetSystemState, and accelerations


def state_of(mbs: Any, configuration: Any = exudyn.ConfigurationType.Current) -> dict[str, Array]:
    """Coordinates and their derivatives, by names."""
    data = mbs.systemData
    parts = [*data.GetSystemState(configuration), data.GetODE2Coordinates_tt(configuration)]
    return {name: np.array(part) for name, part in zip(_PARTS, parts, strict=True)}


class LastSteps:
    """Last steps before states of mbs, of cables that stretch: their axial forces are means over such steps.

    place: mbs.sys, where `last_step` finds them.
    """

    def __init__(self, place: Any, runs: Sequence[Run]) -> None:
        self.place, self._runs = place, [run for run in runs if run.watch.stretches]
        own = [(cable.scene_cable.number, k) for k, run in enumerate(self._runs) for cable in run.cable_runs]
        self._of_cable = dict(own)

    def keep(self, first: float, interval: float, states: int) -> None:
        """Of the last states of the runs, which mbs gets from the time `first` on at these intervals [s]."""
        if self._runs:
            steps = np.array([run.steps_before(states) for run in self._runs])
            self.place[_STEPS] = first, interval, steps, self._of_cable


def last_step(place: Any, cable: int, time: float) -> float:
    """Before a state, of the cable with that object [s]; 0 where no run has led there.

    place: `mbs.sys`.   time: of the state [s].
    """
    first, interval, steps, of_cable = place.get(_STEPS, (0.0, 1.0, np.zeros((0, 0)), {}))
    intervals = (time - first) / interval
    row = round(intervals)
    is_there = cable in of_cable and 0 <= row < steps.shape[1] and abs(intervals - row) < SAME_TIME
    return float(steps[of_cable[cable], row]) if is_there else 0.0


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
