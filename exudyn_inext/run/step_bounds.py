"""What an explicit run moves, and with which step: shared by the time loop and the stepper."""

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

from ..arrays import Array
from ..cable.cable import Cable
from ..errors import InputError, SceneError
from ..integrators import find_integrator
from ..integrators.linear_stability import decay_limit, frequency_limit
from ..integrators.step_size import StepSizeBounds, choose_step, rule_step, step_above_limit
from ..scene.model import CableInScene
from .cable_run import CableRun, Start
from .coupled_run import CoupledRun
from .run import Run
from .settings import ExplicitSettings
from .step_control import StepRule

State = tuple[Array, Array]
SAFETY_ALONE, SAFETY_AMONG_BODIES = 0.95, 0.7  # share of the limit at the start that is used


def scheme_of(explicit: ExplicitSettings) -> Any:
    """Parameters of the scheme: those given, or its defaults."""
    integrator = find_integrator(explicit.integrator)
    return integrator.checked(explicit.scheme or integrator.scheme())


def cable_runs(
    cables: Sequence[CableInScene], states: Sequence[State], time: float, h: float, explicit: ExplicitSettings
) -> list[CableRun]:
    """One run for each inextensible cable.

    Args:
        cables: of a scene.   states: q and v (n, 2, dim) of each at the start.   time: of the start [s].
        h: step that scales the mass [s]; 0 without mass scaling.   explicit: settings.
    """
    start = start_of(time, h, explicit)
    integrator, scheme = find_integrator(explicit.integrator), scheme_of(explicit)
    return [
        CableRun(cable, state, start, integrator, scheme) for cable, state in zip(cables, states, strict=True)
    ]


def start_of(time: float, h: float, explicit: ExplicitSettings) -> Start:
    """How runs start; arguments: see `cable_runs`."""
    return Start(
        time=time,
        tolerance=explicit.startTolerance,
        zeta=explicit.stabilizationRate,
        theta=explicit.massScaling or 0.0,
        h=h,
        energy_tolerance=explicit.energyTolerance,
        rejects=explicit.rejectSteps,
    )


def step_bounds(
    runs: Sequence[Run], start: float, explicit: ExplicitSettings, accuracy: float = math.inf
) -> StepSizeBounds:
    """The tightest bounds over all that moves.   accuracy: see `automatic_step` [s]."""
    integrator, scheme = find_integrator(explicit.integrator), scheme_of(explicit)
    frequencies = [_finite_frequency(run, start) for run in runs]
    ratios = [run.damping_ratio(w) for run, w in zip(runs, frequencies, strict=True)]

    def limit(frequency: float, damping_ratio: float = 0.0) -> float:
        return frequency_limit(integrator, scheme, damping_ratio) / frequency if frequency > 0.0 else math.inf

    limits = [limit(w, ratio) for w, ratio in zip(frequencies, ratios, strict=True)]
    contact, touching, softer = _contact_bound(runs, limit)
    fastest = limits.index(min(limits))
    cables = [cable for run in runs for cable in run.cables]
    return StepSizeBounds(
        bending=limits[fastest],
        stabilisation=decay_limit(integrator, scheme) / explicit.stabilizationRate if cables else math.inf,
        rule=min((rule_of_cable(cable, explicit.stepConstant) for cable in cables), default=math.inf),
        is_scaled=bool(explicit.massScaling),
        accuracy=accuracy,
        largest_frequency=frequencies[fastest],
        cable=runs[fastest].name,
        contact=contact,
        safety=SAFETY_AMONG_BODIES if any(isinstance(run, CoupledRun) for run in runs) else SAFETY_ALONE,
        undamped=limit(frequencies[fastest]),
        damping=ratios[fastest] * frequencies[fastest],
        touching=touching,
        softer=softer,
        is_cable=isinstance(runs[fastest], CableRun),
    )


def _contact_bound(runs: Sequence[Run], limit: Callable[[float, float], float]) -> tuple[float, str, str]:
    """The step [s] up to which open contacts may close; which ones, and which parameters decide.

    limit: of the step [s] from frequency [rad/s] and damping ratio [-].
    """
    found = (math.inf, "", "")
    for run in runs:
        if not isinstance(run, CoupledRun) or run.contacts is None:
            continue
        frequency, damping = run.rates_in_contact
        frequency = max(frequency, 1e-3 * damping)  # so that the ratio stays finite
        allowed = limit(frequency, damping / frequency if frequency else 0.0)
        if allowed < found[0]:
            rates = f"then vibrate at {frequency:.4g} rad/s, damped by {damping:.4g} 1/s"
            is_stiff = limit(frequency, 0.0) < 1.5 * allowed
            found = (
                allowed,
                f"{run.contacts.name} {rates}",
                " and ".join(run.contacts.stiffnesses if is_stiff else run.contacts.dampings),
            )
    return found


def _finite_frequency(run: Run, start: float) -> float:
    """Largest frequency [rad/s] at the start; SceneError if it is no number."""
    frequency = run.largest_frequency(start)
    if not (math.isfinite(frequency) and math.isfinite(run.damping_ratio(frequency))):
        if isinstance(run, CableRun):
            run.require_independence()
        raise SceneError(
            f"the largest frequency of {run.name} at the start, {frequency:g} rad/s, or its damping is no "
            "finite number: check the units of sections, lengths, velocities, masses and loads, and what "
            "user functions return. Without it, no step is known to be stable."
        )
    return frequency


def rule_of_cable(cable: Cable, constant: float) -> float:
    """Step after Eq. (37) for the shortest element of a cable [s]."""
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
    safety = explicit.stepSafety or bounds.safety
    largest = min(explicit.stepSize or bounds.accuracy, safety * bounds.stabilisation)
    for run in runs:
        if isinstance(run, CableRun):
            limit = frequency_limit(integrator, scheme, run.damping_ratio(bounds.largest_frequency))
            run.follow_frequency(StepRule(limit, safety, largest))


def require_fixed_steps(explicit: ExplicitSettings, who: str) -> None:
    """Raise InputError if the steps are to adapt."""
    if explicit.adaptiveStep:
        raise InputError(f"adaptiveStep: {who} takes equal steps; use SolveExplicit, or leave it out.")


def wanted_step(
    bounds: StepSizeBounds,
    explicit: ExplicitSettings,
    taken: float | None = None,
    scaled: Callable[[], StepSizeBounds] | None = None,
) -> tuple[float, str]:
    """The given step, unless it is above the stability limit, or the largest safe one.

    Args:
        bounds: of the step.   explicit: settings.
        taken: step that will be taken, where the bounds depend on it (mass scaling); None: the given one.
        scaled: see `step_above_limit`.
    """
    if explicit.stepSize is None:
        return choose_step(bounds, explicit.stepSafety)
    if explicit.adaptiveStep:
        return explicit.stepSize, "stepSize"
    error = step_above_limit(taken or explicit.stepSize, bounds, explicit.integrator, scaled)
    if error is not None and not explicit.allowUnstableStep:
        raise error
    if error is not None:
        warnings.warn(str(error), stacklevel=3)
    return explicit.stepSize, "stepSize"


def warn_of_friction(runs: Sequence[Run]) -> None:
    """Once a run, where much of the work of friction contradicts Coulomb's law."""
    for run in runs:
        if isinstance(run, CoupledRun) and run.friction.finding:
            warnings.warn(run.friction.finding, stacklevel=3)
