"""The user function that Exudyn's time loop calls in place of Newton's method."""

from collections.abc import Sequence
from typing import Any, Protocol

import exudyn
import numpy as np

from ..arrays import Array
from ..errors import DivergenceError, InextensibleError
from .time_grid import TimeGrid

LOOK_AHEAD_LIMIT = 1_000_000  # coordinates times steps in a call: some 30 ms, so that Ctrl-C works


class Run(Protocol):
    """What the loop moves: a cable, or native items; see CableRun for the attributes."""

    state: Any
    indices: np.ndarray
    reference: Array
    looks_ahead: bool

    @property
    def name(self) -> str: ...

    def start(self, time: float) -> None: ...

    def largest_frequency(self, time: float) -> float: ...

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> None: ...


class ExplicitTimeLoop:
    """Moves all cables of a scene; Exudyn calls `advance` once for each step of its time loop.

    Where no user function can see or change the state between two steps of the loop, several of them
    are computed in one compiled call and handed out one by one.
    """

    def __init__(self, mbs: Any, runs: Sequence[Run], scheme: Any, grid: TimeGrid) -> None:
        self.runs = runs
        self.scheme = scheme
        self.grid = grid
        self.error: InextensibleError | None = None
        data = mbs.systemData
        self._set_q, self._set_v = data.SetODE2Coordinates, data.SetODE2Coordinates_t
        self._set_a = data.SetODE2Coordinates_tt
        self._getters = (data.GetODE2Coordinates, data.GetODE2Coordinates_t)
        self._written = [get(exudyn.ConfigurationType.Initial) for get in self._getters]
        self._is_watched = _has_step_user_functions(mbs) or not all(run.looks_ahead for run in runs)
        self._ahead: list[Any] = []  # states still to be handed out, the next one last
        self._computed = 0  # steps of the loop
        for run in runs:
            run.start(grid.start)

    @property
    def path(self) -> str:
        """Which way the steps are computed, and why."""
        names = ", ".join(run.name for run in self.runs)
        if self._is_watched:
            return (
                f"{names}: one call for each of Exudyn's steps, because user functions or native items "
                "are evaluated in between"
            )
        ahead = self._intervals(self.grid.loop_steps)
        return f"{names}: {ahead} of Exudyn's steps in one compiled call, because all loads are known"

    def advance(self, solver: Any, mbs: Any, settings: Any) -> bool:
        """One step of Exudyn's time loop: from the start-of-step to the end-of-step state."""
        if self._is_watched:
            self._take_over_changes()
        if not self._ahead:
            self._compute_ahead()
        state = self._ahead.pop()
        if state is None:
            self.error = self._divergence(mbs.systemData.GetTime())
            raise self.error
        self._set_q(state[0])
        self._set_v(state[1])
        self._set_a(state[2])
        if self._is_watched:
            self._written = [get() for get in self._getters]
        return True

    def _intervals(self, remaining: int) -> int:
        """Number of steps of the loop to compute in one call."""
        if self._is_watched:
            return 1
        coordinates = sum(len(run.indices) for run in self.runs)
        return max(1, min(remaining, LOOK_AHEAD_LIMIT // (coordinates * self.grid.substeps)))

    def _compute_ahead(self) -> None:
        intervals = self._intervals(self.grid.loop_steps - self._computed)
        states = np.zeros((intervals, 3, len(self._written[0])))
        for run in self.runs:
            history = np.zeros((intervals, 3, len(run.indices)))
            run.record(self.scheme, self.grid, self._computed, history)
            states[:, :, run.indices] = history
        self._computed += intervals
        finite = np.isfinite(states.sum(axis=(1, 2)))
        good = intervals if finite.all() else int(np.argmin(finite))
        self._ahead = [*states[:good].tolist(), *([None] if good < intervals else [])][::-1]

    def _take_over_changes(self) -> None:
        """A user function may have set coordinates since the last step: restart from them."""
        present = [get() for get in self._getters]
        if all(map(np.array_equal, present, self._written)):
            return
        q, v = map(np.asarray, present)
        for run in self.runs:
            run.state.q[:] = q[run.indices] + run.reference
            run.state.v[:] = v[run.indices]
            run.start(self.grid.time(self._computed))

    def _divergence(self, time: float) -> DivergenceError:
        names = [run.name for run in self.runs if not np.isfinite(run.state.q).all()]
        return DivergenceError(
            f"{', '.join(names) or 'the run'} diverged before t = {time:.6g} s: coordinates are not finite. "
            "mbs holds the last finite state. Likely causes: a step close to the stability limit of a "
            "cable that straightened, or a violent start; reduce stepSize, or change stabilizationRate."
        )


def _has_step_user_functions(mbs: Any) -> bool:
    """Whether functions of the user are called between the steps of Exudyn's loop."""
    return bool(mbs.GetPreStepUserFunction()) or bool(mbs.GetPostStepUserFunction())
