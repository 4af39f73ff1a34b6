"""SolveExplicit: an explicit integrator inside Exudyn's own time loop."""

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import exudyn
import numpy as np

from ..chain.cable import Cable
from ..errors import InputError, SceneError
from ..integrators import find_integrator
from ..integrators.integrator import Integrator
from ..integrators.linear_stability import decay_limit, frequency_limit
from ..integrators.step_size import StepSizeBounds, choose_step, rule_step, step_above_limit
from .cable_run import CableRun, Start
from .native_run import NativeRun
from .observed import observed_derivatives
from .scene import initial_state, read_scene, require_assembled
from .settings import ExplicitSettings
from .time_grid import TimeGrid, time_grid
from .time_loop import ExplicitTimeLoop, Run


def SolveExplicit(
    mbs: Any, simulationSettings: Any = None, explicitSettings: ExplicitSettings | None = None
) -> dict[str, Any]:
    """Explicit dynamics of a scene of inextensible cables, in Exudyn's own time loop.

    Without any inextensible cable, native items of constant mass are moved instead, for comparisons.

    Sensors, solution files, pre- and post-step user functions and the SolutionViewer work as
    with mbs.SolveDynamic. Exudyn's steps are as long as the outputs allow: numberOfSteps of the
    time integration is a lower bound of their number, the write periods of sensors and solution
    file are upper bounds of their length; the integrator's own steps lie between them.

    Many of Exudyn's steps are computed in one compiled call where no user function sees the states in
    between. A user function of a load that depends on the time alone may say so by an attribute,
    function.dependsOnTimeOnly = True, in order not to stand in the way.

    Args:
        mbs: assembled system; its inextensible cables start from the initial configuration.
        simulationSettings: exudyn.SimulationSettings; used are startTime, endTime, numberOfSteps,
            verboseMode and all solution (output) settings.
        explicitSettings: integrator, step size, stabilisation.

    Returns:
        dict with 'success', 'integrator', 'stepSize' [s], 'steps', 'loopSteps', 'decidedBy' (what
        bounded the step), 'bounds' (StepSizeBounds), 'path' (which way the steps were computed) and
        'startCorrections' (of each cable: how far its initial state was from its constraints).

    Raises:
        SceneError: mbs not assembled, inconsistent, or contains what is not supported yet.
        StepSizeError: stepSize is above the stability limit.
        RedundantConstraintError: constraints that depend on each other.
        DivergenceError: the run left the finite numbers; mbs holds the last finite state.

    Example:
        report = SolveExplicit(mbs, simulationSettings, ExplicitSettings(stepSize=2.5e-3))
    """
    settings = simulationSettings or exudyn.SimulationSettings()
    explicit = explicitSettings or ExplicitSettings()
    require_assembled(mbs)
    solver = exudyn.MainSolverImplicitSecondOrder()
    runs = _runs(mbs, solver, settings, explicit)
    bounds = _bounds(runs, float(settings.timeIntegration.startTime), explicit)
    wanted, decided_by = _wanted_step(bounds, explicit)
    grid = time_grid(mbs, settings, wanted)
    loop = ExplicitTimeLoop(mbs, runs, _scheme(explicit), grid, observed_derivatives(mbs, settings))
    _run(mbs, solver, settings, loop)
    return {
        "success": True,
        "integrator": explicit.integrator,
        "stepSize": grid.h,
        "steps": round((mbs.systemData.GetTime() - grid.start) / grid.h),
        "loopSteps": grid.loop_steps,
        "decidedBy": decided_by if grid.substeps > 1 or grid.h > 0.99 * wanted else "output period",
        "bounds": bounds,
        "path": loop.path,
        "startCorrections": [run.start_correction for run in runs if isinstance(run, CableRun)],
    }


def _scheme(explicit: ExplicitSettings) -> Any:
    return explicit.scheme or find_integrator(explicit.integrator).scheme()


