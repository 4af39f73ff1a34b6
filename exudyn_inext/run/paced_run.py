"""A run whose steps may go wrong: they are taken again, smaller, from the last good state."""

import math
from typing import Any

import numpy as np

from ..arrays import Array
from ..integrators.integrator import Integrator
from .kept_state import Elsewhere, KeptState
from .run_watch import RunWatch
from .step_control import ROUND_OFF, Piece, StepControl
from .time_grid import TimeGrid
from .watch import ENERGY, TOO_FAST

HIDING_PARTS = 16  # of the nominal step, from which on steps that go wrong are smaller for a while only
SMALLEST_PARTS = 256  # and up to which all are, where no smaller ones for a while go well


class PacedRun:
    """What a cable and a coupled scene have in common; see `step_control`.

    integrator, scheme: of the run.   state: of the integrator.   control: of the steps.
    watch: `RunWatch`, which finds steps that went wrong.   gave_up: whether there are no smaller ones.
    trouble: what the integrator said of the last steps that went wrong.
    looks_ahead: whether several steps of the time loop can be computed at once.
    elsewhere: what of the state lies in no array of the run.
    remembered: (k, D) by contacts after the intervals of the last `record`; None: mbs knows, or there are
        none.
    data: (2, D) what contacts in compiled code remember, now and from the start of the step.
    finding: what the user is to be told at the end, besides the energy.
    """

    integrator: Integrator
    scheme: Any
    state: Any
    control: StepControl
    watch: Any
    looks_ahead = False
    gave_up = False
    trouble = ""
    finding = ""
    elsewhere: Elsewhere | None = None
    remembered: Array | None = None
    data: Array = np.zeros((2, 0))

    @property
    def has_implicit_bending(self) -> bool:
        """Whether the equations depend on the step."""
        raise NotImplementedError

    def memory(self) -> dict[str, Any]:
        """Arrays that the next steps depend on, by names: to be kept, or set before `resume`."""
        raise NotImplementedError

    def set_step(self, h: float) -> None:
        """Prepare the equations for steps of h [s]."""
        raise NotImplementedError

    def resume(self, time: float) -> None:
        """Go on at `time` [s], with the memory that has been set."""
        raise NotImplementedError

    def start_scheme(self, time: float) -> None:
        """Let the integrator start from the present state, at `time` [s]."""
        raise NotImplementedError

    def watch_on(self, time: float) -> None:
        """Let the watch go on with another step, at `time` [s]."""
        raise NotImplementedError

    def take(self, piece: Piece, history: Array) -> int:
        """Take these steps, as far as they go well; returns how many, after which the run is.

        history: (intervals, 3, n) total coordinates, velocities, accelerations at the ends of intervals.
        """
        raise NotImplementedError

    def advance(self, grid: TimeGrid, first: int, history: Array) -> int:
        """Advance through len(history) intervals of the loop, from number `first`: the loop over all steps.

        history: see `take`.

        Returns:
            Number of intervals that went well; later rows of `history` mean nothing.
        """
        good = 0
        begins = self.watch.looks_at_phase and grid.begins_with(first)
        beginning = KeptState(self.memory(), self.elsewhere) if begins else None
        while good < len(history) and not self.gave_up:
            piece = self.control.next(grid, first + good, len(history) - good if self.looks_ahead else 1)
            if piece is None:
                self.gave_up = True
                break
            self.change_step(piece.h, piece.time())
            taken = self.take(piece, history[good:])
            good += self.control.count(piece, taken, grid)
            if taken == piece.steps:
                self.control.accept()
                self._lengthen(first + good)
                is_spoilt = self._shorten_for_gain()
            else:
                is_spoilt = self.reject(piece.time(taken)) and self.watch.is_spoilt
            if is_spoilt and beginning:
                self._begin_again(beginning, grid.time(first))
                good = 0
        return good

    def change_step(self, h: float, time: float) -> None:
        """Prepare for steps of h [s] from the present state, at `time` [s]."""
        before = self.control.present
        if abs(h - before) <= ROUND_OFF * h:
            return
        self.set_step(h)
        if self.has_implicit_bending:
            self.start_scheme(time)
        elif before:
            self.integrator.change_step(self.state, h / before)
        self.watch_on(time)

    def reject(self, time: float) -> bool:
        """After steps that went wrong, in the state before them, at `time` [s]: take smaller ones.

        Returns:
            Whether all that follow are smaller.
        """
        watch: RunWatch = self.watch
        is_shortened = watch.trouble == TOO_FAST or (
            watch.hides_energy and self.control.divisor < HIDING_PARTS
        )
        if is_shortened:
            self.control.shorten(watch.parts)
            if not self.control.may_shorten:
                watch.limit_phase(1.0, math.inf, watch.watch.mesh)
        elif watch.trouble == ENERGY or not self.control.reject():
            is_shortened = watch.hides_energy and self.control.divisor < SMALLEST_PARTS
            if not is_shortened:
                self.gave_up = True
                return False
            self.control.shorten(2)
        self.resume(time)
        return is_shortened

    def _shorten_for_gain(self) -> bool:
        """Whether the nominal step is shorter now, as energy grows by jumps too small to be rejected."""
        gain = self.watch.gain
        if not self.control.grows(gain) or self.control.divisor >= HIDING_PARTS:
            return False
        self.control.shorten(2, gain)
        return True

    def _lengthen(self, interval: int) -> None:
        """Double the nominal step if it has been shortened for a motion that is slow again."""
        if self.control.may_lengthen(interval) and self.watch.is_slow:
            self.control.lengthen()
            self.watch.expect_double_step()

    def _begin_again(self, beginning: KeptState, time: float) -> None:
        """With a shorter step, from the beginning, which a longer one has spoilt.   time: of it [s]."""
        divisor, beginnings = self.control.divisor, self.control.beginnings
        beginning.restore()
        self.control.begin_again(divisor, beginnings)
        self.resume(time)
