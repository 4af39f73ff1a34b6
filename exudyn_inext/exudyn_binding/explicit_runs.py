"""What an explicit run moves, and with which step: shared by the time loop and the stepper."""

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..chain.cable import Cable
from ..errors import InputError, SceneError
from ..integrators import find_integrator
from ..integrators.linear_stability import decay_limit, frequency_limit
from ..integrators.step_size import StepSizeBounds, choose_step, rule_step, step_above_limit
from .cable_run import CableRun, Start
from .scene import CableInScene, initial_state
from .settings import ExplicitSettings
from .step_control import StepRule
from .time_loop import Run


def scheme_of(explicit: ExplicitSettings) -> Any:
    """Parameters of the scheme: those given, or its defaults."""
    return explicit.scheme or find_integrator(explicit.integrator).scheme()


def cable_runs(
    mbs: Any, cables: Sequence[CableInScene], time: float, h: float, explicit: ExplicitSettings
) -> list[CableRun]:
    """One run for each inextensible cable.

    Args:
        mbs: the system.   cables: of it.   time: of the start [s].   explicit: settings.
        h: step that scales the mass [s]; 0 without mass scaling.
    """
    start = Start(
        time=time,
        tolerance=explicit.startTolerance,
        zeta=explicit.stabilizationRate,
        mass_scaling=explicit.massScaling * h**2,
    )
    integrator = find_integrator(explicit.integrator)
    return [CableRun(cable, initial_state(mbs, cable), start, integrator) for cable in cables]


def step_bounds(runs: Sequence[Run], start: float, explicit: ExplicitSettings) -> StepSizeBounds:
    """The tightest bounds over all that moves."""
    integrator, scheme = find_integrator(explicit.integrator), scheme_of(explicit)
    frequencies = [run.largest_frequency(start) for run in runs]
    limits = [
        frequency_limit(integrator, scheme, run.damping_ratio(w)) / w if w > 0.0 else math.inf
        for run, w in zip(runs, frequencies, strict=True)
    ]
    fastest = int(np.argmin(limits))
    cables = [cable for run in runs for cable in run.cables]
    return StepSizeBounds(
        bending=limits[fastest],
        stabilisation=decay_limit(integrator, scheme) / explicit.stabilizationRate if cables else math.inf,
        rule=min((_rule(cable, explicit.stepConstant) for cable in cables), default=math.inf),
        largest_frequency=frequencies[fastest],
        cable=runs[fastest].name,
    )


def _rule(cable: Cable, constant: float) -> float:
    section = cable.section
    shortest = float(cable.element_lengths.min())
    return rule_step(shortest, section.mass_per_length, section.bending_stiffness, constant)


def follow_frequencies(runs: Sequence[Run], bounds: StepSizeBounds, explicit: ExplicitSettings) -> None:
    """Let each cable choose its steps, if the settings ask for it.

    Raises:
        SceneError: something else than cables moves, too.
    """
    if not explicit.adaptiveStep:
        return
    others = [run.name for run in runs if not isinstance(run, CableRun)]
    if others:
        raise SceneError(
            f"adaptiveStep deals with cables alone, not with {', '.join(others)}: choose a fixed stepSize, "
            "with a margin for what is pulled tight."
        )
    integrator, scheme = find_integrator(explicit.integrator), scheme_of(explicit)
    largest = min(explicit.stepSize or math.inf, explicit.stepSafety * bounds.stabilisation)
    for run in runs:
        if isinstance(run, CableRun):
            limit = frequency_limit(integrator, scheme, run.damping_ratio(bounds.largest_frequency))
            run.follow_frequency(StepRule(limit, explicit.stepSafety, largest))


def require_fixed_steps(explicit: ExplicitSettings, who: str) -> None:
    """Raise InputError if the steps are to adapt."""
    if explicit.adaptiveStep:
        raise InputError(f"adaptiveStep: {who} takes equal steps; use SolveExplicit, or leave it out.")


def wanted_step(bounds: StepSizeBounds, explicit: ExplicitSettings) -> tuple[float, str]:
    """The given step, unless it is above the stability limit, or the largest safe one."""
    if explicit.stepSize is None:
        return choose_step(bounds, explicit.stepSafety)
    if explicit.adaptiveStep:
        return explicit.stepSize, "stepSize"
    error = step_above_limit(explicit.stepSize, bounds, explicit.integrator)
    if error is not None and not explicit.allowUnstableStep:
        raise error
    if error is not None:
        warnings.warn(str(error), stacklevel=3)
    return explicit.stepSize, "stepSize"
