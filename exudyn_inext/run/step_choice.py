"""The step of a run: given, or as long as accuracy and stability allow.

A run that is given none takes implicit bending where that decides.
"""

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import chain, repeat
from typing import Any

import numpy as np

from ..cable.cable import Cable
from ..errors import SceneError, StepSizeError
from ..integrators.linear_stability import decay_limit, frequency_limit
from .accurate_step import (
    accurate_step,
    resolution_of_mesh,
    small_error,
    step_of_short_waves,
    step_of_shortest_element,
)
from .cable_run import CableRun
from .coupled_run import CoupledRun, Run
from .mover import together
from .rows_of_cables import Row, rows_of
from .settings import ExplicitSettings
from .step_control import StepRule
from .watch import NO_MESH

SAFETY_ALONE, SAFETY_AMONG_BODIES = 0.95, 0.7  # share of the limit at the start that is used
THETA = 0.3  # share of bending that is implicit: 1/4 leaves no margin for the tension
MOST_THETA = 0.55  # with which bending alone, h w < theta^(-1/2), keeps to the share used among bodies
STIFF = 0.5  # share of the step of short waves, up to which tension decides, and bending keeps its bound
OF_STATES = 0.2  # step times the frequency of first order states, as of oil under pressure
PHASE_OF_STATES = 0.02  # error of a swing of first order states by themselves [rad]: 1 % of its range
OF_RUBBING = 0.7  # step times the rate of contacts: a rope on a drum is then 1 % off, 7 % without damping
PHASE = 0.003  # error of the motion at the end of a run [rad]
MOST_DURATION, MOST_STEPS = 100.0, 3e4  # of a run, for that: time [s], or steps that resolve the motion
SLOWED = 1.5  # times that dashpots may shorten the step and be explicit
SLOWED_BY_SPRINGS = 2.0  # times that springs may, which are less exact when they are implicit
MUCH = 10.0  # times that damping may shorten the step without a word
MANY = 100.0  # times as many outputs as steps, or steps as the user asked for, without a word
LONG, LONG_COMPILED = 1e5, 5e6  # steps of a run without a word: each one evaluated by Exudyn, or compiled
LONG_NATIVE = 2e3  # if native cables bound them, which can be replaced
UNFORESEEN = 4.0  # times the step that resolves axial vibrations, where nobody knows what excites them
MOST_TRIALS, NEARLY = 6, 0.98  # of a step that the bounds for its own scaled mass allow


USUAL_SCALING = 0.3  # massScaling that is advised
_CLOSE = 0.95  # share of a bound below which another one decides clearly
FREE_FREE_ALPHA = 1.5 * math.pi  # alpha of Eq. (37)


