"""Which steps a cable takes: the nominal one, and smaller ones where it goes wrong.

Steps that go wrong are rejected: the run goes on from the state before them with a quarter of the step, and
with that again, until they go well; then they grow again. The nominal step is that of the time grid; it is
shortened where the motion turns out to be too fast for it, and doubled when it is slow again, or follows the
present stability limit of the cable.
"""

import ctypes
import math
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from .time_grid import TimeGrid, steps_within

ROUND_OFF = 1e-12  # of a time, relative
QUARTERS = 6  # at most: below 1/4096 of the nominal step a run has diverged
FEW = 8  # steps, whose times Python finds faster than NumPy
PIECE = 8  # nominal steps that are taken at once while steps are smaller, half as many for each quarter
MOST_PARTS = 4096  # of the nominal step
MOST_BEGINNINGS = 2  # of a run whose nominal step may become longer again
BETWEEN = 8  # intervals of the loop after which it may
MOST_PATIENCE = 64  # pieces before a longer step is tried again
STEPS_BETWEEN = 32  # two looks at the frequency
GAINED = 3.0  # times its tolerance may the energy grow before the nominal step becomes shorter
HARDLY = 0.02  # change of the frequency, relative, after which the next look at it may come later
SMALLEST = 1e-3  # nominal step, relative to the first one, below which a run has diverged


class _Log(ctypes.Structure):
    """Numbers of a `StepControl`, in memory that can be kept; attributes are faster than those of records."""

    _fields_ = tuple(
        (name, kind)
        for kind, names in (
            (ctypes.c_double, "frequency first present smallest offset gain tension allowed longest"),
            (ctypes.c_int64, "divisor asked least waves beginnings quarters calm patience rejections steps"),
            (ctypes.c_int64, "changed due pause"),
        )
        for name in names.split()
    )


_RECORD = np.dtype(_Log)  # found once: NumPy looks at each of the fields


class StepRule(NamedTuple):
    """How long a step may be.

    limit: h w [-] up to which the scheme is stable.   safety: share of it that is used [-].
    largest: upper bound of the step [s].
    """

    limit: float
    safety: float
    largest: float


class Piece(NamedTuple):
    """Equal steps that are taken at once.

    origin: time from which they are counted [s].   before: steps since then.   h: [s].   steps: how many.
    in_interval: how many make up an interval of the loop, or this part of one.   is_whole: which of both.
    """

    origin: float
    before: int
    h: float
    steps: int
    in_interval: int
    is_whole: bool

    @property
    def intervals(self) -> int:
        """That are written; a part of one counts as one."""
        return self.steps // self.in_interval

    def time(self, taken: int = 0) -> float:
        """After so many steps [s]."""
        return self.origin + (self.before + taken) * self.h

    def until(self, time: float) -> "Piece":
        """The intervals that end before that time [s], which is less than that of the last step."""
        steps = int(max((time - self.time()) / self.h, 0.0))
        return self._replace(steps=steps - steps % self.in_interval)

    def times(self, stages: Sequence[float]) -> Array:
        """(steps, stages) at which a scheme with these stages needs loads [s]."""
        if self.steps <= FEW:
            few = range(self.before, self.before + self.steps)
            return np.array([[self.origin + self.h * (step + stage) for stage in stages] for step in few])
        steps = np.arange(self.before, self.before + self.steps, dtype=float)
        return self.origin + self.h * np.add.outer(steps, stages)


class FrequencyFollower:
    """Nominal steps that follow the largest frequency of a cable at present.

    A cable that straightens, is wound up or is pulled tight vibrates faster: the frequency is followed,
    and its last growth counted once more.

    frequency: t [s] -> w_max [rad/s] at present.   steps: between two looks at it, in intervals of so many.
    least, most: in shorter ones; twice as many each time that it has hardly changed.
    """

    def __init__(
        self,
        rule: StepRule,
        frequency: Callable[[float], float],
        steps: int = STEPS_BETWEEN,
        least: int = 1,
        most: int = 1,
    ) -> None:
        self._rule = np.array(rule)
        self._frequency = frequency
        self.steps, self._least, self._most = steps, least, most

    def memory(self) -> dict[str, Any]:
        """The rule, of the state in which it was made."""
        return {"rule": self._rule}

    def look_soon(self, log: Any) -> None:
        """As soon after the last look as if the frequency had changed."""
        log.due -= max(0, log.pause - self._least)
        log.pause = min(log.pause, self._least)

    def nominal_step(self, log: Any, time: float, remaining: float) -> float:
        """Largest step that is allowed now [s]; 0 if only a run that has diverged asks for so small a one.

        log: of a `StepControl`, whose divisor counts here, too.   time: at present [s].
        remaining: of the interval [s].
        """
        limit, safety, largest = self._rule.tolist()
        if log.steps >= log.due:
            frequency = self._frequency(time)
            if not math.isfinite(frequency):
                return 0.0
            growth = max(0.0, frequency - log.frequency) if log.frequency else 0.0
            is_calm = abs(frequency - log.frequency) <= HARDLY * frequency
            log.pause = max(self._least, min(2 * log.pause, self._most) if is_calm else 0)
            log.frequency, log.due = frequency, log.steps + log.pause
            log.allowed = safety * limit / max(frequency + growth, 1e-300)
        longest = log.longest or min(log.allowed, largest)
        step = min(log.allowed, longest / log.divisor, remaining)
        log.first = log.first or step
        return step if step > SMALLEST * min(log.first, remaining) else 0.0


