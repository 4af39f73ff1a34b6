"""A run whose steps may go wrong: they are taken again, smaller, from the state before them."""

import math
from functools import cached_property
from typing import Any

from ..arrays import Array
from ..integrators.integrator import Integrator
from .consistent_start import ROUND_OFF
from .kept_state import KeptState
from .run_watch import RunWatch
from .step_control import StepControl
from .time_grid import TimeGrid


class PacedRun:
    """What a cable and a coupled scene have in common; see `step_control`.

    integrator: of the run.   state: of the integrator.   control: of the steps.
    watch: `RunWatch`, which finds steps that went wrong.   gave_up: whether there are no smaller ones.
    trouble: what the integrator said of the last steps that went wrong.
    """

    integrator: Integrator
    state: Any
    control: StepControl
    watch: Any
    gave_up = False
    trouble = ""

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

    def take(self, scheme: Any, start: float, h: float, steps: int, history: Array) -> bool:
        """Equal steps of h [s] from the time `start` [s]; returns whether they went well.

        history: (1, 3, n) memory of their end.
        """
        raise NotImplementedError

    @cached_property
    def kept(self) -> KeptState:
        """The state before the steps that are being taken."""
        return KeptState(self.memory())

    def finish_interval(self, scheme: Any, grid: TimeGrid, number: int, history: Array) -> bool:
        """The rest of interval `number` of the loop, in pieces of steps that may change.

        history: (1, 3, n) output.   Returns whether the end was reached.
        """
        control, start, interval = self.control, grid.time(number), grid.substeps * grid.h
        while control.offset < (1.0 - ROUND_OFF) * interval:
            time = start + control.offset
            duration, steps = control.piece(grid)
            if not steps:
                self.gave_up = True
                return False
            self.change_step(duration / steps, time)
            self.kept.keep()
            if self.take(scheme, time, duration / steps, steps, history):
                control.accept(duration / steps, steps)
                control.offset += duration
            else:
                self._return(scheme, time)
            if self.gave_up:
                return False
        control.offset = 0.0
        return True

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

    def _return(self, scheme: Any, time: float) -> None:
        """To the state before steps that went wrong, at `time` [s]."""
        self.trouble = self.integrator.trouble(scheme, self.watch.watch.kept)
        with self.watch.finding_kept():
            self.kept.restore()
        self.reject(time)

    def reject(self, time: float) -> None:
        """After steps that went wrong, in the state before them, at `time` [s]: take smaller ones."""
        watch: RunWatch = self.watch
        if times := watch.steps_to_halve:
            self.control.halve(times)
            if not self.control.may_halve:
                watch.limit_phase(1.0, math.inf)
        elif watch.gains_too_much or not self.control.reject():
            self.gave_up = True
            return
        self.resume(time)
