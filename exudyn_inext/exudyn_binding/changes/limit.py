"""The step of a run after a change."""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import StepSizeError
from ...items.parameters import Parameter
from ...run.cable_run import CableRun
from ...run.coupled_run import CoupledRun
from ...run.run import Run
from ...run.settings import ExplicitSettings
from ...run.step_choice import StepSizeBounds, follow_frequencies, step_above_limit, step_bounds

GROWTH = 1.1  # of a stiffness or damping since the limit was looked at, that calls for another look
NOTICEABLE = 0.98  # share of the limit before the change: above it, the motion is to blame


class StepLimit:
    """Watches the stability limit of runs whose scene changes.

    h: step of the integrator [s].   last: limit when it was looked at last [s].
    stored: what a restart file says; with its `memory`, the limit is looked at as without an interruption.
    """

    def __init__(self, h: float, last: float, explicit: ExplicitSettings, stored: Mapping[str, Any]) -> None:
        self._h = h
        self._last = last
        self._explicit = explicit
        self._seen = {Parameter(*names): size for *names, size in stored.get("seen", [])}

    def memory(self) -> dict[str, Any]:
        """Size of each stiffness that has changed, when the limit was looked at, as plain data."""
        return {"seen": [[*key, size] for key, size in self._seen.items()]}

    def stiffer(self, mbs: Any, changed: Sequence[Parameter]) -> list[Parameter]:
        """Those parameters of connectors that are now much larger than when the limit was looked at."""
        grown = []
        for key in filter(_is_of_stiffness, changed):
            size = float(np.abs(key.value(mbs)).max())
            if size > GROWTH * self._seen.get(key, 0.0):
                grown.append(key)
                self._seen[key] = size
        return grown

    def look_again(self, runs: Sequence[Run], time: float, changed: Sequence[Parameter]) -> None:
        """The same runs, with another stiffness around them. They must begin again.

        Raises:
            StepSizeError: the change has brought the limit below the step.
        """
        for run in runs:
            if isinstance(run, CoupledRun):
                run.forget_rates(time)
        self._require_stable(step_bounds(runs, time, self._explicit), self._last, time, changed)

    def take_over(
        self, before: Sequence[Run], runs: Sequence[Run], time: float, changed: Sequence[Parameter]
    ) -> None:
        """Other runs, which have not begun yet.

        Raises:
            StepSizeError: the change has brought the limit below the step.
            SceneError: steps that adapt, among other items.
        """
        bounds = step_bounds(runs, time, self._explicit)
        follow_frequencies(runs, bounds, self._explicit)
        _pass_on_steps(before, runs)
        for run in runs:
            run.set_step(run.control.present or self._h)
        if self._explicit.adaptiveStep:
            return
        last = self._last
        if self._h > bounds.stability_limit and all(isinstance(run, CableRun) for run in before):
            last = step_bounds(before, time, self._explicit).stability_limit
        self._require_stable(bounds, last, time, changed)

    def _require_stable(
        self, bounds: StepSizeBounds, last: float, time: float, changed: Sequence[Parameter]
    ) -> None:
        self._last = bounds.stability_limit
        error = step_above_limit(self._h, bounds, self._explicit.integrator)
        if error is None or bounds.stability_limit > NOTICEABLE * last:
            return
        cause = ", ".join(map(str, changed))
        said = StepSizeError(f"after the change of {cause} at t = {time:.6g} s: {error}")
        if not self._explicit.allowUnstableStep:
            raise said
        warnings.warn(str(said), stacklevel=2)


def _is_of_stiffness(key: Parameter) -> bool:
    """Whether the stability limit may follow a parameter: a number of a connector."""
    name = key.name.lower()
    is_named_so = name == "activeconnector" or "stiffness" in name or "damping" in name
    return key.kind == "Object" and is_named_so


def _pass_on_steps(before: Sequence[Run], runs: Sequence[Run]) -> None:
    """What has been learned of them so far."""
    for old, new in zip(before, runs, strict=False):
        new.control.memory()["log"][...] = old.control.memory()["log"]
        new.watch.limit_phase(old.watch.watch.duration, old.watch.watch.phase)
