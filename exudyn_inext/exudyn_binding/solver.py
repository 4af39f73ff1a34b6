"""SolveExplicit: an explicit integrator inside Exudyn's own time loop."""

import math
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from typing import Any

import exudyn

from ..errors import DivergenceError, SceneError
from .arguments import explicit_settings, simulation_settings
from .cable_forces import forget_evaluators
from .cable_run import CableRun
from .empty_sensors import warn_of_empty_sensors
from .explicit_runs import follow_frequencies, scheme_of, step_bounds, wanted_step
from .general.surroundings import state_kept, switched_off
from .observed import observed_derivatives
from .output_files import require_writable_outputs
from .restart import Restarts
from .scene import read_scene, require_assembled
from .scene_runs import bounds_if_scaled, needs_coupling, runs_of_scene
from .settings import ExplicitSettings
from .time_grid import TimeGrid, time_grid
from .time_loop import ExplicitTimeLoop, worst_figures


def SolveExplicit(
    mbs: Any, simulationSettings: Any = None, explicitSettings: ExplicitSettings | None = None
) -> dict[str, Any]:
    """Explicit dynamics of a scene with inextensible cables, in Exudyn's own time loop.

    Cables alone are moved by compiled code. Bodies, connectors, native joints, contact, first order
    states and loads on any of them are evaluated by Exudyn, at each right-hand side; joints are enforced
    in position, velocity and acceleration, as the cables' own constraints are. Constraints on velocities,
    and rotation vectors as coordinates, are refused. Without any inextensible cable, native items are
    moved, for comparisons. The report says which path was taken, and why.

    The stability limit is that of the initial state, as if contacts of cables with circles that are open
    were closed. Tension that grows during the motion lowers it, and general contacts that close: leave a
    margin (stepSafety), or let the steps adapt (adaptiveStep).

    Sensors, solution files, pre- and post-step user functions and the SolutionViewer work as
    with mbs.SolveDynamic. Exudyn's steps are as long as the outputs allow: numberOfSteps of the
    time integration is a lower bound of their number, the write periods of sensors and solution
    file are upper bounds of their length; the integrator's own steps lie between them.

    A run stops when its constraints or its energy go astray, see ExplicitSettings.energyTolerance.

    Restart files follow simulationSettings.solution.restart: with `write`, one is written every writePeriod
    and at the end; with `continueIfAvailable`, a run goes on from it, bit for bit as if it had never been
    interrupted, if the scene and the settings are the same (endTime may be later). Sensor and solution
    files are then appended to; what a killed run wrote after its last restart file stands there twice.

    Many of Exudyn's steps are computed in one compiled call where no user function sees the states in
    between. A user function of a load that depends on the time alone may say so by an attribute,
    function.dependsOnTimeOnly = True, in order not to stand in the way.

    Args:
        mbs: assembled system; its inextensible cables start from the initial configuration.
        simulationSettings: exudyn.SimulationSettings; used are startTime, endTime, numberOfSteps,
            verboseMode and all solution (output) settings.
        explicitSettings: integrator, step size, stabilisation.

    Returns:
        dict with 'success', 'integrator', 'stepSize' [s] (the smallest, if they adapt), 'steps',
        'loopSteps', 'decidedBy' (what bounded the step), 'bounds' (StepSizeBounds), 'path' (which way the
        steps were computed), 'startCorrections' (of each cable, and of joints: how far the initial
        state was from the constraints), 'drift' (largest 'energyGain' and 'energyLoss' of a run, relative
        to what its motion turned over, beyond the work done on it; largest violation of 'constraints',
        of joints [m, -] over the largest coordinate at the start if that is above 1; in runs of more than
        20 000 steps of cables alone, 'stepOverLimit', the largest share that the step was of the present
        stability limit),
        'retries' (how often the run began anew) and 'resumedAt' [s] (of a restart file; or None).

    Raises:
        InputError: arguments or times out of their limits, or files that cannot be written.
        SceneError: mbs not assembled, inconsistent, or contains what explicit steps cannot take.
        StepSizeError: stepSize is above the stability limit.
        RedundantConstraintError: constraints that depend on each other.
        DivergenceError: the run left the finite numbers or its constraints, or gained energy; mbs holds the
            last good output, with its time, and sensors and files hold all output until then.

    Example:
        report = SolveExplicit(mbs, simulationSettings, ExplicitSettings(stepSize=2.5e-3))
    """
    settings = simulation_settings(simulationSettings)
    explicit = explicit_settings(explicitSettings)
    for retry in range(explicit.retries + 1):
        try:
            return _solve(mbs, settings, explicit) | {"retries": retry}
        except DivergenceError as error:
            if retry == explicit.retries or not math.isfinite(error.step):
                raise
            explicit = replace(explicit, stepSize=0.5 * error.step)
    raise AssertionError  # the last try returns or raises


