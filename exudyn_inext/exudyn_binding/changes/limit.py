"""The step of a run after a change."""

import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import exudyn
import numpy as np

from ...errors import StepSizeError
from ...items.parameters import Parameter
from ...run.cable_run import CableRun
from ...run.coupled_run import CoupledRun, Run
from ...run.settings import ExplicitSettings
from ...run.step_choice import (
    StepSizeBounds,
    damp_implicitly,
    follow_frequencies,
    step_above_limit,
    step_bounds,
)

GROWTH = 1.1  # of a stiffness or damping since the limit was looked at, that calls for another look
FALL = 0.5  # of a stiffness or damping since then, that calls for one after a while
WAIT = 16.0  # steps of the loop, in which what has fallen does not grow again
NOTICEABLE = 0.98  # share of the limit before the change: above it, the motion is to blame


@dataclass(eq=False)
class StepLimit:
    """Watches the stability limit of runs whose scene changes.

    h: step of the integrator [s].   last: limit when it was looked at last [s].   explicit: settings.
    """

    h: float
    last: float
    explicit: ExplicitSettings

    def __post_init__(self) -> None:
        self._seen: dict[Parameter, float] = {}  # size of each stiffness, when the limit was looked at
        self._fallen: dict[Parameter, float] = {}  # size of those that are much smaller now
        self._due = math.inf  # when they let the step grow again [s]

    def memory(self) -> dict[str, Any]:
        """At which stiffnesses the limit has been looked at, and when it will be, as plain data."""
        sizes = {"seen": self._seen, "fallen": self._fallen}
        listed = {name: [[*key, size] for key, size in of.items()] for name, of in sizes.items()}
        return listed | {"due": self._due if self._fallen else None}

    def restore(self, memory: Mapping[str, Any]) -> None:
        """Let the limit be looked at when it would have been without an interruption."""
        self._seen, self._fallen = (
            {Parameter(*names): size for *names, size in memory[name]} for name in ("seen", "fallen")
        )
        self._due = memory["due"] if self._fallen else math.inf

    def is_due(self, time: float) -> bool:
        """Whether the limit is to be looked at, as stiffnesses are smaller for a while, at `time` [s]."""
        return time >= self._due

    def notice(self, changed: Mapping[Parameter, Any], time: float, end: float) -> None:
        """Which stiffnesses are much smaller from `time` to `end` [s], the next step of the loop.

        changed: parameters, with their values.
        """
        if self.explicit.adaptiveStep or self.explicit.stepSize is not None:
            return
        for key in self._seen.keys() & changed:
            size = _size(key, changed[key])
            if size < FALL * self._seen[key]:
                self._fallen[key] = size
                self._due = time + (WAIT - 0.5) * (end - time)
            elif self._fallen.pop(key, None) is not None and not self._fallen:
                self._due = math.inf

    def grown(self, changed: Mapping[Parameter, Any]) -> dict[Parameter, float]:
        """Stiffnesses that are much larger than when the limit was looked at, and how large they are."""
        sizes = {key: _size(key, changed[key]) for key in filter(_bounds_the_step, changed)}
        return {key: size for key, size in sizes.items() if size > GROWTH * self._seen.get(key, 0.0)}

    def follow_stiffness(self, runs: Sequence[Run], changed: Mapping[Parameter, Any], time: float) -> bool:
        """Whether the runs must begin again, as something around them has become much stiffer, or softer.

        Raises:
            StepSizeError: the change has brought the limit below the step.
        """
        grown = self.grown(changed)
        is_due = self.is_due(time)
        if is_due:
            self._seen |= self._fallen
            self._fallen, self._due = {}, math.inf
        self._seen |= grown
        if grown or is_due:
            for run in runs:
                if isinstance(run, CoupledRun):
                    run.forget_rates(time)
            self._require_stable(runs, step_bounds(runs, time, self.explicit), self.last, time, list(grown))
        return bool(grown) or is_due

    def take_over(
        self,
        before: Sequence[Run],
        runs: Sequence[Run],
        time: float,
        changed: Mapping[Parameter, Any],
    ) -> None:
        """Other runs, which have not begun yet.

        Raises:
            StepSizeError: the change has brought the limit below the step.
        """
        self._seen |= self.grown(changed)
        for run in before:
            if isinstance(run, CoupledRun) and run.damps_implicitly:
                damp_implicitly(runs, *run.explicit_limits)
        bounds = step_bounds(runs, time, self.explicit)
        follow_frequencies(runs, bounds, self.explicit)
        _pass_on_steps(before, runs)
        for run in runs:
            run.set_step(run.control.present or self.h)
        last = self.last
        if self.h > bounds.stability_limit and all(isinstance(run, CableRun) for run in before):
            last = step_bounds(before, time, self.explicit).stability_limit
        self._require_stable(runs, bounds, last, time, changed)

    def _require_stable(
        self,
        runs: Sequence[Run],
        bounds: StepSizeBounds,
        last: float,
        time: float,
        changed: Collection[Parameter],
    ) -> None:
        self.last = bounds.stability_limit
        if self.explicit.adaptiveStep or (self.explicit.stepSize is None and self._follow(runs, bounds)):
            return
        error = step_above_limit(self.h, bounds, self.explicit.integratorName)
        if error is None or bounds.stability_limit > NOTICEABLE * last:
            return
        cause = ", ".join(map(str, changed))
        said = StepSizeError(f"after the change of {cause} at t = {time:.6g} s: {error}")
        if not self.explicit.allowUnstableStep:
            raise said
        warnings.warn(str(said), stacklevel=2)

    def _follow(self, runs: Sequence[Run], bounds: StepSizeBounds) -> bool:
        """Divide an automatic step as far as the limit asks for; returns whether it may be so short."""
        safety = self.explicit.stepSafety or bounds.safety
        parts = math.ceil(min(self.h / (safety * bounds.stability_limit), 1e9))
        return all([run.control.divide_by(max(parts, 1)) for run in runs])


def _size(key: Parameter, value: Any) -> float:
    """Largest value of a stiffness, damping or lever; of masses, the inverse of the smallest one."""
    if key.is_mass and not key.is_centre:
        sizes = [abs(x) for x in np.ravel(value).tolist() if x]
        return 1.0 / min(sizes, default=np.inf)
    if isinstance(value, exudyn.MatrixContainer):
        value = value.Convert2DenseMatrix()
    return abs(value) if isinstance(value, float) else float(np.abs(value).max(initial=0.0))


@cache
def _bounds_the_step(key: Parameter) -> bool:
    """Whether the stability limit may follow a parameter: a number of a connector, or a mass."""
    name = key.name.lower()
    is_named_so = name == "activeconnector" or "stiffness" in name or "damping" in name
    return key.kind == "Object" and (is_named_so or key.is_mass)


def _pass_on_steps(before: Sequence[Run], runs: Sequence[Run]) -> None:
    """What has been learned of them so far."""
    for old, new in zip(before, runs, strict=False):
        new.control.memory()["log"][...] = old.control.memory()["log"]
        new.watch.limit_phase_as(old.watch)