@dataclass(frozen=True)
class StepSizeBounds:
    """Upper bounds of the step [s] and what they follow from.

    bending: h w_max at the scheme's limit, w_max the largest frequency of the discretised cable.
    stabilisation: h zeta at the scheme's limit.
    rule: Eq. (37) with the constant C.
    largest_frequency: w_max [rad/s].
    cable: name of the cable that decides the first bound.
    contact: as `bending`, if all contacts that are open at the start close at once.
    accuracy: step that resolves the motion as well as the mesh does, for the automatic step alone.
    safety: share of the stability limit that leaves a margin for what the motion changes [-].
    undamped: `bending` without damping, which lowers it.   damping: largest d [1/s] of v' = -d v.
    damped: what such strong damping is at; empty if it is weaker, or of the cable itself.
    touching: which contacts decide the bound `contact`, and why.   softer: which of their parameters do.
    is_cable: whether bending of a cable decides, so that fewer elements raise the bound.
    is_scaled: whether bending is implicit, so that the rule does not count.
    """

    bending: float
    stabilisation: float
    rule: float
    largest_frequency: float
    cable: str
    contact: float = math.inf
    accuracy: float = math.inf
    safety: float = 0.95
    undamped: float = math.inf
    damping: float = 0.0
    damped: str = ""
    touching: str = ""
    softer: str = ""
    is_cable: bool = True
    is_scaled: bool = False

    @property
    def stability_limit(self) -> float:
        """Largest step at which the linearised run does not grow, contacts open or closed [s]."""
        return min(self.bending, self.stabilisation, self.contact)


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
        member, damped = f" of member {number}", self.bounds.damped
        return replace(self.bounds, cable=self.bounds.cable + member, damped=damped and damped + member)

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
    damps_implicitly: bool | None = None,
    longest: float = math.inf,
) -> StepChoice:
    """The step of the runs of a scene.

    Args:
        runs: not yet started.   start: time [s].   duration: of the run [s].   explicit: settings.
        taken: step that will be taken, where the bounds depend on it (mass scaling) [s]; 0: the given one.
        scaled: see `step_above_limit`.   is_told: whether a given step that is too large is told of.
        damps_implicitly: whether springs and their dashpots are implicit; None: if the step asks for it.
        longest: step that outputs allow [s]: the mass is scaled for no longer one.

    Raises:
        StepSizeError: the given step is above the stability limit.
    """
    is_automatic = explicit.stepSize is None and not explicit.massScaling
    if is_automatic and any(run.has_states for run in runs if isinstance(run, CoupledRun)):
        explicit = replace(explicit, adaptiveStep=True)
    given = runs, start, duration, explicit, longest
    bounds, explicit = _bounds_and_scaling(*given)
    is_slowed = bool(damps_implicitly)
    if damps_implicitly is None:
        is_slowed, bounds, explicit = _slowed(bounds, explicit, taken, *given)
    if is_slowed and damp_implicitly(runs, bounds.bending, bounds.undamped):
        bounds, explicit = _bounds_and_scaling(*given)
    follow_frequencies(runs, bounds, explicit)
    if explicit.stepSize is None:
        return StepChoice(bounds, explicit, *largest_step(bounds, explicit.stepSafety))
    if is_told:
        require_stable(bounds, explicit, taken, scaled)
    return StepChoice(bounds, explicit, explicit.stepSize, "stepSize")


def _is_slowed(bounds: StepSizeBounds, explicit: ExplicitSettings, taken: float) -> bool:
    """Whether damping alone makes the step much shorter, or a given one too long; `taken`: see above."""
    if not bounds.undamped > SLOWED * bounds.bending:
        return False
    if explicit.stepSize is None or explicit.adaptiveStep:
        return largest_step(bounds, explicit.stepSafety)[1] == "bending"
    return (taken or explicit.stepSize) > bounds.bending


def _slowed(
    bounds: StepSizeBounds, explicit: ExplicitSettings, taken: float, runs: Sequence[Run], *given: Any
) -> tuple[bool, StepSizeBounds, ExplicitSettings]:
    """Whether springs or dashpots that can be implicit shorten the step much, or a given one is too long.

    bounds, explicit: of the step; returned with what is set for it.   runs, given: see `_bounds_and_scaling`.
    """
    if _is_slowed(bounds, explicit, taken):
        return True, bounds, explicit
    step, decided_by = largest_step(bounds, explicit.stepSafety)
    others, wanted = min(bounds.accuracy, bounds.contact), SLOWED_BY_SPRINGS * step
    may = decided_by == "bending" and others > wanted
    if is_given := explicit.stepSize is not None and not explicit.adaptiveStep:
        wanted = taken or explicit.stepSize or 0.0
        may = wanted > bounds.bending
    sprung = [run for run in runs if isinstance(run, CoupledRun) and run.mover.has_springs]
    if not (may and sprung):
        return False, bounds, explicit
    with together([run.springs_left_out() for run in sprung]):
        free, _ = _bounds_and_scaling(runs, *given)
    longest = free.stability_limit if is_given else largest_step(free, explicit.stepSafety)[0]
    if longest > wanted:
        return True, bounds, explicit
    return False, *_bounds_and_scaling(runs, *given)


def damp_implicitly(runs: Sequence[Run], limit: float, undamped: float) -> bool:
    """Let springs and their dashpots be implicit; whether any are now.

    limit, undamped: of the step while they are explicit, with and without dashpots [s].
    """
    return any([run.damp_implicitly(limit, undamped) for run in runs if isinstance(run, CoupledRun)])


def shorten_for_stretch(runs: Sequence[Run], choice: StepChoice) -> StepChoice:
    """For forces that nobody knows yet: such a run cannot begin again with a shorter step than its own."""
    resolving = [step for run in runs if (step := run.watch.resolving_step) > 0.0]
    shorter = UNFORESEEN * min(resolving, default=math.inf)
    is_given = choice.explicit.stepSize is not None or choice.h <= shorter
    return choice if is_given else replace(choice, h=shorter, decided_by="axial vibrations")


