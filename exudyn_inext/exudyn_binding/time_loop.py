"""The user function that Exudyn's time loop calls in place of Newton's method."""

import math
import warnings
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
from operator import length_hint
from typing import Any

import numpy as np

from ..arrays import Array, as_slice
from ..cable.support_forces import Solved
from ..errors import DivergenceError, SceneError
from ..items.functions_of_time import has_sensor_functions, step_functions
from ..items.functions_that_look import asked_item_functions, may_change_anything
from ..items.parameters import CHECK_DIVISIONS
from ..native.compiled_form import active_general_contacts
from ..run.coupled_run import Run
from ..run.divergence import divergence, listed
from ..run.kept_state import KeptState
from ..run.time_grid import TimeGrid
from .kept_states import KeptStates
from .mbs_state import INITIAL, LastSteps, last_step
from .restart import Restarts
from .sensors import ACCELERATIONS, VELOCITIES, OutputTimes
from .shared_nodes import share_changes, shared_coordinates

LOOK_AHEAD_LIMIT = 1_000_000  # coordinates times steps in a call: some 30 ms, so that Ctrl-C works
HANDED_OUT = 64  # states that are turned into Python numbers at once
CALM = 4  # steps without a change, after which several are computed at once
COARSEST = 8.0  # times the step that resolves axial vibrations, with which a run begins again at most
FINER = 4.0  # times shorter steps, if that was too long
UNSEEN = 32  # steps at most that are computed ahead where functions may still change something


class _RememberingErrors:
    """Exudyn would replace the types and traces of errors by its own."""

    def __init__(self, loop: "ExplicitTimeLoop") -> None:
        self._loop = loop

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if isinstance(error, Exception):
            self._loop.error = error