def _runs(mbs: Any, solver: Any, settings: Any, explicit: ExplicitSettings) -> Sequence[Run]:
    """One run for each inextensible cable; without any, one for all native items."""
    integrator = find_integrator(explicit.integrator)
    if mbs.systemData.ODE2Size() == 0:
        raise SceneError("mbs has nothing that moves: add a cable with CreateInextensibleCable.")
    cables = read_scene(mbs)
    if not cables:
        return [_native_run(mbs, solver, integrator, explicit)]
    h = 0.0
    if explicit.massScaling and explicit.stepSize is not None:
        h = time_grid(mbs, settings, explicit.stepSize).h
    start = Start(
        time=float(settings.timeIntegration.startTime),
        tolerance=explicit.startTolerance,
        zeta=explicit.stabilizationRate,
        mass_scaling=explicit.massScaling * h**2,
    )
    return [CableRun(cable, initial_state(mbs, cable), start, integrator) for cable in cables]


def _native_run(mbs: Any, solver: Any, integrator: Integrator, explicit: ExplicitSettings) -> NativeRun:
    if explicit.massScaling:
        raise InputError(
            f"massScaling = {explicit.massScaling!r}: only inextensible cables have it; set it to zero."
        )
    return NativeRun(mbs, solver, integrator)


def _bounds(runs: Sequence[Run], start: float, explicit: ExplicitSettings) -> StepSizeBounds:
    """The tightest bounds over all that moves."""
    integrator, scheme = find_integrator(explicit.integrator), _scheme(explicit)
    frequencies = [run.largest_frequency(start) for run in runs]
    limits = [
        frequency_limit(integrator, scheme, w * _damping_time(run)) / w if w > 0.0 else math.inf
        for run, w in zip(runs, frequencies, strict=True)
    ]
    fastest = int(np.argmin(limits))
    cables = [run.scene_cable.cable for run in runs if isinstance(run, CableRun)]
    return StepSizeBounds(
        bending=limits[fastest],
        stabilisation=decay_limit(integrator, scheme) / explicit.stabilizationRate if cables else math.inf,
        rule=min((_rule(cable, explicit.stepConstant) for cable in cables), default=math.inf),
        largest_frequency=frequencies[fastest],
        cable=runs[fastest].name,
    )


def _damping_time(run: Run) -> float:
    """D / EI [s] of a cable."""
    if not isinstance(run, CableRun):
        return 0.0
    section = run.scene_cable.cable.section
    return section.bending_damping / section.bending_stiffness


def _rule(cable: Cable, constant: float) -> float:
    section = cable.section
    shortest = float(cable.element_lengths.min())
    return rule_step(shortest, section.mass_per_length, section.bending_stiffness, constant)


def _wanted_step(bounds: StepSizeBounds, explicit: ExplicitSettings) -> tuple[float, str]:
    """The given step, unless it is above the stability limit, or the largest safe one."""
    if explicit.stepSize is None:
        return choose_step(bounds, explicit.stepSafety)
    error = step_above_limit(explicit.stepSize, bounds, explicit.integrator)
    if error is not None and not explicit.allowUnstableStep:
        raise error
    if error is not None:
        warnings.warn(str(error), stacklevel=3)
    return explicit.stepSize, "stepSize"


@contextmanager
def _settings_of_the_loop(settings: Any, grid: TimeGrid) -> Iterator[None]:
    """Exudyn's own integrator must do nothing: no accelerations, no step control, no dense matrix."""
    time = settings.timeIntegration
    saved = (
        time.numberOfSteps,
        time.adaptiveStep,
        time.generalizedAlpha.computeInitialAccelerations,
        settings.linearSolver.solverType,
    )
    time.numberOfSteps = grid.loop_steps
    time.adaptiveStep = False
    time.generalizedAlpha.computeInitialAccelerations = False
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    try:
        yield
    finally:
        time.numberOfSteps, time.adaptiveStep = saved[:2]
        time.generalizedAlpha.computeInitialAccelerations = saved[2]
        settings.linearSolver.solverType = saved[3]


def _run(mbs: Any, solver: Any, settings: Any, loop: ExplicitTimeLoop) -> None:
    solver.SetUserFunctionNewton(mbs, loop.user_function)
    mbs.sys["dynamicSolver"] = solver
    mbs.sys["simulationSettings"] = settings
    with _settings_of_the_loop(settings, loop.grid):
        try:
            success = solver.SolveSystem(mbs, settings)
        except Exception as error:
            raise loop.error or error from None
        finally:
            loop.complete_state()
    if not success:
        raise loop.error or SceneError("the run was stopped before its end time.")