def _solve(mbs: Any, settings: Any, explicit: ExplicitSettings) -> dict[str, Any]:
    """One try of `SolveExplicit`."""
    require_assembled(mbs)
    solver = exudyn.MainSolverImplicitSecondOrder()
    scene = read_scene(mbs)
    sensors = [mbs.GetSensor(number) for number in range(mbs.systemData.NumberOfSensors())]
    warn_of_empty_sensors(mbs, sensors, scene.own_constraints)
    require_writable_outputs(settings, sensors)
    start = float(settings.timeIntegration.startTime)
    coupled = needs_coupling(mbs, scene)
    with switched_off(mbs, *scene.evaluated_by_kernels) if coupled else nullcontext():
        with state_kept(mbs) if coupled else nullcontext():
            restarts = Restarts(mbs, settings, explicit, scene.cables)
            given = None if explicit.stepSize is None else time_grid(mbs, settings, explicit.stepSize)
            scaling = (restarts.step or given.h) if given and explicit.massScaling else 0.0
            runs = runs_of_scene(mbs, scene, solver, start, scaling, explicit)
            bounds = step_bounds(runs, start, explicit)
            scaled = bounds_if_scaled(mbs, scene, solver, start, given.h if given else 0.0, explicit)
            wanted, decided_by = wanted_step(bounds, explicit, scaling or None, scaled)
            grid = restarts.grid(given or time_grid(mbs, settings, wanted))
            follow_frequencies(runs, bounds, explicit)
            observed = observed_derivatives(settings, sensors)
            loop = ExplicitTimeLoop(mbs, runs, scheme_of(explicit), grid, restarts, observed)
        try:
            with restarts.initial_state():
                _run(mbs, solver, settings, loop)
        finally:
            forget_evaluators(sensors)
    controls = [run.control for run in runs if isinstance(run, CableRun) and run.control]
    return {
        "success": True,
        "integrator": explicit.integrator,
        "stepSize": min([control.smallest for control in controls], default=grid.h),
        "steps": sum(control.steps for control in controls)
        or round((mbs.systemData.GetTime() - grid.start) / grid.h),
        "loopSteps": grid.loop_steps,
        "decidedBy": decided_by if grid.substeps > 1 or grid.h > 0.99 * wanted else "output period",
        "bounds": bounds,
        "path": loop.path,
        "startCorrections": [correction for run in runs for correction in run.start_corrections],
        "drift": worst_figures(runs),
        "resumedAt": grid.time(grid.first) if grid.first else None,
    }


@contextmanager
def _settings_of_the_loop(settings: Any, grid: TimeGrid) -> Iterator[None]:
    """Exudyn's own integrator must do nothing: no accelerations, no step control, no dense matrix."""
    time, solution = settings.timeIntegration, settings.solution
    wanted = [
        (time, "numberOfSteps", grid.loop_steps - grid.first),
        (time, "startTime", grid.time(grid.first)),
        (time, "adaptiveStep", False),
        (time.generalizedAlpha, "computeInitialAccelerations", False),
        (settings.linearSolver, "solverType", exudyn.LinearSolverType.EigenSparse),
        (solution.restart, "write", False),
        (solution.restart, "continueIfAvailable", False),
    ]
    if grid.first:  # the outputs that are there go on
        wanted += [(outputs, "append", True) for outputs in (solution.file, solution.sensors)]
        wanted += [(outputs, "writeHeader", False) for outputs in (solution.file, solution.sensors)]
        wanted += [(solution.file, "writeInitialValues", False)]
    saved = [(part, name, getattr(part, name)) for part, name, _ in wanted]
    try:
        for part, name, value in wanted:
            setattr(part, name, value)
        yield
    finally:
        for part, name, value in saved:
            setattr(part, name, value)


def _nothing(solver: Any, mbs: Any, settings: Any) -> bool:
    """What a solver calls whose run has ended."""
    return True


def _run(mbs: Any, solver: Any, settings: Any, loop: ExplicitTimeLoop) -> None:
    # In place of the iteration that calls Newton's method until contacts have settled: they do in a run.
    solver.SetUserFunctionDiscontinuousIteration(mbs, loop.user_function)
    mbs.sys["dynamicSolver"] = solver
    mbs.sys["simulationSettings"] = settings
    with _settings_of_the_loop(settings, loop.grid):
        try:
            success = solver.SolveSystem(mbs, settings)
        except Exception as error:
            if loop.error is None and "KeyboardInterrupt" in str(error):  # Exudyn wraps it
                kept = f"interrupted at t = {mbs.systemData.GetTime():.6g} s; mbs holds the state there."
                raise KeyboardInterrupt(kept) from None
            raise loop.error or error from None
        finally:
            loop.complete_state()
            solver.SetUserFunctionDiscontinuousIteration(mbs, _nothing)  # mbs must not keep itself alive
    if not success:
        raise loop.error or SceneError("the run was stopped before its end time.")
    loop.finish()
