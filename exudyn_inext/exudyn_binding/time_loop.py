"""The user function that Exudyn's time loop calls in place of Newton's method."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

import exudyn
import numpy as np

from ..arrays import Array
from ..chain.cable import Cable
from ..errors import DivergenceError
from .consistent_start import StartCorrection
from .observed import ACCELERATIONS
from .time_grid import TimeGrid

LOOK_AHEAD_LIMIT = 1_000_000  # coordinates times steps in a call: some 30 ms, so that Ctrl-C works
HANDED_OUT = 64  # states that are turned into Python numbers at once


class Run(Protocol):
    """What the loop moves: a cable, or native items; see CableRun for the attributes."""

    state: Any
    indices: np.ndarray
    reference: Array
    looks_ahead: bool

    @property
    def reason(self) -> str: ...

    @property
    def cables(self) -> Sequence[Cable]: ...

    @property
    def start_corrections(self) -> Sequence[StartCorrection]: ...

    @property
    def name(self) -> str: ...

    def start(self, time: float) -> None: ...

    def largest_frequency(self, time: float) -> float: ...

    def damping_ratio(self, frequency: float) -> float: ...

    def record(self, scheme: Any, grid: TimeGrid, first: int, history: Array) -> None: ...

    def is_credible(self, history: Array) -> np.ndarray: ...

    def trouble(self, scheme: Any) -> str: ...


class ExplicitTimeLoop:
    """Moves all cables of a scene; Exudyn calls `user_function` once for each step of its time loop.

    Where no user function can see or change the state between two steps of the loop, several of them
    are computed in one compiled call and handed out one by one: coordinates, and derivatives as far as
    they are `observed`; the last ones when the run ends.
    """

    def __init__(
        self, mbs: Any, runs: Sequence[Run], scheme: Any, grid: TimeGrid, observed: int = ACCELERATIONS
    ) -> None:
        self.runs = runs
        self.scheme = scheme
        self.grid = grid
        self.error: Exception | None = None
        self._data = mbs.systemData
        self._is_watched = _has_step_user_functions(mbs) or not all(run.looks_ahead for run in runs)
        self._written = self._present(exudyn.ConfigurationType.Initial)
        self._observed = ACCELERATIONS if self._is_watched else observed
        self._computed = 0  # steps of the loop
        self._ahead: tuple[int, Array] = (0, np.zeros((0, ACCELERATIONS, 0)))  # first step and its states
        for run in runs:
            run.start(grid.start)

    @property
    def user_function(self) -> Any:
        """f(solver, mbs, settings) that takes the state from the start to the end of a loop step."""
        return self._watched_user_function() if self._is_watched else self._plain_user_function()

    @property
    def path(self) -> str:
        """Which way the steps are computed, and why."""
        names = ", ".join(run.name for run in self.runs)
        if self._is_watched:
            reasons = [run.reason for run in self.runs if not run.looks_ahead]
            reasons = list(dict.fromkeys(reasons)) or ["pre- or post-step user functions may look at it"]
            return f"{names}: one call for each of Exudyn's steps, because {'; '.join(reasons)}"
        ahead = self._intervals(self.grid.loop_steps)
        return f"{names}: {ahead} of Exudyn's steps in one compiled call, because all loads are known"

    def _plain_user_function(self) -> Any:
        next_state = self._states().__next__
        set_q, *set_others = self._setters()[: self._observed]

        def take_step_of_positions(solver: Any, mbs: Any, settings: Any) -> bool:
            (q,) = next_state()
            set_q(q)
            return True

        def take_step(solver: Any, mbs: Any, settings: Any) -> bool:
            q, *others = next_state()
            set_q(q)
            for put, values in zip(set_others, others, strict=True):
                put(values)
            return True

        return take_step if set_others else take_step_of_positions

    def _setters(self) -> list[Any]:
        data = self._data
        return [data.SetODE2Coordinates, data.SetODE2Coordinates_t, data.SetODE2Coordinates_tt]

    def complete_state(self) -> None:
        """Give mbs the derivatives of its present coordinates that nobody observed so far."""
        first, states = self._ahead
        taken = round((self._data.GetTime() - self.grid.start) / (self.grid.substeps * self.grid.h)) - first
        if len(states) and taken >= 1:
            state = states[min(taken, len(states)) - 1]
            for put, values in zip(self._setters()[1:], state[1:].tolist(), strict=True):
                put(values)

    def _watched_user_function(self) -> Any:
        plain = self._plain_user_function()

        def take_step(solver: Any, mbs: Any, settings: Any) -> bool:
            with self._remembering_errors():
                self._take_over_changes()
            plain(solver, mbs, settings)
            self._written = self._present()
            return True

        return take_step

    def _states(self) -> Iterator[list[list[float]]]:
        """q and what is observed after each step of the loop; DivergenceError instead of a bad one."""
        while True:
            first = self._computed
            with self._remembering_errors():
                states = self._compute_ahead()
            credible = [run.is_credible(states[:, :, run.indices]) for run in self.runs]
            good = min(int(np.argmin(np.append(those, False))) for those in credible)
            self._ahead = (first, states[:good])
            observed = states[:good, : self._observed]
            for block in range(0, good, HANDED_OUT):
                yield from observed[block : block + HANDED_OUT].tolist()
            if good < len(states):
                culprits = [r.name for r, those in zip(self.runs, credible, strict=True) if not those[good]]
                end = self.grid.time(first + good + 1)
                troubles = " ".join(run.trouble(self.scheme) for run in self.runs).strip()
                self.error = divergence(culprits, end, f"mbs holds the last good output. {troubles}".strip())
                raise self.error

    @contextmanager
    def _remembering_errors(self) -> Iterator[None]:
        """Exudyn would replace their types and traces by its own."""
        try:
            yield
        except Exception as error:
            self.error = error
            raise

    def _compute_ahead(self) -> Array:
        """(intervals, 3, n) displacements, velocities, accelerations after the next loop steps."""
        intervals = self._intervals(self.grid.loop_steps - self._computed)
        states = np.zeros((intervals, 3, len(self._written[0])))
        for run in self.runs:
            history = np.empty((intervals, 3, len(run.indices)))
            run.record(self.scheme, self.grid, self._computed, history)
            states[:, :, run.indices] = history
        self._computed += intervals
        return states

    def _intervals(self, remaining: int) -> int:
        """Number of steps of the loop to compute in one call."""
        if self._is_watched:
            return 1
        coordinates = sum(len(run.indices) for run in self.runs)
        return max(1, min(remaining, LOOK_AHEAD_LIMIT // (coordinates * self.grid.substeps)))

    def _present(self, configuration: Any = exudyn.ConfigurationType.Current) -> list[list[float]]:
        data = self._data
        return [data.GetODE2Coordinates(configuration), data.GetODE2Coordinates_t(configuration)]

    def _take_over_changes(self) -> None:
        """A user function may have set coordinates since the last step: restart from them."""
        present = self._present()
        if all(map(np.array_equal, present, self._written)):
            return
        q, v = map(np.asarray, present)
        for run in self.runs:
            run.state.q[:] = q[run.indices] + run.reference
            run.state.v[:] = v[run.indices]
            run.start(self.grid.time(self._computed))


def divergence(culprits: list[str], time: float, what_is_left: str) -> DivergenceError:
    """The error of a run that left what a cable can do before `time` [s]."""
    return DivergenceError(
        f"{', '.join(culprits)} diverged before t = {time:.6g} s: its coordinates are not finite, or not "
        f"those of an inextensible cable. {what_is_left} Likely causes: a step close to the "
        "stability limit of a cable that straightened, or a violent start; reduce stepSize, use RATTLE, "
        "or change stabilizationRate."
    )


def _has_step_user_functions(mbs: Any) -> bool:
    """Whether functions of the user are called between the steps of Exudyn's loop."""
    return bool(mbs.GetPreStepUserFunction()) or bool(mbs.GetPostStepUserFunction())
