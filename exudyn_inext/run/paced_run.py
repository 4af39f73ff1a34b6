"""A run whose steps may go wrong: they are taken again, smaller, from the last good state."""

import math
from contextlib import suppress
from typing import Any

import numpy as np

from ..arrays import Array, Places
from ..constraints.motion import find_jump
from ..integrators.integrator import Integrator
from .jump_ahead import SEEN_AHEAD, JumpError
from .kept_state import KeptState
from .redundancy import pulled_straight
from .run_watch import RunWatch
from .step_control import PIECE, ROUND_OFF, Piece, StepControl
from .time_grid import TimeGrid
from .watch import ENERGY, LACK_OF_WORK, NOT_FINITE, SPRINGS, TOO_FAST

HIDING_PARTS = 16  # of the nominal step, from which on steps that go wrong are smaller for a while only
LEAST_REHEARSED = 4  # intervals of the loop
STEPS_OF_MOTION, FAST = (64, 256), 0.1  # that show how fast a motion begins; by step [rad]
STEPS_REHEARSED = 1000  # at most, of a run that goes on portion by portion
SHORTER = 0.9  # times the step before, from which on it sets axial vibrations free
LONGER = 4.0  # times the step, with which accelerations are compared
STEPS_OF_RAMP = 20.0  # in place of a jump
NO_NUMBER = (
    "Likely cause: a user function that returns no number (NaN) there: look for what it divides by zero, and "
    "let it return finite numbers."
)
VIBRATING = (
    "Likely cause: springs that are much too stiff for what they hold, and stretched at the start or by a "
    "blow: let them be softer, damp more, or be joints."
)
SMALLEST_PARTS = 256  # and up to which all are, where no smaller ones for a while go well


