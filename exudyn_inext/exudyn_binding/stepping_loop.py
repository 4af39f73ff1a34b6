"""The time loop of `ExplicitSolver`: portion by portion, with whatever is set in between."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..checks import LARGEST, require_positive
from ..native.native_items import state_kept
from ..run.cable_run import Start
from ..run.coupled_run import Run
from ..run.kept_state import KeptState
from ..run.settings import ExplicitSettings
from ..run.time_grid import MOST_LOOP_STEPS, TimeGrid, steps_of_interval
from .changes.follower import ChangeFollower, start_after_jump
from .restart import Restarts
from .sensors import ACCELERATIONS
from .time_loop import ExplicitTimeLoop, is_watched

_SAME = 1e-6  # difference of two times that counts as round-off, in steps of Exudyn's loop


class Portion(NamedTuple):
    """Equal steps of Exudyn's loop.   start: [s].   step: of the loop [s].   steps: how many."""

    start: float
    step: float
    steps: int

    @classmethod
    def next_of(cls, solver: Any) -> "Portion":
        """Those that a solver of Exudyn takes at the next call of SolveSteps.

        Raises:
            InputError: no time is left.
        """
        it = solver.it
        left = require_positive("timeIntegration.endTime - startTime [s]", it.endTime - it.currentTime)
        return cls(it.currentTime, it.maxStepSize, max(1, round(left / it.maxStepSize)))


class SteppingLoop(ExplicitTimeLoop):
    """As in a run, states are computed ahead where nobody looks in between, but within a portion only.

    Between two portions anybody may set coordinates, velocities and parameters, and change the steps.

    Args:
        mbs: the system.   runs: of it, as they were built.   start: [s].
        largest: step of the integrator [s].   duration: of the motion, at most [s].
        explicit: settings.   restarts: without files.
        changes: of the parameters of mbs.
    """

    def __init__(
        self,
        mbs: Any,
        runs: Sequence[Run],
        start: float,
        largest: float,
        duration: float,
        explicit: ExplicitSettings,
        restarts: Restarts,
        changes: ChangeFollower,
    ) -> None:
        self.mbs, self._largest, self._duration, self._explicit = mbs, largest, duration, explicit
        self._built, self._path_as_built = runs, [run.looks_ahead for run in runs]
        self._initial = [KeptState(run.memory()) for run in runs]
        self._begins, self._portion = True, Portion(start, largest, 1)
        super().__init__(mbs, runs, TimeGrid(start, 1, 1, largest), restarts, ACCELERATIONS, changes)

    @property
    def is_as_built(self) -> bool:
        """Whether no change has called for other runs, nor for Exudyn in place of kernels."""
        if self.changes.log.is_outdated or self.runs is not self._built:
            return False
        return self._path_as_built == [run.looks_ahead for run in self.runs]

    def require_all_seen(self) -> None:
        """See `ChangeFollower.require_all_seen`."""
        self.changes.require_all_seen(self.runs)

    def begin_anew(self) -> None:
        """The next portion begins from the state that mbs has then; drift corrections are reset."""
        self.error, self._begins = None, True
        for run, initial in zip(self._built, self._initial, strict=True):
            initial.restore()
            run.try_again()

    def prepared(self, portion: Portion, observed: int) -> Callable[[Any, Any, Any], bool]:
        """The user function that takes the steps of a portion.   observed: derivatives in between."""
        if self._begins or not self._goes_on_with(portion):
            self._begin(portion)
        self._portion, self.changes.log.is_idle = portion, False
        self.grid = replace(self.grid, loop_steps=self._computed + portion.steps)
        self._is_watched = is_watched(self.mbs, self.runs)
        self._observed = ACCELERATIONS if self._is_watched else observed
        self._shows_forces = self._observed == ACCELERATIONS
        return self._function_of_portion()

    def finish_portion(self) -> None:
        """Complete the state of mbs, after all steps or those before somebody stopped the loop."""
        self.changes.log.is_idle = True
        self.complete_state()
        self._withdraw()
        self._written = self._present()
        self._begins = self.error is not None or not self._is_now(self._data.GetTime())

    def _function_of_portion(self) -> Callable[[Any, Any, Any], bool]:
        plain, is_first = self._plain_user_function(), True

        def take_step(solver: Any, mbs: Any, settings: Any) -> bool:
            nonlocal is_first
            with self._remembering_errors:
                if is_first:
                    self._begin_portion()
                else:
                    self._look_between_steps()
            is_first = False
            plain(solver, mbs, settings)
            return True

        return take_step

    def _begin_portion(self) -> None:
        """Take over the state, and then what has changed: what was set between portions jumps.

        A start anew does not look at what acted before it.
        """
        log = self.changes.log
        has_jumped, log.has_jumped = log.has_jumped and log.is_pending, False
        if self._begins:
            self._follow_changes(jumps=True)
            self._take_over_changes()
            for run in self.runs if not self.changes.moves else ():
                run.rehearse_start(self.grid, self._duration)
            return
        self._take_over_changes()
        self._follow_changes(has_jumped)
        if has_jumped:
            with state_kept(self.mbs):
                for run in self.runs:
                    start_after_jump(run, run.start_scheme, self.time)

    def _look_between_steps(self) -> None:
        if self._is_watched:
            self._take_over_changes()
        if self._is_watched or self.changes.moves:
            self._follow_changes()

    def _begin(self, portion: Portion) -> None:
        substeps, h = steps_of_interval(portion.step, self._largest, MOST_LOOP_STEPS)
        self.grid, self._computed, self._begins = TimeGrid(portion.start, portion.steps, substeps, h), 0, True
        self._ahead = (0, np.zeros((0, ACCELERATIONS, 0)))
        self._written = [np.full(len(part), np.nan) for part in self._present()]  # that of mbs is taken over
        self._reactions.clear()
        self.changes.reader.drives.start(portion.start)
        self.changes.take_step(self._explicit, h)
        for run in self.runs:
            run.set_step(h)

    def _goes_on_with(self, portion: Portion) -> bool:
        step = self.grid.substeps * self.grid.h
        return self._is_now(portion.start) and abs(portion.step - step) <= _SAME * step

    def _is_now(self, time: float) -> bool:
        return abs(time - self.time) <= _SAME * self.grid.substeps * self.grid.h

    def _start(self, run: Run) -> None:
        explicit = self._explicit
        if self.changes.moves:  # a support that is to be elsewhere at the end of the step gives any velocity
            explicit = replace(explicit, startTolerance=LARGEST)
        with state_kept(self.mbs):
            run.make_consistent(Start(self.time, self.grid.h, explicit))
        super()._start(run)

    @property
    def _steps_at_once(self) -> int:
        return self._intervals(self.grid.loop_steps - self._portion.steps)

    def _intervals(self, step: int) -> int:
        is_steady = not self.changes.moves and all(run.looks_ahead for run in self.runs)
        return super()._intervals(step) if is_steady else 1