def require_stable(
    bounds: StepSizeBounds,
    explicit: ExplicitSettings,
    taken: float = 0.0,
    scaled: Callable[[], StepSizeBounds] | None = None,
) -> None:
    """Raise StepSizeError, or warn, if the given step is above the limit; arguments: see `choose_step`."""
    if explicit.adaptiveStep or explicit.stepSize is None:
        return
    error = step_above_limit(taken or explicit.stepSize, bounds, explicit.integratorName, scaled)
    if error is not None and not explicit.allowUnstableStep:
        raise error
    if error is not None:
        warnings.warn(str(error), stacklevel=4)


def _bounds_and_scaling(
    runs: Sequence[Run], start: float, duration: float, explicit: ExplicitSettings, longest: float
) -> tuple[StepSizeBounds, ExplicitSettings]:
    """Bounds of the step, and the settings with the mass scaling that it needs."""
    cables = [cable for run in runs for cable in run.cable_runs]
    if explicit.stepSize is not None or explicit.method[0].stabilised or not cables:
        if explicit.stepSize is None and not explicit.adaptiveStep:
            for run in runs:  # steps that gain energy may become shorter, whatever their phase
                run.watch.limit_phase(duration, math.inf, NO_MESH, 0.0)
        return step_bounds(runs, start, explicit), explicit
    rows = [rows_of([cable.scene_cable for cable in run.cable_runs]) for run in runs]
    accuracy = min(map(_accuracy, runs, rows, repeat(start)))
    usual = THETA
    if _are_among_bodies(runs):
        if accuracy > STIFF * min(map(step_of_shortest_element, chain(*rows))):
            usual = MOST_THETA
        lightest = min(run.lightest_body for run in runs if isinstance(run, CoupledRun))
        of_bending = min(map(step_of_short_waves, cables, chain(*rows), repeat(lightest)))
        lasts = _counted(duration, accuracy)
        of_others = (
            step for run in runs for step in (_step_of_states(run, start, lasts), _step_of_rubbing(run))
        )
        accuracy = min(accuracy, of_bending, *of_others)
    theta = _mass_scaling(cables, accuracy, explicit, usual)
    step, most = min(accuracy, longest), MOST_THETA if explicit.massScaling is None else theta
    bounds, theta = _scaled_bounds(runs, start, replace(explicit, massScaling=theta), accuracy, step, most)
    for run in runs:
        mesh = resolution_of_mesh(run, start, theta)
        run.watch.limit_phase(_counted(duration, accuracy), PHASE, mesh, small_error(run))
    return bounds, replace(explicit, massScaling=theta)


def _counted(duration: float, accuracy: float) -> float:
    """Time over which errors of the phase add up [s].   accuracy: step that resolves the motion [s]."""
    return min(duration, max(MOST_DURATION, MOST_STEPS * accuracy))


def _scaled_bounds(
    runs: Sequence[Run],
    start: float,
    explicit: ExplicitSettings,
    accuracy: float,
    step: float,
    most: float,
) -> tuple[StepSizeBounds, float]:
    """Bounds of the step, and theta of the mass that is scaled for the largest one that they allow.

    Where vibrations allow less than what resolves the motion, the mass that is scaled for that serves as
    well: theta grows, up to what keeps bending from being a bound.

    `undamped` is that of the largest step which its own mass allows without damping: damping makes steps
    shorter, and with them scaled masses lighter.

    accuracy: step that resolves the motion [s].   step: that, or the longest one between outputs, if that is
        shorter [s].   most: theta.
    """
    theta, undamped = explicit.massScaling or 0.0, 0.0
    for _ in range(MOST_TRIALS):
        _scale_mass(runs, theta, step)
        bounds = step_bounds(runs, start, explicit, accuracy)
        without, _ = largest_step(replace(bounds, bending=bounds.undamped), explicit.stepSafety)
        if without >= NEARLY * step:
            undamped = max(undamped, bounds.undamped)
        wanted, decided_by = largest_step(bounds, explicit.stepSafety)
        if not theta or wanted >= NEARLY * step:
            break
        if decided_by != "bending" or theta >= most:
            step = _for_its_own_mass(wanted, step, theta, bounds)
            continue
        theta, step = min(_rounded_up(theta * step / wanted * step / wanted), most), wanted
        if theta < most:  # the mass is the same, but for rounding
            _scale_mass(runs, theta, step)
            break
    return replace(bounds, undamped=max(undamped, bounds.undamped)), theta