class ExplicitTimeLoop:
    """Moves all cables of a scene; Exudyn calls `user_function` once for each step of its time loop.

    Where no user function can see or change the state between two steps of the loop, several of them
    are computed in one compiled call and handed out one by one: coordinates, and derivatives as far as
    they are `observed`; the last ones when the run ends. Where functions have changed nothing for some steps,
    this is done as well, and what is left of them is computed again after the next change.
    """

    step_is_from = ""  # what decided on the step, if the user did not
    output_times: OutputTimes | None = None  # None: somebody may look at each step

    def __init__(
        self,
        mbs: Any,
        runs: Sequence[Run],
        grid: TimeGrid,
        restarts: Restarts,
        observed: int,
        changes: Any,
    ) -> None:
        self.runs = runs
        self.changes = changes
        self.grid = grid
        self.error: Exception | None = None
        self._remembering_errors = _RememberingErrors(self)
        self._data = mbs.systemData
        self._is_watched = is_watched(mbs, runs)
        steers = any(may_change_anything(function, mbs) for function in step_functions(mbs))
        self._is_steered = steers and bool(asked_item_functions(mbs))
        self._only_items_ask = self._is_watched and not step_functions(mbs)
        self._contacts = contacts_in_view(mbs, runs) if self._is_watched or has_sensor_functions(mbs) else []
        self._written = self._present(INITIAL)
        self._shared = shared_coordinates(mbs, [one.item for one in changes.scene.cables])
        self._observed = max(observed, VELOCITIES) if self._is_watched else observed
        self._shows_forces = self._sees_forces = observed == ACCELERATIONS
        self.restarts = restarts
        self._places = [as_slice(run.indices) for run in runs]
        self._computed = grid.first  # steps of the loop
        self._ahead: tuple[int, Array] = (0, np.zeros((0, ACCELERATIONS, 0)))  # first step and its states
        self._reactions: deque[Array | None] = deque()  # after computed steps, where somebody looks at them
        self._last_reactions: Array | None = None
        self._remembered: deque[Any] = deque()  # by contacts, after these steps
        self._last_steps = LastSteps(mbs.sys, runs)
        self._blocks: Iterator[Iterable[Any]] = iter(())
        self._states: Iterator[Any] = iter(())  # of a block, where functions may make it void
        self._kept: list[KeptState] = []  # of the runs, before the block
        self._is_ahead = False  # the block of whom nobody but items asks, and at nothing but the motion
        self._calm = 0  # steps since something was changed
        self._skips_unseen = False  # states of a block that nobody looks at accelerations and forces in
        self._until_output = UNSEEN  # steps until somebody looks at accelerations and forces, where items ask
        self._is_changed = False  # before the step that is computed next
        self._are_shown = np.ones(0, bool)  # accelerations and forces, after each step of the block
        self._lacks_forces = False  # mbs, and accelerations: nobody was to look at them in its state
        self._shows_supports = self._lacks_supports = False  # where somebody looks at other forces
        is_unstretched = not (self._written[0].any() or np.any(self._data.GetAECoordinates(INITIAL)))
        self.kept_states = [KeptStates(run, is_unstretched) for run in runs]
        for run in runs:
            run.set_step(grid.h)
            run.start(grid.start)
        if restarts.found:
            restarts.resume(runs, grid)
            self._written = [np.asarray(part) for part in restarts.first_state]
        self._last_steps.keep(grid.time(grid.first), grid.substeps * grid.h, 1)

    @property
    def shows_accelerations(self) -> bool:
        """Whether somebody looks at them during the run."""
        return self._observed == ACCELERATIONS

    @property
    def user_function(self) -> Any:
        """f(solver, mbs, settings) that takes the state from the start to the end of a loop step."""
        return self._watched_user_function() if self._is_watched else self._plain_user_function()

    @property
    def time_of_steps(self) -> float:
        """That all steps have taken so far, those ahead included [s]."""
        return self.grid.time(self._computed) - self.grid.start

    @property
    def path(self) -> str:
        """Which way the steps are computed, and why."""
        names = listed([run.name for run in self.runs])
        if self._is_watched:
            reasons = [run.reason for run in self.runs if not run.looks_ahead]
            reasons = list(dict.fromkeys(reasons)) or ["pre- or post-step user functions may look at it"]
            if self._may_go_ahead:
                reasons[-1] += f" (up to {UNSEEN} steps at once while they change nothing)"
            return f"{names}: one call for each of Exudyn's steps, because {'; '.join(reasons)}"
        ahead, asked = self._steps_at_once, listed([run.asks for run in self.runs if run.asks])
        if asked:
            why = f"{asked}, asked in each, sees no more than its own motion"
            return f"{names}: {ahead} of Exudyn's steps in one call, because {why}"
        return f"{names}: {ahead} of Exudyn's steps in one compiled call, because all loads are known"

    @property
    def _steps_at_once(self) -> int:
        """Steps of the loop in the first compiled call."""
        return self._intervals(self.grid.first)

    def _plain_user_function(self) -> Any:
        self._blocks, self._states = self._blocks_of_states(), iter(())
        next_state = self._next_state if self._is_watched else chain.from_iterable(self._blocks).__next__
        setters, data = self._setters()[: self._observed], self._data
        besides = (self._reactions, data.SetAECoordinates), (self._remembered, data.SetDataCoordinates)

        def take_step(solver: Any, mbs: Any, settings: Any) -> bool:
            for put, values in zip(setters, next_state(), strict=True):
                put(values)
            for waiting, put in besides:
                values = waiting.popleft() if waiting else None
                if values is not None:
                    put(values)
            for contact in self._contacts:
                contact.UpdateContacts(mbs)
            return True

        return take_step

    def _setters(self) -> list[Any]:
        data = self._data
        return [data.SetODE2Coordinates, data.SetODE2Coordinates_t, data.SetODE2Coordinates_tt]

    def finish(self) -> None:
        """After the last step, if there was no error."""
        if self._is_watched:
            self.changes.require_all_seen(self.runs)
        self._write_restart()

    def cause_of(self, error: Exception, log: Any) -> BaseException:
        """Of an error of Exudyn's loop: what it has wrapped, if that is known.   log: `ChangeLog`.

        mbs has the time of its state then, where Exudyn has begun the next step.
        """
        if self._is_watched:
            self._data.SetTime(self.time)
        if self.error is None and "KeyboardInterrupt" in str(error):
            time = self._data.GetTime()
            return KeyboardInterrupt(f"interrupted at t = {time:.6g} s; mbs holds the state there.")
        if log.refused(error):
            return log.refusal
        return self.error or error

    def complete_state(self) -> None:
        """Give mbs the derivatives of its present coordinates that nobody observed so far."""
        self.show_forces()
        first, states = self._ahead
        taken = round((self._data.GetTime() - self.grid.start) / (self.grid.substeps * self.grid.h)) - first
        if len(states) and taken >= 1:
            state = states[min(taken, len(states)) - 1]
            for put, values in zip(self._setters()[1:], state[1:].tolist(), strict=True):
                put(values)
        if self._last_reactions is not None and taken == len(states):
            self._data.SetAECoordinates(self._last_reactions)

    def _watched_user_function(self) -> Any:
        plain = self._plain_user_function()

        def take_step(solver: Any, mbs: Any, settings: Any) -> bool:
            self._lacks_forces = self._lacks_supports = False
            if not (self._is_ahead and length_hint(self._states)):
                with self._remembering_errors:
                    self._take_over_changes()
                    self._follow_changes()
                if not length_hint(self._states):
                    self._shows_forces = self._sees_forces and self._is_output()
            plain(solver, mbs, settings)
            is_shown = self._is_ahead or self._are_shown[self._row]
            self._lacks_forces = self._sees_forces and not is_shown and self._completes
            return True

        return take_step

    @property
    def _completes(self) -> bool:
        """Whether compiled code alone gives accelerations and forces, whenever somebody looks at them."""
        return all(run.completes for run in self.runs)

    def show_forces(self, of_supports: bool = True) -> None:
        """Give mbs accelerations and forces in its state, if nobody was to look at them: somebody does.

        of_supports: whether at those of supports of cables, which are left out until somebody does.
        """
        self._shows_supports |= of_supports
        if not (self._lacks_forces or (of_supports and self._lacks_supports)):
            return
        self._lacks_forces, self._lacks_supports = False, not self._shows_supports
        state, reactions = self._ahead[1][self._row :][:1], np.zeros((1, self._data.AEsize()))
        time, row = np.array([self.time]), np.array([self._taken - self._computed - 1])
        for run, places in zip(self.runs, self._places, strict=True):
            history = state[:, :, places]
            run.complete(time, row, history, reactions, self._shows_supports)
            state[:, :, places] = history
        self._data.SetODE2Coordinates_tt(state[0, ACCELERATIONS - 1].tolist())  # faster than arrays
        self._data.SetAECoordinates(reactions[0].tolist())

    @property
    def _asks_ahead(self) -> bool:
        """Whether only functions of items look at mbs, in each step, and at nothing but its motion."""
        looks = self.output_times
        if not self._only_items_ask or looks is None or looks.items_look_at_forces:
            return False
        return all(run.looks_ahead or run.asks_ahead for run in self.runs)

    @property
    def _may_go_ahead(self) -> bool:
        """Whether steps that functions of the user take part in may be computed before they see the first."""
        return self._asks_ahead or all(run.is_steady for run in self.runs)

    def _is_output(self) -> bool:
        """Whether somebody looks at accelerations and forces after the next steps that are computed.

        Where items ask for the state, these steps end there.
        """
        self._until_output, self._skips_unseen = UNSEEN, False
        if self.output_times is None:
            return True
        steps = self._intervals(self._computed)
        asks_items = not all(run.looks_ahead or run.is_steady for run in self.runs)
        if steps > 1 and not self._asks_ahead:
            self._skips_unseen = self._completes and self.output_times.due(asks_items, False) > -math.inf
            return True
        time, step = self.grid.time(self._computed), self.grid.substeps * self.grid.h
        nearest = (self.output_times.due(asks_items, self._completes) - time) / step + 0.5
        number = int(max(1.0, min(nearest, self.grid.loop_steps - self._computed)))
        if number <= steps:
            self._until_output = number
        return number <= steps

    def _next_state(self) -> Any:
        """As `_blocks_of_states` gives it, and remembered as what mbs then holds."""
        state = next(self._states, None)
        if state is None:
            self._states = iter(next(self._blocks))
            state = next(self._states)
            self._is_ahead = self._asks_ahead
            if self._is_ahead:  # they have been asked in later states
                self._data.SetTime(self.time)
        self._calm += 1
        left = length_hint(self._states)
        if not (self._is_ahead and left):  # mbs is looked at before the next step
            first, states = self._ahead
            present = states[self._computed - left - first - 1]
            self._written = [present[0], present[1], self._data.GetODE1Coordinates()]
        return state

    @property
    def _taken(self) -> int:
        """Steps of the loop whose states have been handed out."""
        return self._computed - length_hint(self._states)

    @property
    def _row(self) -> int:
        """Of the state that was handed out last, in its block."""
        return self._taken - self._ahead[0] - 1

    def _withdraw(self) -> None:
        """Let the runs be in the state that was handed out last: something has been changed there."""
        first, taken = self._ahead[0], self._taken
        self._calm = 0
        if taken < self._computed:
            self._states = iter(())
            self._return_to(first)
            for run in self.runs if taken > first else ():
                run.record(self.grid, first, np.empty((taken - first, 3, len(run.indices))))
            self._computed = taken

    def _return_to(self, first: int) -> None:
        """The step before a block."""
        self._computed = first
        self._reactions.clear()
        self._remembered.clear()
        for run, kept in zip(self.runs, self._kept, strict=True):
            kept.restore()
            run.try_again()
            run.resume(self.grid.time(first))

    def _blocks_of_states(self) -> Iterator[Iterable[Any]]:
        """Some steps of the loop: after each, a list of what is observed.

        DivergenceError instead of a bad one.
        """
        while True:
            first = self._computed
            try:
                with self._remembering_errors:
                    states, good = self._compute_well()
            except BaseException:
                self._put_back()
                raise
            self._ahead = (first, states[:good])
            for block in range(0, good, HANDED_OUT):
                yield states[block : min(block + HANDED_OUT, good), : self._observed].tolist()
            if good < len(states):
                self.error = self._divergence(self.grid.time(first + good), self.grid.time(first + good + 1))
                self._computed = first + good
                self._put_back()
                raise self.error

    def _put_back(self) -> None:
        """The time of the state that was handed out last; and that state, if mbs took part in later steps."""
        self._data.SetTime(self.time)
        if self._is_watched:
            data = self._data
            putters = data.SetODE2Coordinates, data.SetODE2Coordinates_t, data.SetODE1Coordinates
            for put, values in zip(putters, self._written, strict=True):
                put(values)

    def _divergence(self, last_good: float, time: float) -> DivergenceError:
        verdicts = [run.verdict(last_good, self.grid.h) for run in self.runs]
        left = f"mbs holds the last good output, that of t = {last_good:.6g} s."
        if self.step_is_from:
            chosen = f"The automatic step of this run was {self.grid.h:.4g} s, decided by {self.step_is_from}"
            is_known = any(run.known_cause(last_good) for run in self.runs if run.gave_up)
            left = f"{chosen}. {left}" if is_known else f"{chosen}: a stepSize has to be smaller. {left}"
        error = divergence(list(filter(None, verdicts)), time, left)
        gave_up = [run for run in self.runs if run.gave_up and not run.jump]
        hiding = [run.watch.resolving_step for run in gave_up if run.watch.hides_energy]
        resolving = max(hiding, default=0.0)
        if self.grid.h > resolving > 0.0:
            error.shorter_step = min(COARSEST * resolving, self.grid.h / FINER)
        return error

    def _compute_well(self) -> tuple[Array, int]:
        """As `_compute_ahead`; what goes wrong there is tried again after one step, which functions see."""
        self._write_restart()
        self._rehearse()
        first, intervals = self._computed, self._intervals(self._computed)
        if not self._is_watched or intervals == 1:
            return self._compute_ahead(intervals)
        self._keep()
        with suppress(Exception):  # of a function of the user, perhaps: which is called again then
            states, good = self._compute_ahead(intervals)
            if good == intervals:
                return states, good
        self._calm = 0
        self._return_to(first)
        return self._compute_ahead(1)

    def _rehearse(self) -> None:
        """After changes, if functions see the steps, which then cannot be undone."""
        begins = self._is_watched and self.restarts.may_begin(self.grid, self._computed)
        is_due, self._is_changed = begins or (self._is_watched and self._is_changed), False
        if not is_due:
            return
        most = 0 if self.changes.moves else self.restarts.steps_until_due(self.grid, self._computed)
        for run in self.runs:
            limit = LOOK_AHEAD_LIMIT // (len(run.indices) * self.grid.substeps)
            run.rehearse(self.grid, self._computed, min(most, limit), begins)

    def _keep(self) -> None:
        """What runs return to if steps turn out to be void."""
        if self._kept:
            for kept in self._kept:
                kept.keep()
        else:
            self._kept = [run.present_state() for run in self.runs]

    def _compute_ahead(self, intervals: int) -> tuple[Array, int]:
        """(intervals, 3, n) displacements, velocities, accelerations after the next loop steps.

        And how many of them are good.
        """
        takes_last_step = self._computed + intervals == self.grid.loop_steps
        states = np.zeros((intervals, 3, len(self._written[0])))
        reactions: list[Array | None] = [None] * intervals
        good, is_seen = intervals, self._shows_forces or takes_last_step
        self._are_shown = np.full(intervals, self._shows_forces)
        begins = not self._is_watched and self.restarts.may_begin(self.grid, self._computed)
        for run, places, kept in zip(self.runs, self._places, self.kept_states, strict=True):
            is_all = len(run.indices) == states.shape[2] and isinstance(places, slice)
            history = states if is_all else np.empty((intervals, 3, len(run.indices)))
            run.may_begin_again = begins
            good = min(good, run.record(self.grid, self._computed, history))
            done = history[:good]
            kept.keep(self.grid, self._computed, done)
            if good and is_seen and not run.completes:
                self._complete_last(run, done, reactions)
            elif good and (is_seen or not self._is_watched):
                self._complete(run, self._computed, done, reactions)
            if not is_all:
                states[:, :, places] = history
            if run.remembered is not None:
                self._remembered.extend(run.remembered.tolist())
        self._last_reactions = reactions[good - 1] if good else None
        if self._shows_forces:
            self._reactions.extend(reactions[:good])
        self._last_steps.keep(self.grid.time(self._computed + 1), self.grid.substeps * self.grid.h, good)
        self._computed += intervals
        return states, good

    def _complete_last(self, run: Run, history: Array, reactions: list[Array | None]) -> None:
        """Accelerations and reactions in the last of these states, which mbs is in.   reactions: output."""
        last = len(history) - 1
        own = self._reactions_at(last, reactions)
        history[last, 2] = run.accelerations(self.grid.time(self._computed + 1 + last), own)

    def _complete(self, run: Run, first: int, history: Array, reactions: list[Any]) -> None:
        """Accelerations and reactions in the states that somebody looks at, and in the last one.

        first: step of the loop before them.   reactions: output, None in others.
        """
        times = np.array([self.grid.time(first + 1 + k) for k in range(len(history))])
        self._are_shown = self._are_seen(times)
        rows = np.flatnonzero(self._are_shown)
        states, multipliers = history[rows], np.zeros((len(rows), self._data.AEsize()))
        if run.complete(times[rows], rows - len(history), states, multipliers):
            for row, own in zip(rows.tolist(), multipliers, strict=True):
                self._reactions_at(row, reactions)[:] += own
        history[rows, 2] = states[:, 2]

    def _reactions_at(self, row: int, reactions: list[Array | None]) -> Array:
        """(m,) those of one state, to be set."""
        found = reactions[row]
        if found is None:
            found = reactions[row] = np.zeros(self._data.AEsize())
        return found

    def _are_seen(self, times: Array) -> Array:
        """(k,) whether somebody looks at accelerations and forces in these states; true for the last one."""
        result = np.full(len(times), self._shows_forces and not self._asks_ahead)
        may_skip = self._skips_unseen or not self._is_watched
        if result[0] and self.output_times is not None and may_skip:
            result = self.output_times.among(times)
        result[-1] = True
        return result

    def _write_restart(self) -> None:
        """If it is time to: all that has been computed has been handed out."""
        if self.restarts.is_due(self.grid, self._computed):
            self.complete_state()
            self.restarts.write(self.runs, self.grid, self._computed)

    def _intervals(self, step: int) -> int:
        """Number of steps of the loop to compute in one call, after that step."""
        if self._is_watched and (self._calm < CALM or self.changes.moves or not self._may_go_ahead):
            return 1
        remaining = min(self.grid.loop_steps - step, self.restarts.steps_until_due(self.grid, step))
        if self._is_watched:
            remaining = min(remaining, self._calm // 2, self._until_output)
        coordinates = sum(len(run.indices) for run in self.runs)
        return max(1, min(remaining, LOOK_AHEAD_LIMIT // (coordinates * self.grid.substeps)))

    def _present(self, *configuration: Any) -> list[Array]:
        data = self._data
        getters = data.GetODE2Coordinates, data.GetODE2Coordinates_t, data.GetODE1Coordinates
        return [get(*configuration) for get in getters]

    @property
    def time(self) -> float:
        """After the steps of the loop that have been handed out [s]."""
        return self.grid.time(self._taken)

    def _follow_changes(self, jumps: bool = False) -> None:
        """A user function may have changed items since the last step: go on with what they are now.

        jumps: see `ChangeFollower.follow`.
        """
        time = self.time
        has_news = self.changes.has_news(self.runs, time)
        for kept in self.kept_states if has_news or self._is_steered else ():
            kept.change_forces(time)
        if not has_news:
            return
        self._withdraw()
        try:
            runs = self.changes.follow(self.runs, time, self.grid.time(self._computed + 1), jumps)
        except Exception:
            self._data.SetTime(time)
            raise
        self._is_changed |= self.changes.is_event
        self._kept.clear()
        if runs is not self.runs:
            self.runs, self._places = runs, [as_slice(run.indices) for run in runs]
            self._last_steps = LastSteps(self._last_steps.place, runs)
            self.kept_states = list(map(KeptStates, runs))

    def solved(self, cable: int, time: float) -> Solved | None:
        """A cable, by its object, in the state of mbs; None: nobody has asked for forces there, or
        something has been changed since.

        time: of mbs, which is that of the next state where a pre-step function looks.
        """
        present = self._present()
        if self._is_watched:
            if self.changes.log.is_pending or not self._is_as_handed_out(present):
                return None
            time = self.time
        if time <= self.grid.time(self.grid.first):  # there, only the run has what was corrected
            return None
        step = last_step(self._last_steps.place, cable, time)
        found = (run.solved(cable, time, present[:2], step) for run in self.runs)
        return next(filter(None, found), None)

    def _is_as_handed_out(self, present: Sequence[Array]) -> bool:
        """Whether the state of mbs is still that which it was given last."""
        return [now.tobytes() for now in present] == [then.tobytes() for then in self._written]

    def _take_over_changes(self) -> None:
        """A user function may have set coordinates since the last step: restart from them."""
        present = self._present()
        if self._is_as_handed_out(present):
            return
        if not all(np.isfinite(part).all() for part in present):
            self.changes.log.refuse(
                "coordinates or velocities were set to what is no number", CHECK_DIVISIONS
            )
        self._withdraw()
        self._is_changed = True
        q, v, first_order = present
        share_changes(self._shared, (q, v), self._written[:2])
        for run in self.runs:
            number = len(run.indices)
            run.state.q[:number] = q[run.indices] + run.reference
            run.state.v[:number] = v[run.indices]
            if len(run.state.v) > number:  # first order states are moved as velocities
                run.state.v[number:] = first_order
            self._start(run)

    def _start(self, run: Run) -> None:
        """Let a run go on from a state that it has been given."""
        run.start(self.time)


def warn_of_findings(runs: Sequence[Run], tolerance: float) -> None:
    """Once a run, of an energy that has grown by more than that share of its motion, and of friction."""
    for run in runs:
        gain = run.figures().get("energyGain", 0.0)
        if gain > tolerance * run.lenience:
            warnings.warn(
                f"{run.name}: the energy has grown by {gain:.2%} of the energy of the motion, beyond the "
                f"work done on it (energyTolerance {tolerance:.2%}): {run.remedy}.",
                stacklevel=3,
            )
        if run.finding:
            warnings.warn(run.finding, stacklevel=3)


def worst_figures(runs: Sequence[Any]) -> dict[str, float]:
    """Of each figure, the largest of all runs."""
    all_of_them = [run.figures() for run in runs]
    names = dict.fromkeys(name for figures in all_of_them for name in figures)
    return {name: max(figures[name] for figures in all_of_them if name in figures) for name in names}


def is_watched(mbs: Any, runs: Sequence[Run]) -> bool:
    """Whether functions of the user, between steps of Exudyn's loop, may see or change something."""
    return bool(step_functions(mbs)) or not all(run.looks_ahead for run in runs)


def contacts_in_view(mbs: Any, runs: Sequence[Run]) -> list[Any]:
    """GeneralContacts that Exudyn does not evaluate, whose distances functions of the user may look at."""
    return active_general_contacts(mbs) if all(run.completes for run in runs) else []


def refuse_newton_functions(mbs: Any) -> None:
    """Raise SceneError if the user has functions that only Newton's method calls."""
    for name in ("PostNewtonUserFunction", "PreNewtonResidualUserFunction"):
        if getattr(mbs, f"Get{name}")():
            raise SceneError(
                f"mbs has a {name}, which explicit steps do not call: remove it, mbs.Set{name}(0), and let a "
                "function of mbs.SetPreStepUserFunction or mbs.SetPostStepUserFunction do what it does."
            )


def refuse_step_functions(mbs: Any, where: str) -> None:
    """Raise SceneError if the user has such functions.   where: they would not be called."""
    refuse_newton_functions(mbs)
    if step_functions(mbs):
        raise SceneError(
            f"mbs has a pre- or post-step user function, which is not called {where}: remove it, or use "
            "SolveExplicit."
        )