class PacedRun:
    """What a cable and a coupled scene have in common; see `step_control`.

    integrator, scheme: of the run.   state: of the integrator.   control: of the steps.
    indices: (n_dof,) places of the coordinates in the system vector.
    watch: `RunWatch`, which finds steps that went wrong.   gave_up: whether there are no smaller ones.
    jump: because of which it did, or None.
    trouble: what the integrator said of the last steps that went wrong.
    looks_ahead: whether several steps of the time loop can be computed at once.
    asks_ahead: whether they can, although functions are asked in each of them, which look at the motion only.
    asks: of which item compiled steps ask a function, if they do.
    completes: whether `complete` finds accelerations; otherwise `accelerations` does.
    elsewhere: what of the state lies in no array of the run, see `KeptState`.
    remembered: (k, D) by contacts after the intervals of the last `record`; None: mbs knows, or there are
        none.
    data: (2, D) what contacts in compiled code remember, now and from the start of the step.
    finding: what the user is to be told at the end, besides the energy.
    steps: (intervals,) last step before the end of each one of the last `advance` [s].
    """

    integrator: Integrator
    scheme: Any
    state: Any
    control: StepControl
    indices: Any
    _rejects: bool  # see `ExplicitSettings.rejectSteps`
    watch: Any
    looks_ahead = asks_ahead = False
    asks = ""
    gave_up = False
    jump: JumpError | None = None
    may_begin_again = False  # from wherever `advance` begins
    trouble = ""
    finding = ""
    elsewhere: Any = None
    remembered: Array | None = None

    data: Array = np.zeros((2, 0))
    steps: Array = np.zeros(0)

    @property
    def damps_implicitly(self) -> bool:
        """Whether dashpots of springs are implicit."""
        return False

    @property
    def completes(self) -> bool:
        return self.looks_ahead

    @property
    def has_implicit_bending(self) -> bool:
        """Whether the equations depend on the step."""
        raise NotImplementedError

    @property
    def cable_runs(self) -> Any:
        """(k,) `CableRun`, those of its cables."""
        raise NotImplementedError

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on, by names: to be kept, or set before `resume`."""
        raise NotImplementedError

    def has_mean_forces(self, duration: float) -> bool:
        """Whether what is set before so long an interval of the loop [s] acts on average, without a line."""
        return False

    @property
    def evaluated_by(self) -> str:
        """Who evaluates bodies and joints; empty where cables are alone."""
        return ""

    def evaluate_by(self, kept: str) -> None:
        """Before `resume`: let the same evaluate bodies and joints as in the run that this one continues."""

    def present_state(self) -> KeptState:
        """All that the next steps depend on, as it is now."""
        return KeptState(self.memory(), self.elsewhere)

    @property
    def flight(self) -> Array:
        """(n_dof,) velocities of a frame that flies along with the present state, see `Flight`."""
        velocities: Array = self.watch.flight.along(self.state.v)[0]
        return velocities

    def places(self, time: float) -> Array:
        """(k,) where supports and joints are at `time` [s], from wherever they are counted [m, rad]."""
        raise NotImplementedError

    @property
    def names_of_places(self) -> list[str]:
        """(k,) whose `places` are, for messages."""
        raise NotImplementedError

    def known_cause(self, time: float) -> str:
        """Why no step was small enough, if that is known.   time: start of the interval of the loop [s]."""
        time, step = time + self.control.offset, self.watch.resolving_step
        soon = max(2 * PIECE * self.control.present, SEEN_AHEAD)
        begin, end = (self.jump.begin, self.jump.end) if self.jump else (time, time + soon)
        names = self.names_of_places
        if names and (jump := find_jump(self.places, begin, end)):
            return (
                f"Cause: {names[jump.number]} moves by {jump.size:.3g} m (or rad) at once at "
                f"t = {jump.time:.6g} s, for which no step is small enough: let it get there by a "
                f"smooth ramp of {STEPS_OF_RAMP * self.control.largest:.2g} s or longer."
            )
        if kick := max((run.loads.jump_of_velocity(time) for run in self.cable_runs), default=0.0):
            return (
                f"Likely cause: the velocity of a support jumps by {kick:.3g} m/s near t = {time:.6g} s, as "
                "where lines are drawn between the points of a table: draw a smooth curve (scipy's "
                "CubicSpline), or set energyTolerance = 10, which bears the work of such jumps."
            )
        is_no_number = self.watch.trouble == NOT_FINITE and self.control.is_smallest
        if is_no_number and (self.asks or not self.looks_ahead):  # nobody looks at what functions return
            return NO_NUMBER
        nominal = self.control.divisor * self.control.largest
        if self.watch.hides_energy and 0.0 < step < nominal:  # otherwise they are resolved
            return (
                "Likely cause: axial vibrations, which the steps did not resolve, hid energy that smaller "
                f"ones set free: take stepSize = {step:.2g}, which resolves them from the start."
            )
        if self.watch.trouble == SPRINGS:
            return VIBRATING
        if self.watch.trouble == LACK_OF_WORK:
            return (
                "Likely cause: a force that jumps, as friction by sign(v) does: let it change over a range, "
                "as tanh(v / 1e-3) does, or set energyTolerance = 10, which bears the work of jumps."
            )
        return pulled_straight(self.straight_cables()) if self._rejects else ""

    def stop_at(self, jump: JumpError) -> None:
        """No step is small enough for this jump."""
        self.jump, self.gave_up = jump, True

    def try_again(self) -> None:
        """From another state: what has ended the run does not count."""
        self.jump, self.gave_up = None, False

    def straight_cables(self) -> list[str]:
        """Names of cables that something has pulled straight, see `held_straight`."""
        raise NotImplementedError

    @property
    def remedy(self) -> str:
        """What keeps the energy better."""
        step = self.watch.resolving_step
        if self.integrator.stabilised:
            return "take integrator='RATTLE', or a smaller stepSize"
        if 0.0 < step < self.control.present * self.control.divisor / self.control.waves:  # that of the start
            return f"take stepSize = {step:.2g}, which resolves axial vibrations"
        return "take a smaller stepSize"

    def set_step(self, h: float) -> None:
        """Prepare the equations for steps of h [s]."""
        raise NotImplementedError

    def resume(self, time: float) -> None:
        """Go on at `time` [s], with the memory that has been set."""
        raise NotImplementedError

    def start_scheme(self, time: float) -> None:
        """Let the integrator start from the present state, at `time` [s]."""
        raise NotImplementedError

    def forget(self) -> None:
        """Reset drift corrections and axial forces of earlier steps."""
        raise NotImplementedError

    def watch_on(self, time: float) -> None:
        """Let the watch go on with another step, at `time` [s]."""
        raise NotImplementedError

    def take(self, piece: Piece, history: Array) -> int:
        """Take these steps, as far as they go well; returns how many, after which the run is.

        JumpError instead if a support or joint jumps in them; the run is where it was.

        history: (intervals, 3, n) total coordinates, velocities, accelerations at the ends of intervals.
        """
        raise NotImplementedError

    def advance(self, grid: TimeGrid, first: int, history: Array) -> int:
        """Advance through len(history) intervals of the loop, from number `first`: the loop over all steps.

        history: see `take`.

        Returns:
            Number of intervals that went well; later rows of `history` mean nothing. Of several intervals
            with functions that are asked in each, none is tried again.
        """
        good, steps = 0, np.zeros(len(history))
        begins = self.watch.may_shorten and (self.may_begin_again or grid.begins_with(first))
        beginning = self.present_state() if begins else None
        while good < len(history) and not self.gave_up:
            most = len(history) - good
            most = most if most == 1 or self.looks_ahead or self.asks_ahead else 1
            piece = self.control.next(grid, first + good, most)
            if piece is None:
                self.gave_up = True
                break
            self.change_step(piece.h, piece.time())
            divisor = self.control.divisor
            piece, taken = self._take_until_jump(piece, history[good:])
            done = self.control.count(piece, taken, grid)
            steps[good : good + done] = piece.h
            good += done
            is_spoilt = self.control.divisor > divisor and self.watch.stretches
            if taken == piece.steps:
                self.control.accept()
                self._lengthen(first + good, piece.time(taken))
                is_spoilt |= self._shorten_for_gain()
            elif not self.gave_up and self.control.divisor == divisor:  # no shorter steps are asked for
                if piece.intervals > 1 and not (self.looks_ahead or self.may_begin_again):
                    break  # functions are asked in each interval, which are taken one by one now
                is_spoilt = self.reject(piece.time(taken), bool(beginning))
                if self.gave_up and beginning and self._resolve_stretch(grid.h):
                    self.gave_up, is_spoilt = False, True
            if is_spoilt and beginning:
                self._begin_again(beginning, grid.time(first))
                good = 0
        self.steps = steps[:good]
        return good

    def _take_until_jump(self, piece: Piece, history: Array) -> tuple[Piece, int]:
        """See `take`: of a piece, or of the part that no difference sees a jump from."""
        try:
            return piece, self.take(piece, history)
        except JumpError as jump:
            before = piece.until(jump.begin - SEEN_AHEAD)
            if before.steps:
                return before, self.take(before, history)
            self.stop_at(jump)
            return piece, 0

    def steps_before(self, states: int) -> Array:
        """(states,) last step before each of the last states of the run [s]."""
        known = self.steps[-states:]
        return known if len(known) == states else np.full(states, self.control.present)

    def steps_before_rows(self, rows: Places) -> Array:
        """(k,) last step before some of the last states [s].   rows: (k,) rising, -1 is the last one."""
        return self.steps_before(-int(rows[0]))[rows]

    def record(self, grid: TimeGrid, first: int, history: Array) -> int:
        """As `advance`, but displacements from the reference."""
        raise NotImplementedError

    def rehearse(self, grid: TimeGrid, first: int, most: int, begins: bool) -> None:
        """Shorten the steps as a run does that may begin again.

        Steps that were too long leave errors behind that shorter ones do not mend. So they are taken once
        without the functions that see them, and undone. Beside cables that stretch, from the beginning, or a
        restart file, as far as may be, and after a change for as long as nothing else had been changed
        before; elsewhere some at the beginning, and more if these show a motion that is fast for them.

        Args:
            grid: of the run.   first: interval of the loop that begins.   most: of them.
            begins: whether a run may begin there.
        """
        before, self.control.changed = self.control.changed, first
        intervals = most if begins else min(first - before, most)
        is_seen = self.looks_ahead or self.asks_ahead
        if intervals < LEAST_REHEARSED or not (is_seen and self.watch.may_shorten):
            return
        if self.watch.stretches and self.looks_ahead:
            self._rehearse(grid, first, intervals)
        if not begins or self.watch.stretches:
            return
        few, many = (min(intervals, -(-steps // grid.substeps)) for steps in STEPS_OF_MOTION)
        if self._rehearse(grid, first, few) > FAST and many > few:
            self._rehearse(grid, first, many)

    def _rehearse(self, grid: TimeGrid, first: int, intervals: int) -> float:
        """See `rehearse`; returns how fast the motion is for the nominal step [rad]."""
        beginning, self.may_begin_again, good = self.present_state(), True, 0
        with suppress(Exception):  # of a function of the user, which is asked again in the run
            good = self.record(grid, first, np.empty((intervals, 3, len(self.indices))))
        self.may_begin_again = False
        self.try_again()
        turned = self.watch.frequency * grid.h / self.control.divisor
        if good == intervals:
            self._begin_again(beginning, grid.time(first), is_spoilt=False)
        else:
            beginning.restore()
            self.resume(grid.time(first))
        return turned

    def rehearse_start(self, grid: TimeGrid, duration: float) -> None:
        """As `rehearse`, where nobody knows how many steps follow.   duration: they take at most [s]."""
        steps = min(STEPS_REHEARSED, int(duration / grid.h))
        self.rehearse(grid, 0, steps // grid.substeps, begins=True)

    def change_step(self, h: float, time: float) -> None:
        """Prepare for steps of h [s] from the present state, at `time` [s]."""
        before = self.control.present
        if abs(h - before) <= ROUND_OFF * h:
            return
        if h < SHORTER * before and self._frees_waves:
            self._leave_out_waves(time)
        self.set_step(h)
        if self.has_implicit_bending or not before:
            self.start_scheme(time)
        elif before:
            self.integrator.change_step(self.state, h / before)
        self.watch_on(time)

    @property
    def _frees_waves(self) -> bool:
        """Whether shorter steps go on from longer ones that may hide axial vibrations."""
        is_given = not self.watch.may_shorten  # others begin again
        return bool(self.watch.stretches and (is_given or self.control.follower is not None))

    def reject(self, time: float, begins: bool) -> bool:
        """After steps that went wrong, in the state before them, at `time` [s]: take smaller ones.

        Where the watch has looked too seldom, the same ones again.   begins: whether the run may begin again.

        Returns:
            Whether all that follow are smaller.
        """
        watch: RunWatch = self.watch
        if watch.look_closer():
            self.resume(time)
            return False
        is_shortened = watch.trouble == TOO_FAST or (watch.hides_energy and self._may_hide)
        if self.outran_limit(time):
            is_shortened = True
        elif is_shortened:
            self.control.shorten(watch.parts)
            if not self.control.may_shorten:
                watch.end_shortening()
        elif watch.trouble == ENERGY or not self.control.reject():
            is_shortened = watch.hides_energy and self.control.divisor < SMALLEST_PARTS
            if not is_shortened:
                self.gave_up = True
                return False
            self.control.shorten(2)
        self.resume(time)
        if not begins and watch.stretches and (watch.hides_energy or watch.trouble == LACK_OF_WORK):
            self._leave_out_waves(time)
        return is_shortened

    def outran_limit(self, time: float) -> bool:
        """Whether steps went wrong as forces bound them that nobody knew before; they are shorter then.

        time: of the state before them [s].
        """
        return False

    def _leave_out_waves(self, time: float) -> None:
        """Leave out axial vibrations that the steps did not resolve: shorter ones would free what they hide.

        Steps of h carry a vibration of the frequency w by strains 1 + (h w / 2)^2 times as large as those of
        its mean axial forces, see `cable.axial`. A start with such a step has the accelerations

            a(h) = (M + h^2/4 J^T D J)^-1 (F - J^T D c),  and  q += h^2 / (4 (1 - 1/r^2)) (a(h) - a(r h))

        leaves strains of those forces, within 1/r^2 of them, joints as they are, and motion that is resolved.
        """
        h, found = self.control.present, []
        for step in (h, LONGER * h):
            self.set_step(step)
            self.forget()
            self.start_scheme(time)
            found.append(self.state.a.copy())
        change = h**2 / (4.0 * (1.0 - 1.0 / LONGER**2)) * (found[0] - found[1])
        np.add(self.state.q, change, out=self.state.q)
        self.control.present = 0.0  # the next step begins anew

    @property
    def _may_hide(self) -> bool:
        """Whether the nominal step may become shorter for axial vibrations that it does not resolve."""
        return self.control.divisor < HIDING_PARTS * self.control.least

    def _shorten_for_gain(self) -> bool:
        """Whether the nominal step is shorter now, as energy grows by jumps too small to be rejected."""
        gain = self.watch.gain
        if not self.control.grows(gain) or not self._may_hide:
            return False
        self.control.shorten(2, gain)
        return True

    def is_stable(self, h: float, time: float) -> bool:
        """Whether steps of h [s] are, in the present state, at `time` [s]."""
        return True

    def _lengthen(self, interval: int, time: float) -> None:
        """Double the nominal step if it has been shortened for a motion that is slow again."""
        may = self.control.may_lengthen(interval) and self.watch.is_slow
        if may and self.is_stable(2.0 * self.control.present, time):
            self.control.lengthen()
            self.watch.expect_double_step()

    def _begin_again(self, beginning: KeptState, time: float, is_spoilt: bool = True) -> None:
        """With a shorter step, from the beginning.   time: of it [s].   is_spoilt: by a longer one."""
        control = self.control
        kept = control.divisor, control.longest, control.least, control.waves, control.beginnings + is_spoilt
        beginning.restore()
        control.begin_again(*kept)
        self.resume(time)

    def _resolve_stretch(self, h: float) -> bool:
        """Whether the nominal step is short enough now for axial vibrations.   h: of the grid [s]."""
        step = self.watch.resolving_step
        if not (self.watch.hides_energy and h > step * self.control.divisor > 0.0):
            return False
        return self.control.divide_by(math.ceil(h / step))