def _accuracy(run: Run, rows: Sequence[Row], start: float) -> float:
    """Largest step that resolves the motion of the cables of a run, in their rows [s]."""
    among_bodies = isinstance(run, CoupledRun)
    acceleration = cache(partial(_largest_acceleration, run, start)) if among_bodies else None
    given, flight = (acceleration, cache(run.may_touch) if isinstance(run, CoupledRun) else None), run.flight
    cables = zip(run.cable_runs, rows, run.places_of_cables, strict=True)
    steps = (accurate_step(cable, row, start, flight[dofs], *given) for cable, row, (dofs, _) in cables)
    return min(steps, default=math.inf)


def _largest_acceleration(run: Run, start: float) -> float:
    """Of a node of a cable, at the start [m/s^2]."""
    run.start(start)
    nodes = (run.state.a[dofs].reshape(shape)[:, 0] for dofs, shape in run.places_of_cables)
    return max(float(np.linalg.norm(a, axis=1).max()) for a in nodes)


def _are_among_bodies(runs: Sequence[Run]) -> bool:
    return any(isinstance(run, CoupledRun) for run in runs)


def _step_of_states(run: Run, start: float, duration: float) -> float:
    """Largest step that resolves swings of first order states, with velocities and by themselves [s]."""
    if not (isinstance(run, CoupledRun) and run.has_states):
        return math.inf
    run.largest_frequency(start)
    swings = (_step_of_swing(w, decay, duration) for w, decay in run.swings_of_states.T)
    with_velocities = OF_STATES / run.frequency_of_states if run.frequency_of_states > 0.0 else math.inf
    return min(with_velocities, min(swings, default=math.inf))


def _step_of_swing(w: float, decay: float, duration: float) -> float:
    """Step whose error in a swing of states [rad/s, 1/s] is small, until it has decayed, or to the end [s].

    States leap with rates foreseen from the last step, whose error of the phase is 5/12 w T (h w)^2.
    """
    lasts = 1.0 / max(decay, 1.0 / duration)
    return min(OF_STATES, math.sqrt(12.0 / 5.0 * PHASE_OF_STATES / (w * lasts))) / w


def _step_of_rubbing(run: Run) -> float:
    """Largest step that resolves the pressure under which cables rub on circles [s]."""
    fastest = run.mover.fastest_rubbing_contact if isinstance(run, CoupledRun) else 0.0
    return OF_RUBBING / fastest if fastest > 0.0 else math.inf


def _scale_mass(runs: Sequence[Run], theta: float, step: float) -> None:
    for run in runs if theta else []:
        run.scale_mass(theta, step)


def _rounded_up(theta: float) -> float:
    """To hundredths: searches for frequencies differ in their last digits, and runs are to be the same."""
    return math.ceil(100.0 * min(theta, 1.0)) / 100.0


def _for_its_own_mass(wanted: float, step: float, theta: float, bounds: StepSizeBounds) -> float:
    """The step that is as large as its own scaled mass allows [s], as if all of w_max came from bending.

    With w^2 = w_0^2 / (1 + theta h^2 w_0^2) for the frequency w_0 of the mass as it is.

    Args:
        wanted: what the mass for `step` allows [s].   theta: of the mass scaling.   bounds: for `step`.
    """
    product = wanted * bounds.largest_frequency
    as_it_is = 1.0 / bounds.largest_frequency**2 - theta * step**2 if product > 0.0 else 0.0
    if as_it_is <= 0.0 or theta * product**2 >= 1.0:
        return wanted
    return min(wanted, product * math.sqrt(as_it_is / (1.0 - theta * product**2)))


