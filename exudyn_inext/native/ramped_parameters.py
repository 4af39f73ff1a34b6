"""Parameters that change along a line within a step of the loop, where Exudyn evaluates them."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..arrays import Array
from ..items.parameters import Parameter
from ..run.ramp import NO_STEP, Line, Ramp


class RampedParameters:
    """Those of an mbs that are on their way to what step functions have set.

    What is not made of real numbers jumps, as switches, numbers of markers and functions do.
    """

    def __init__(self, mbs: Any) -> None:
        self._mbs, self._ramp = mbs, Ramp()
        self._share = 0.0  # of the changes that mbs lacks
        self._lines: list[tuple[Parameter, Array, Array]] = []  # with values before, and at the end

    def begin(self, changed: Iterable[tuple[str, int, str]], line: Line | None) -> None:
        """These parameters, which have been set in mbs, change along that line; None: they jump."""
        self._lines, self._share = [], 0.0
        if line is not None:
            self._ramp.begin(*line.step)
            for key in (Parameter(*item) for item in changed):
                self._add(key, line.before.get(key))

    def _add(self, key: Parameter, before: Any) -> None:
        old, new = _numbers(before), _numbers(key.value(self._mbs))
        if old is not None and new is not None and old.shape == new.shape:
            self._lines.append((key, old, new))

    def follow(self, t: float) -> None:
        """Let mbs have what they are at t [s]."""
        if self._lines:
            self._set(self._ramp.share(t))

    def finish(self) -> None:
        """Let mbs have what has been set."""
        self._set(0.0)

    def _set(self, share: float) -> None:
        if share == self._share:
            return
        self._share = share
        for key, before, value in self._lines:
            key.set(self._mbs, (share * before + (1.0 - share) * value).tolist())

    @property
    def kept(self) -> dict[str, list[Any]]:
        """See `CableRun.ramp`."""
        before = [[*key, old.tolist()] for key, old, _ in self._lines]
        return {"step": self._ramp.step, "before": before} if before else {}

    def take(self, kept: Mapping[str, Any]) -> None:
        """See `CableRun.take_ramp`."""
        before = {Parameter(*names): value for *names, value in kept.get("before", ())}
        start, end = kept.get("step", NO_STEP)
        self.begin(before, Line(start, end, before))


def _numbers(value: Any) -> Array | None:
    """A real number, or an array of them."""
    numbers = np.asarray(value) if isinstance(value, (float, list, np.ndarray)) else None
    return numbers if numbers is not None and numbers.dtype == np.float64 else None
