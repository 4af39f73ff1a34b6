"""The step of a run: given, or as long as accuracy and stability allow.

A run that is given none takes implicit bending where that decides. A transverse wave of the speed c, which
the tension gives it, takes 20 steps to pass an element: the error in time is then near that of the mesh. c^2
is the tension over rho_A that weight, loads and inertia can cause at most, and twice the energy by mass that
the motion starts with. The first vibration of the bent cable is resolved in any case. How fast the motion
really is, the watch finds out, see `watch`.
"""

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.assembly import elastic_energy
from ..cable.cable import Cable
from ..errors import InputError, SceneError
from ..integrators.linear_stability import decay_limit, frequency_limit
from .cable_run import CableRun
from .coupled_run import CoupledRun
from .run import Run
from .settings import ExplicitSettings
from .step_control import StepRule
from .step_size import StepSizeBounds, largest_step, rule_step, step_above_limit

SAFETY_ALONE, SAFETY_AMONG_BODIES = 0.95, 0.7  # share of the limit at the start that is used
STEPS_BY_ELEMENT = 20.0  # while a wave passes it
BY_DRAG = 0.02  # step times the rate at which drag slows a cable down
FIRST_VIBRATION = 0.085  # step over L^2 sqrt(rho_A / EI): 0.3 / 3.52, h w of a cantilever's first one
THETA = 0.3  # share of bending that is implicit: 1/4 leaves no margin for the tension
PHASE = 0.003  # error of the motion at the end of a run [rad]
MOST_DURATION = 100.0  # of a run, for that [s]
MUCH = 10.0  # times that damping may shorten the step without a word
MOST_TRIALS, NEARLY = 6, 0.98  # of a step that the bounds for its own scaled mass allow


@dataclass(frozen=True)
class StepChoice:
    """The step of a run.

    bounds: of it.   explicit: settings, with the mass scaling that it needs.
    h: largest step [s].   decided_by: what bounds it.
    """

    bounds: StepSizeBounds
    explicit: ExplicitSettings
    h: float
    decided_by: str

    @property
    def theta(self) -> float:
        """Of the mass scaling [-]."""
        return self.explicit.massScaling or 0.0

    def bounds_of_member(self, number: int) -> StepSizeBounds:
        """Of a member of an ensemble, which is named."""
        return replace(self.bounds, cable=f"{self.bounds.cable} of member {number}")

    def decider(self, steps: int, h: float, otherwise: str) -> str:
        """What decided on so many steps of h [s] in an interval: a bound, or what made the interval short."""
        return self.decided_by if steps > 1 or h > 0.99 * self.h else otherwise


def choose_step(
    runs: Sequence[Run],
    start: float,
    duration: float,
    explicit: ExplicitSettings,
    taken: float = 0.0,
    scaled: Callable[[], StepSizeBounds] | None = None,
    is_told: bool = True,
) -> StepChoice:
    """The step of the runs of a scene.

    Args:
        runs: not yet started.   start: time [s].   duration: of the run [s].   explicit: settings.
        taken: step that will be taken, where the bounds depend on it (mass scaling) [s]; 0: the given one.
        scaled: see `step_above_limit`.   is_told: whether a given step that is too large is told of.

    Raises:
        StepSizeError: the given step is above the stability limit.
    """
    bounds, explicit = _bounds_and_scaling(runs, start, duration, explicit)
    if explicit.stepSize is None:
        return StepChoice(bounds, explicit, *largest_step(bounds, explicit.stepSafety))
    if is_told:
        require_stable(bounds, explicit, taken, scaled)
    return StepChoice(bounds, explicit, explicit.stepSize, "stepSize")


def require_stable(
    bounds: StepSizeBounds,
    explicit: ExplicitSettings,
    taken: float = 0.0,
    scaled: Callable[[], StepSizeBounds] | None = None,
) -> None:
    """Raise StepSizeError, or warn, if the given step is above the limit; arguments: see `choose_step`."""
    if explicit.adaptiveStep or explicit.stepSize is None:
        return
    error = step_above_limit(taken or explicit.stepSize, bounds, explicit.integrator, scaled)
    if error is not None and not explicit.allowUnstableStep:
        raise error
    if error is not None:
        warnings.warn(str(error), stacklevel=4)