def _mass_scaling(cables: Sequence[CableRun], step: float, explicit: ExplicitSettings, usual: float) -> float:
    """theta of the settings; None there: the usual one where bending would bound a step of that size [s]."""
    if explicit.massScaling is not None or explicit.adaptiveStep:
        return explicit.massScaling or 0.0
    decides = any(step > rule_of_cable(cable.scene_cable.cable, 1.0) for cable in cables)
    return usual if decides and math.isfinite(step) else 0.0


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
    decisive = runs[fastest]
    cables = [cable for run in runs for cable in run.cables]
    bounds = StepSizeBounds(
        bending=limits[fastest],
        stabilisation=decay_limit(integrator, scheme) / explicit.stabilizationRate if cables else math.inf,
        rule=min((rule_of_cable(cable, explicit.stepConstant) for cable in cables), default=math.inf),
        is_scaled=bool(explicit.massScaling),
        accuracy=accuracy,
        largest_frequency=frequencies[fastest],
        cable=decisive.name,
        contact=contact,
        safety=SAFETY_AMONG_BODIES if _are_among_bodies(runs) else SAFETY_ALONE,
        undamped=limit(frequencies[fastest]),
        damping=ratios[fastest] * frequencies[fastest],
        touching=touching,
        softer=softer,
        is_cable=isinstance(decisive, CableRun),
    )
    if isinstance(decisive, CoupledRun) and _is_lowered_by_damping(bounds):
        return replace(bounds, damped=decisive.most_damped)
    return bounds


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
        for cable in run.cable_runs:
            cable.require_independence()
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
    """Let each run choose its steps, if the settings ask for it; contacts count as closed."""
    if not explicit.adaptiveStep:
        return
    integrator, scheme = explicit.method
    safety = explicit.stepSafety or bounds.safety
    largest = min(
        explicit.stepSize or bounds.accuracy, safety * bounds.stabilisation, safety * bounds.contact
    )
    for run in runs:
        limit = frequency_limit(integrator, scheme, run.damping_ratio(bounds.largest_frequency))
        run.follow_frequency(StepRule(limit, safety, largest))


def warn_of_damping(choice: StepChoice, duration: float) -> None:
    """Before a run of that duration [s]: what explicit damping does to its step, if that is much."""
    bounds = choice.bounds
    bounds_step = choice.decided_by == "bending" and bounds.bending < duration
    if bounds_step and _is_lowered_by_damping(bounds):
        other = "" if choice.explicit.integratorName == "RATTLE" else ", or take integrator='RATTLE'"
        warnings.warn(
            f"damping of {bounds.damping:.3g} 1/s at {bounds.damped or bounds.cable} bounds the step to "
            f"{bounds.bending:.3g} s, where {bounds.undamped:.3g} s hold without it: dashpots that Exudyn "
            "evaluates, damping of finite elements, beams and native cables, friction in its proportional "
            "zone, drag, also by functions of loads, and under RK4 all dashpots and bending damping are "
            "explicit; let these damp less, or let a step function set what user functions of springs "
            f"change{other}.",
            stacklevel=3,
        )


def _is_lowered_by_damping(bounds: StepSizeBounds) -> bool:
    return bounds.undamped > MUCH * bounds.bending


def warn_of_outputs(choice: StepChoice, duration: float, outputs: int, asked: int) -> None:
    """Before a run of that duration [s]: if write periods make far more steps than the motion needs.

    outputs: steps of the loop.   asked: numberOfSteps.
    """
    if outputs > MANY * max(asked, duration / choice.h):
        warnings.warn(
            f"write periods make {outputs} steps of {duration / outputs:.3g} s, where {choice.h:.3g} s would "
            "do: lengthen solution.sensors.writePeriod and solution.file.writePeriod; 0 writes each step.",
            stacklevel=3,
        )


def warn_of_many_steps(runs: Sequence[Run], choice: StepChoice, duration: float, asked: int) -> None:
    """Before a run of that duration [s]: if something among bodies vibrates so fast that it takes very long.

    asked: numberOfSteps.
    """
    is_own_choice = choice.explicit.stepSize is None and choice.decided_by == "bending" and choice.h > 0.0
    if not is_own_choice or _is_lowered_by_damping(choice.bounds):  # see `warn_of_damping`
        return
    steps = duration / choice.h
    for run in runs:
        if isinstance(run, CoupledRun) and (reason := _reason_of_many_steps(run, steps, asked)):
            what, remedy = reason
            warnings.warn(
                f"{what} vibrates at {choice.bounds.largest_frequency:.3g} rad/s, so that the run takes "
                f"{steps:.2g} steps of {choice.h:.3g} s: {remedy}; or move the scene by mbs.SolveDynamic.",
                stacklevel=3,
            )