def _logged(name: str) -> Any:
    """A number of the log as a property."""

    def put(control: Any, value: Any) -> None:
        setattr(control._log, name, value)

    return property(attrgetter(f"_log.{name}"), put)


class StepControl:
    """What the next steps of a run will be, and what the last ones were.

    follower: sets the nominal step, or None: that of the grid.   rejects: whether there are smaller ones.

    smallest: of the steps so far [s].   steps: how many.   rejections: how often they went wrong.
    present: step that the system is prepared for [s].   offset: of the present state in its interval [s].
    divisor: what the nominal step is divided by, `least` and `waves` at least; the motion `asked` for as much
        or less.
    beginnings: how often the run has begun again.
    changed: interval of the loop before which functions have changed something last.
    tension: largest one for which the stability limit is known, over rho_A l^2 [1/s^2].
    longest: step that is divided, where steps follow a frequency and the motion has asked for shorter ones
        [s]; 0: it has not.
    """

    smallest: float = _logged("smallest")
    present: float = _logged("present")
    offset: float = _logged("offset")
    steps: int = _logged("steps")
    rejections: int = _logged("rejections")
    divisor: int = _logged("divisor")
    least: int = _logged("least")
    waves: int = _logged("waves")
    beginnings: int = _logged("beginnings")
    changed: int = _logged("changed")
    tension: float = _logged("tension")
    longest: float = _logged("longest")

    def __init__(self, follower: FrequencyFollower | None = None, rejects: bool = True) -> None:
        self.follower = follower
        self._rejects = rejects
        self._log: Any = _Log(smallest=math.inf, divisor=1, asked=1, least=1, waves=1, patience=1)
        self._memory = np.frombuffer(self._log, _RECORD)

    @property
    def said(self) -> str:
        """What is said of a run whose steps cannot be made small enough."""
        tried = f"{self.rejections} times steps were taken again"
        return f"{tried}, and those of {self.present:.3g} s, the smallest ones, went wrong, too"

    @property
    def is_nominal(self) -> bool:
        """Whether whole intervals of equal steps may be taken."""
        return self.follower is None and self._log.quarters == 0 and self._log.offset == 0.0

    @property
    def is_shorter_for_a_while(self) -> bool:
        """Whether steps are parts of the nominal one, after others that went wrong."""
        return bool(self._log.quarters)

    @property
    def is_smallest(self) -> bool:
        """Whether steps that go wrong are as small as they may become."""
        return bool(self._log.quarters >= QUARTERS)

    @property
    def may_quarter(self) -> bool:
        """Whether steps that go wrong are taken again in smaller ones, for a while."""
        return self._rejects and bool(self._log.quarters < QUARTERS)

    @property
    def largest(self) -> float:
        """The present step, or that of which it is a part after others that went wrong [s]."""
        return self.nominal(self.present)

    def nominal(self, h: float) -> float:
        """The nominal step, of which steps of h [s] are parts after others that went wrong."""
        return float(h * 4**self._log.quarters)

    def memory(self) -> dict[str, Any]:
        """What the next steps depend on, to be kept or set."""
        return {"log": self._memory} | (self.follower.memory() if self.follower else {})

    def next(self, grid: TimeGrid, interval: int, most: int) -> Piece | None:
        """The next steps; None if they would have to be so small that the run must have diverged.

        Args:
            grid: of the run.   interval: of the loop, in which the present state is.
            most: intervals that a piece may span.
        """
        if self.is_nominal:
            if self.divisor > 1:
                most = min(most, BETWEEN - interval % BETWEEN)
            return self.whole_intervals(grid, interval, most)
        nominal = grid.h / self.divisor
        remaining = grid.substeps * grid.h - self.offset
        together = PIECE
        if self.follower is not None:
            time = grid.time(interval) + self.offset
            nominal, together = self.follower.nominal_step(self._log, time, remaining), self.follower.steps
        if nominal == 0.0:
            return None
        quarters = self._log.quarters
        duration = remaining / steps_within(remaining, PIECE * nominal / 2**quarters)
        steps = steps_within(duration, nominal / 4**quarters)
        if not quarters:
            number = steps_within(remaining, nominal)
            steps = min(number, together)
            duration = remaining * (steps / number)
        return Piece(grid.time(interval) + self.offset, 0, duration / steps, steps, steps, is_whole=False)

    def whole_intervals(self, grid: TimeGrid, interval: int, number: int) -> Piece:
        """All nominal steps of so many intervals of the loop, from that one on."""
        parts = self.divisor
        before, substeps = grid.steps_until(interval) * parts, grid.substeps * parts
        return Piece(grid.start, before, grid.h / parts, number * substeps, substeps, is_whole=True)

    def count(self, piece: Piece, taken: int, grid: TimeGrid) -> int:
        """So many steps of a piece went well; returns how many intervals of the loop they have completed."""
        log = self._log
        if taken:
            log.steps += taken
            log.smallest = min(log.smallest, piece.h)
        if piece.is_whole:
            done, left = divmod(taken, piece.in_interval)
            log.offset = left * piece.h
            return done
        log.offset += taken * piece.h
        is_done = log.offset >= (1.0 - ROUND_OFF) * grid.substeps * grid.h
        if is_done:
            log.offset = 0.0
        return int(is_done)

    def look_soon(self) -> None:
        """Something was changed: look at the frequency, if it is followed, as if it had changed."""
        if self.follower is not None:
            self.follower.look_soon(self._log)

    def accept(self) -> None:
        """A piece went well; longer steps are tried again after some patience."""
        log = self._log
        log.calm = calm = log.calm + 1
        if not log.quarters:
            if calm > MOST_PATIENCE:
                log.patience = 1
        elif calm >= log.patience:
            log.quarters -= 1
            log.calm = 0

    def reject(self) -> bool:
        """The last steps went wrong; returns whether smaller ones may be tried."""
        log = self._log
        log.rejections += 1
        log.due = 0
        if log.calm < 2:  # the longer step that was tried was too long: wait twice as long
            log.patience = min(2 * log.patience, MOST_PATIENCE)
        log.calm = 0
        if not self.may_quarter:
            return False
        log.quarters += 1
        return True

    def grows(self, gain: float) -> bool:
        """Whether a gain of energy, times its tolerance, is much more than `shorten` was told last."""
        return gain > self._log.gain + GAINED

    def shorten(self, parts: int, gain: float = 0.0) -> None:
        """The nominal step is too long for the motion; `may_shorten`.   gain: see `grows`."""
        self._log.longest = self.nominal(self.present) * self.divisor
        self._log.divisor = self._log.asked = min(self.divisor * parts, MOST_PARTS)
        self._log.gain = max(self._log.gain, gain)

    def divide_by(self, least: int) -> bool:
        """Divide the nominal step by so much at least, from now on; returns whether it may be so short.

        If that is less than before, so is the divisor, as far as the motion has not asked for it.
        """
        self._log.divisor = max(self._log.asked, least, self._log.waves)
        self._log.least = least
        return least <= MOST_PARTS

    def divide_for_waves(self, parts: int, tension: float) -> None:
        """Divide the nominal step by so much at least, for waves of this tension; see `tension`."""
        self._log.waves, self._log.tension = max(parts, self._log.waves), tension
        self._log.divisor = max(self._log.divisor, self._log.waves)

    def divide_again(self, parts: int, tension: float) -> None:
        """Divide the nominal step by so much only, as contacts have opened; see `divide_for_waves`."""
        self._log.waves, self._log.tension = parts, tension
        self._log.divisor = max(self._log.asked, self._log.least, parts)

    def begin_again(self, divisor: int, longest: float, least: int, waves: int, beginnings: int) -> None:
        """With the nominal step divided so, or as `least` and `waves` ask; `beginnings`: how many now."""
        self._log.longest = longest
        self._log.asked, self._log.waves, self._log.beginnings = divisor, waves, beginnings
        self.divide_by(least)

    def may_lengthen(self, interval: int) -> bool:
        """Whether the nominal step may become longer again, before that interval of the loop.

        Between pieces that do not depend on who asks for them; not in a run that began again twice: longer
        steps are what spoilt it.
        """
        may = self.divisor > max(self.least, self._log.waves) and self.is_nominal and interval % BETWEEN == 0
        return may and self.beginnings < MOST_BEGINNINGS

    def lengthen(self) -> None:
        """The nominal step is much shorter than the motion needs: double it."""
        self._log.divisor = self._log.asked = max((self.divisor + 1) // 2, self.least, self._log.waves)

    @property
    def may_shorten(self) -> bool:
        """Whether the nominal step may become still shorter."""
        return self.divisor < MOST_PARTS