def _bounds_and_scaling(
    runs: Sequence[Run], start: float, duration: float, explicit: ExplicitSettings
) -> tuple[StepSizeBounds, ExplicitSettings]:
    """Bounds of the step, and the settings with the mass scaling that it needs."""
    cables = [cable for run in runs for cable in run.cable_runs]
    if explicit.stepSize is not None or explicit.method[0].stabilised or not cables:
        return step_bounds(runs, start, explicit), explicit
    for run in runs:
        run.watch.limit_phase(min(duration, MOST_DURATION), PHASE)
    step = accuracy = min(accurate_step(cable, start) for cable in cables)
    explicit = replace(explicit, massScaling=_mass_scaling(cables, accuracy, explicit))
    for _ in range(MOST_TRIALS):
        theta = explicit.massScaling or 0.0
        for run in runs if theta else []:
            run.scale_mass(theta, step)
        bounds = step_bounds(runs, start, explicit, accuracy)
        wanted, _ = largest_step(bounds, explicit.stepSafety)
        if not theta or wanted >= NEARLY * step:
            break
        step = wanted
    return bounds, explicit


def _mass_scaling(cables: Sequence[CableRun], step: float, explicit: ExplicitSettings) -> float:
    """theta of the settings; None there: where bending would bound a step of that size [s]."""
    if explicit.massScaling is not None or explicit.adaptiveStep:
        return explicit.massScaling or 0.0
    decides = any(step > rule_of_cable(cable.scene_cable.cable, 1.0) for cable in cables)
    return THETA if decides and math.isfinite(step) else 0.0


def accurate_step(run: CableRun, time: float) -> float:
    """Largest step that resolves the motion of a cable in time as well as its mesh does in space [s]."""
    cable = run.scene_cable.cable
    with np.errstate(over="ignore"):
        speed = _wave_speed(run, time)
    of_waves = float(cable.element_lengths.min()) / (STEPS_BY_ELEMENT * speed) if speed > 0.0 else math.inf
    section = cable.section
    bends = math.sqrt(section.mass_per_length / section.bending_stiffness) * cable.length**2
    of_drag = BY_DRAG / run.drag_rate if run.drag_rate > 0.0 else math.inf
    return min(of_waves, FIRST_VIBRATION * bends, of_drag)


def _wave_speed(run: CableRun, time: float) -> float:
    """c [m/s], see above."""
    cable = run.scene_cable.cable
    shape = cable.reference.shape
    inputs = run.loads.at(time)
    forces = np.linalg.norm(inputs[: run.state.q.size].reshape(shape)[:, 0], axis=1)
    density, v = cable.section.mass_per_length, run.state.v.reshape(shape)[:, 0]
    energy = max(0.0, float(elastic_energy(run.system.chain, run.state.q.reshape(shape))))
    squared = float(forces.sum()) / density + float((v * v).sum(axis=1).max())
    squared += 2.0 * energy / (density * cable.length) + _of_motions(inputs[run.state.q.size :], cable)
    return math.sqrt(squared)


def _of_motions(inputs: Array, cable: Any) -> float:
    """Speeds squared of supports that move, and what their accelerations may do to the tension [m^2/s^2]."""
    motions = inputs.reshape(-1, 3, cable.dimension)
    speeds, accelerations = np.linalg.norm(motions[:, 1:], axis=2).T
    return float((speeds**2 + accelerations * cable.length).sum())


def step_bounds(
    runs: Sequence[Run], start: float, explicit: ExplicitSettings, accuracy: float = math.inf
) -> StepSizeBounds:
    """The tightest bounds over all that moves.   accuracy: of a step that resolves the motion [s]."""
    integrator, scheme = explicit.method
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
    integrator, scheme = explicit.method
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


def warn_of_damping(choice: StepChoice, duration: float) -> None:
    """Before a run of that duration [s]: what explicit damping does to its step, if that is much."""
    bounds = choice.bounds
    bounds_step = choice.decided_by == "bending" and bounds.bending < duration
    if bounds_step and bounds.undamped > MUCH * bounds.bending:
        warnings.warn(
            f"damping of {bounds.damping:.3g} 1/s at {bounds.cable} bounds the step to {bounds.bending:.3g} "
            f"s, where {bounds.undamped:.3g} s hold without it: dashpots of springs and joints, drag, and "
            "under RK4 bending damping are explicit; use softer dashpots, or for bending damping "
            "integrator='RATTLE'.",
            stacklevel=3,
        )