def _reason_of_many_steps(run: CoupledRun, steps: float, asked: int) -> tuple[str, str] | None:
    """What vibrates, and what helps, if the steps of a run are more than can be taken without a word."""
    long = max(MANY * asked, LONG_COMPILED if run.looks_ahead else LONG)
    if steps <= (long if run.is_compiled else LONG_NATIVE):
        return None
    node, native = run.fastest
    if native:
        return node, (
            f"let a cable whose axial stiffness bounds no step take the place of {native}, by "
            "ReplaceNativeCables(mbs) before mbs.Assemble()"
        )
    soften = "let what is so stiff there be softer, or a joint, or what is so light be heavier"
    return (node, soften) if steps > long else None


def rule_step(element_length: float, density: float, stiffness: float, constant: float) -> float:
    """h = C l^2 / alpha^2 sqrt(rho_A / EI), Eqs. (35)-(37) with the root as it must be.

    Args:
        element_length: l [m].   density: rho_A [kg/m].   stiffness: EI [N m^2].
        constant: C [-]; the paper uses 0.7 to 0.9.

    Returns:
        h [s].
    """
    return constant * element_length**2 / FREE_FREE_ALPHA**2 * math.sqrt(density / stiffness)


def largest_step(bounds: StepSizeBounds, safety: float | None = None) -> tuple[float, str]:
    """The largest step within the rule and, with a safety, all stability bounds; and what decided.

    Args:
        bounds: of the step.   safety: share of the stability bounds [-]; None: that of the bounds.
    """
    safety = safety or bounds.safety
    candidates = {
        "accuracy": bounds.accuracy,
        "contact": safety * bounds.contact,
        "rule (37)": math.inf if bounds.is_scaled else bounds.rule,
        "bending": safety * bounds.bending,
        "stabilisation": safety * bounds.stabilisation,
    }
    decided_by = min(candidates, key=lambda name: candidates[name])
    return candidates[decided_by], decided_by


def step_above_limit(
    h: float, bounds: StepSizeBounds, integrator: str, scaled: Callable[[], StepSizeBounds] | None = None
) -> StepSizeError | None:
    """The error that a step of size h deserves, or None.

    Args:
        h: step [s].   bounds: of it.   integrator: name of the scheme.
        scaled: bounds of the same step with massScaling = 0.3, which is advised if it helps; None: it is
            set, or there is nothing to scale.
    """
    limit = bounds.stability_limit
    if h <= limit * (1.0 + 1e-9):
        return None
    remedies = [f"reduce the step below {0.999 * limit:.4g} s"]  # below it however that is rounded
    if limit == bounds.stabilisation:
        cause = "the constraint stabilisation"
        remedies = ["reduce the step or the stabilizationRate"]
    elif limit < _CLOSE * bounds.bending:
        cause = f"what happens when contacts close: {bounds.touching}"
        remedies += [f"lower their {bounds.softer}"]
    else:
        cause, others = _vibration(bounds)
        remedies += others
    if scaled is not None and h <= scaled().stability_limit:
        remedies += [f"set massScaling = {USUAL_SCALING}"]
    return StepSizeError(
        f"stepSize = {h:.6g} s is above {limit:.6g} s, the stability limit of '{integrator}' for {cause}: "
        f"{', or '.join(remedies)}."
    )


def _vibration(bounds: StepSizeBounds) -> tuple[str, list[str]]:
    """Cause and remedies where vibrations decide, or their damping."""
    fewer = ["use fewer elements"] if bounds.is_cable else []
    cause = f"w_max = {bounds.largest_frequency:.6g} rad/s of {bounds.cable}"
    if not _CLOSE * bounds.undamped > bounds.bending:
        return cause, fewer
    lowered = f"{cause} and a damping of {bounds.damping:.4g} 1/s, which lowers it"
    if math.isfinite(bounds.undamped):
        lowered += f" from {bounds.undamped:.4g} s"
    return lowered, ["reduce the damping (of bending, springs, contact or drag)", *fewer]
