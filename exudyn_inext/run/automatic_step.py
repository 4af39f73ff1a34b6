"""The step of a run that is given none: as long as accuracy allows, with implicit bending where that decides.

A transverse wave of the speed c, which the tension gives it, takes 20 steps to pass an element: the error in
time is then near that of the mesh. c^2 is the tension over rho_A that weight, loads and inertia can cause at
most, and twice the energy by mass that the motion starts with. The first vibration of the bent cable is
resolved in any case. How fast the motion really is, the watch finds out, see `run.watch`.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.assembly import elastic_energy
from ..integrators import find_integrator
from ..integrators.step_size import StepSizeBounds, choose_step
from .cable_run import CableRun
from .run import Run
from .settings import ExplicitSettings
from .step_bounds import rule_of_cable, step_bounds

STEPS_BY_ELEMENT = 20.0  # while a wave passes it
BY_DRAG = 0.02  # step times the rate at which drag slows a cable down
FIRST_VIBRATION = 0.085  # step over L^2 sqrt(rho_A / EI): 0.3 / 3.52, h w of a cantilever's first one
THETA = 0.3  # share of bending that is implicit: 1/4 leaves no margin for the tension
PHASE = 0.003  # error of the motion at the end of a run [rad]
MOST_DURATION = 100.0  # of a run, for that [s]
MUCH = 10.0  # times that damping may shorten the step without a word
MOST_TRIALS, NEARLY = 6, 0.98  # of a step that the bounds for its own scaled mass allow


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


def bounds_of_step(
    runs: Sequence[Run], start: float, duration: float, explicit: ExplicitSettings
) -> tuple[StepSizeBounds, ExplicitSettings]:
    """Bounds of the step, and the settings with the mass scaling that it needs.

    Args:
        runs: of a scene.   start: time [s].   duration: of the run [s].   explicit: settings.
    """
    cables = [cable for run in runs for cable in run.cable_runs]
    if explicit.stepSize is not None or find_integrator(explicit.integrator).stabilised or not cables:
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
        wanted, _ = choose_step(bounds, explicit.stepSafety)
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


def warn_of_damping(bounds: StepSizeBounds, decided_by: str, duration: float) -> None:
    """Before a run of that duration [s]: what explicit damping does to its step, if that is much."""
    bounds_step = decided_by == "bending" and bounds.bending < duration
    if bounds_step and bounds.undamped > MUCH * bounds.bending:
        warnings.warn(
            f"damping of {bounds.damping:.3g} 1/s at {bounds.cable} bounds the step to {bounds.bending:.3g} "
            f"s, where {bounds.undamped:.3g} s hold without it: dashpots of springs and joints, drag, and "
            "under RK4 bending damping are explicit; use softer dashpots, or for bending damping "
            "integrator='RATTLE'.",
            stacklevel=3,
        )
