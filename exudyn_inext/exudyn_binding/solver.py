"""SolveExplicit: an explicit integrator inside Exudyn's own time loop."""

import math
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from itertools import chain
from time import perf_counter
from typing import Any

import exudyn

from ..checks import require_flag
from ..errors import DivergenceError, SceneError
from ..garbage import not_collected
from ..items.arguments import explicit_settings, refuse_others, simulation_settings
from ..items.functions_of_time import functions_at_rest, step_functions, take_word
from ..items.functions_that_look import look_of_item_functions, look_of_step_functions
from ..native.native_items import state_kept
from ..native.velocity_level import Drives, at_position_level
from ..run.loop_clock import LoopClock
from ..run.output_files import ResumedOutputs, require_writable_outputs
from ..run.settings import ExplicitSettings
from ..run.step_choice import choose_step, warn_of_damping, warn_of_many_steps, warn_of_outputs
from ..run.time_grid import TimeGrid, loop_interval, time_grid
from .axial_check import axial_findings, warn_of_axial_findings
from .bend_check import largest_turns, warn_of_turns
from .cable_forces import shared_evaluators
from .changes.constraints import SteppedReader
from .changes.follower import ChangeFollower
from .changes.limit import StepLimit
from .changes.log import ChangeLog, listening
from .console import compile_notice, header_of, initialized
from .idle_integrator import changed, idle_integrator, nothing
from .mbs_state import at_start, first_row, initial_state
from .reports import ExplicitReport
from .restart import Restarts
from .scene import assemble, read_scene
from .scene_runs import RunBuilder, bounds_if_scaled
from .sensors import OutputTimes, observed_derivatives, sensors_of_forces, warn_of_empty_sensors
from .stretch_check import left_out_stretch, warn_of_worst
from .time_loop import (
    ExplicitTimeLoop,
    is_watched,
    refuse_newton_functions,
    warn_of_findings,
    worst_figures,
)
from .unseen_outputs import warn_of_unseen_outputs


def SolveExplicit(
    mbs: Any,
    simulationSettings: Any = None,
    explicitSettings: ExplicitSettings | None = None,
    updateInitialValues: bool = False,
    autoAssemble: bool = True,
    **others: Any,
) -> dict[str, Any]:
    """Explicit dynamics of a scene with inextensible cables, in Exudyn's own time loop.

    Compiled code moves the cables, and with them bodies, springs, joints, loads and contact that have
    compiled forms. Exudyn evaluates what has none. The report says which way was taken, and why. Joints are
    enforced in position, velocity and acceleration, as the cables' own constraints are. A
    CoordinateConstraint at velocity level holds the integral of its velocity. Other constraints on
    velocities are refused, and so are rotation vectors as coordinates. A scene may also do without
    inextensible cables.

    Steps that go wrong (constraints that cannot be solved for, an energy that jumps, numbers that are not
    finite) are rejected: the run goes on from the state before them with smaller ones, which grow again. It
    ends only where no step is small enough. Where axial vibrations are the cause, and the step is
    automatic, it begins again from the start, with shorter steps. Pre- and post-step user functions cannot
    be undone: the first steps are taken once without them, to find how long they may be; beside cables that
    stretch as many as may be, also after changes that follow on steps without any. So are the first steps
    that functions of items see. An energy that grows slowly is warned of, see
    ExplicitSettings.energyTolerance.
    The stability limit is that of the initial state, as if contacts of cables with circles that are open
    were closed. Among bodies it is found again each time cables that stretch are pulled a quarter tighter
    than before: automatic steps follow it down, given ones above it are warned of. Automatic steps also
    follow it where Exudyn evaluates contact or friction, which may close, or press harder, during the run.

    Sensors, solution files, pre- and post-step user functions and the SolutionViewer work as with
    mbs.SolveDynamic. Exudyn's steps are as long as the outputs allow: numberOfSteps of the time integration
    is a lower bound of their number, the write periods of sensors and solution file are upper bounds of
    their length. The integrator's own steps lie between them.

    What pre- and post-step user functions change acts from that step on, as with mbs.SolveDynamic: parameters
    of loads, connectors, constraints, markers and bodies, active connectors, and states. A constraint that
    gets another place, or whose user function reads what they change, is fulfilled at the end of the step. An
    automatic step becomes shorter where a change asks for it. Items cannot be added, nor connected otherwise.

    Many of Exudyn's steps are computed in one compiled call where no user function sees the states in
    between, and up to 32 where functions see them, but have changed nothing for a while. User functions of
    loads do not stand in the way if they depend on the time alone. That has to be seen from their code
    (they use neither their mbs nor other objects), or the settings say so, see
    ExplicitSettings.dependsOnTimeOnly.

    Restart files follow simulationSettings.solution.restart. With `write`, one is written every writePeriod
    and at the end. With `continueIfAvailable`, a run goes on from it, bit for bit as if it had never been
    interrupted. Scene and settings must be the same, user functions included (endTime may be later); names,
    drawing, sensors and files may change. Sensor and solution files are cut back to their last whole row at
    or before the time of the restart file, and appended to. Binary solution files are refused, as Exudyn does
    not append to them. With `write`, rows are flushed to their files at once.

    Args:
        mbs: system; its inextensible cables start from the initial configuration.
        simulationSettings: exudyn.SimulationSettings; used are startTime, endTime, numberOfSteps,
            verboseMode and all solution (output) settings.
        explicitSettings: integrator, step size, stabilisation.
        updateInitialValues: whether the state at the end becomes the initial one, where the next run begins.
        autoAssemble: whether mbs.Assemble() is called if mbs is not assembled, as mbs.SolveDynamic does.
        others: arguments of mbs.SolveDynamic that have no counterpart; they are refused by name.

    Returns:
        dict, which prints as a summary, with 'success', 'integrator', 'steps', 'loopSteps' (of Exudyn's
        loop), 'stepSize' [s] (the smallest, if they adapt), 'meanStepSize' [s], 'decidedBy' (what bounded
        it), 'bounds' (StepSizeBounds), 'massScaling' (theta), 'rejections' (how often steps went wrong and
        were taken again, smaller), 'path' (which way the steps were computed), 'startCorrections' (of each
        cable, and of joints: how far the initial state was from the constraints), 'drift': a dict with the
        largest 'energyGain' and 'energyLoss' (beyond the work done, as shares of the energy of the motion),
        and the largest violation of 'constraints' (of joints [m, -] over the largest coordinate at the start
        if that is above 1); in runs of more than 20 000 steps of cables alone also 'stepOverLimit', the
        largest share that the step was of the present stability limit, and 'resumedAt' [s] (of a restart
        file; or None).

    Raises:
        InputError: arguments or times out of their limits, or files that cannot be written.
        SceneError: mbs cannot be assembled, or shall not, is inconsistent, or contains what explicit steps
            cannot take; or a user function makes a change that a run cannot follow.
        StepSizeError: stepSize is above the stability limit.
        RedundantConstraintError: constraints that depend on each other.
        DivergenceError: the run left the finite numbers or its constraints, or gained energy; mbs holds the
            last good output, with its time, and sensors and files hold all output until then.

    Example:
        report = SolveExplicit(mbs, simulationSettings, ExplicitSettings(stepSize=2.5e-3))
    """
    refuse_others("SolveExplicit", others)
    settings = simulation_settings(simulationSettings)
    explicit = explicit_settings(explicitSettings)
    require_flag("updateInitialValues", updateInitialValues)
    assemble(mbs, "SolveExplicit", autoAssemble)
    refuse_newton_functions(mbs)
    take_word(mbs, explicit.dependsOnTimeOnly)
    longest = math.inf
    report: dict[str, Any] | None = None
    while report is None:
        try:
            report = _solve_from_start(mbs, settings, explicit, longest)
        except DivergenceError as error:
            longest = error.shorter_step
            if not (longest and _may_begin_again(mbs, settings, explicit)):
                raise
    if updateInitialValues:
        mbs.systemData.SetSystemState(mbs.systemData.GetSystemState(), exudyn.ConfigurationType.Initial)
    return report


def _may_begin_again(mbs: Any, settings: Any, explicit: ExplicitSettings) -> bool:
    """Whether a run with an automatic step can be undone, as nothing that saw its steps goes on from them."""
    solution = settings.solution
    goes_on = solution.sensors.append or solution.file.append or solution.restart.continueIfAvailable
    is_given = explicit.stepSize is not None or explicit.adaptiveStep
    return not (is_given or goes_on or step_functions(mbs))


def _solve_from_start(mbs: Any, settings: Any, explicit: ExplicitSettings, longest: float) -> dict[str, Any]:
    """Arguments: see `_solve`."""
    time = float(settings.timeIntegration.startTime)
    with ExitStack() as start:
        start.enter_context(not_collected())
        start.enter_context(at_start(mbs, time))
        with at_position_level(mbs, time) as drives:
            start.enter_context(functions_at_rest(mbs))
            return _solve(mbs, settings, explicit, drives, start, longest)


def _solve(
    mbs: Any,
    settings: Any,
    explicit: ExplicitSettings,
    drives: Drives,
    until_steps: ExitStack,
    longest: float,
) -> dict[str, Any]:
    """Arguments: see `SolveExplicit`.

    until_steps: what lasts until the first step, closed there.   longest: that an automatic step may be [s].
    """
    log, reader = ChangeLog(mbs), SteppedReader(mbs, drives)
    solver = exudyn.MainSolverImplicitSecondOrder()
    scene = read_scene(mbs, reader)
    sensors = [mbs.GetSensor(number) for number in range(mbs.systemData.NumberOfSensors())]
    warn_of_empty_sensors(mbs, sensors, scene.enforcing)
    warn_of_unseen_outputs(mbs, scene, sensors)
    require_writable_outputs(settings, sensors)
    start = float(settings.timeIntegration.startTime)
    restarts = Restarts(mbs, settings, explicit)
    if restarts.found:
        explicit = replace(explicit, massScaling=restarts.mass_scaling)
    if restarts.changes:
        log.restore(restarts.changes)
        reader.restore(restarts.changes)
        scene = read_scene(mbs, reader)
    with ExitStack() as stack:
        stack.enter_context(compile_notice(settings, solver))
        outputs = ResumedOutputs(settings, sensors) if restarts.found else None
        given = None if explicit.stepSize is None else time_grid(mbs, settings, explicit.stepSize)
        scaling = (restarts.step or given.h) if given and explicit.massScaling else 0.0
        builder = RunBuilder(mbs, log.changed.keys(), explicit, scaling, stack)
        time, state = (restarts.time, restarts.state) if restarts.changes else (start, None)
        runs = builder.build(scene, time, state, was_coupled=restarts.was_coupled)
        log.is_followed = is_watched(mbs, runs)
        duration = float(settings.timeIntegration.endTime) - start
        scaled = bounds_if_scaled(mbs, scene, start, given.h if given else 0.0, explicit)
        of_run = runs, start, duration, explicit
        damps, allowed = restarts.damps_implicitly, loop_interval(mbs, settings)
        choice = choose_step(*of_run, scaling, scaled, damps_implicitly=damps, longest=allowed)
        if choice.h > longest:
            choice = replace(choice, h=longest, decided_by="axial vibrations")
        bounds, explicit = choice.bounds, choice.explicit
        restarts.mass_scaling = explicit.massScaling
        warn_of_damping(choice, duration)
        warn_of_many_steps(runs, choice, duration, int(settings.timeIntegration.numberOfSteps))
        grid = restarts.grid(given or time_grid(mbs, settings, choice.h))
        warn_of_outputs(choice, duration, grid.loop_steps, settings.timeIntegration.numberOfSteps)
        builder.take_step(explicit, grid.h)
        decided_by = choice.decider(grid.substeps, grid.h, "output period")
        looking = settings, sensors, look_of_step_functions(mbs)
        limit = StepLimit(grid.h, bounds.stability_limit, explicit)
        if restarts.changes:
            limit.restore(restarts.changes)
        moves = bool(restarts.changes.get("moves"))
        changes = ChangeFollower(mbs, scene, reader, log, builder, limit, sensors, moves)
        restarts.changes_so_far = changes.stored
        loop = ExplicitTimeLoop(mbs, runs, grid, restarts, observed_derivatives(*looking), changes)
        log.set_pending()
        loop.output_times = OutputTimes(*looking, partial(look_of_item_functions, mbs), solver)
        log.sensors_of_forces = sensors_of_forces(sensors, scene.own_constraints)
        log.show_forces = loop.show_forces
        loop.step_is_from = decided_by if explicit.stepSize is None else ""
        shown: AbstractContextManager[None] = nullcontext()
        if restarts.found:
            shown = initial_state(mbs, restarts.state)
        elif loop.shows_accelerations:
            shown = first_row(mbs, runs, start)
        if outputs is not None:
            outputs.cut(grid.time(grid.first) + 0.5 * grid.substeps * grid.h)
        header = header_of(explicit, grid.h, decided_by, grid.substeps)
        until_steps.close()
        with shared_evaluators(sensors, loop.solved), shown, listening(log):
            _run(mbs, solver, settings, loop, outputs, log, header)
        with state_kept(mbs):
            warn_of_worst([one for kept in loop.kept_states for one in left_out_stretch(kept)])
            warn_of_axial_findings(list(map(axial_findings, loop.kept_states)))
            warn_of_turns(chain.from_iterable(map(largest_turns, loop.kept_states)))
    controls = [run.control for run in loop.runs]
    steps = max(control.steps for control in controls)
    warn_of_findings(loop.runs, explicit.energyTolerance)
    return ExplicitReport(
        {
            "success": True,
            "integrator": explicit.integratorName,
            "stepSize": min(control.smallest for control in controls),
            "meanStepSize": loop.time_of_steps / max(steps, 1),
            "steps": steps,
            "rejections": sum(control.rejections for control in controls),
            "massScaling": explicit.massScaling or 0.0,
            "loopSteps": grid.loop_steps,
            "decidedBy": decided_by,
            "bounds": bounds,
            "path": loop.path,
            "startCorrections": [correction for run in runs for correction in run.start_corrections],
            "drift": worst_figures([*loop.runs, changes]),
            "resumedAt": grid.time(grid.first) if grid.first else None,
        }
    )


@contextmanager
def _settings_of_the_loop(
    settings: Any, grid: TimeGrid, clock: LoopClock | None, outputs: ResumedOutputs | None
) -> Iterator[None]:
    """Exudyn's own integrator must do nothing; what a restart file counts on must be in the other files."""
    time, solution = settings.timeIntegration, settings.solution
    wanted = [
        (time, "numberOfSteps", grid.loop_steps),
        (time, "adaptiveStep", False),
        (solution, "flushFilesImmediately", bool(solution.restart.write or solution.flushFilesImmediately)),
        (solution.restart, "write", False),
        (solution.restart, "continueIfAvailable", False),
    ]
    if clock is not None:
        wanted += clock.settings(time)
    if outputs is not None:
        wanted += outputs.settings(solution)
    with idle_integrator(settings), changed(wanted):
        yield


def _solve_system(solver: Any, mbs: Any, settings: Any, header: str) -> bool:
    """As solver.SolveSystem, which would forget the initial Lagrange multipliers before the first row."""
    begin, data = perf_counter(), mbs.systemData
    if not initialized(solver, lambda: solver.InitializeSolver(mbs, settings), settings, header):
        return False
    solver.timer.total = -solver.output.cpuStartTime  # exudyn.special.solver.timeout counts from there
    data.SetAECoordinates(data.GetAECoordinates(exudyn.ConfigurationType.Initial))
    success = bool(solver.SolveSteps(mbs, settings))
    solver.timer.total = perf_counter() - begin
    solver.FinalizeSolver(mbs, settings)
    return success


def _run(
    mbs: Any,
    solver: Any,
    settings: Any,
    loop: ExplicitTimeLoop,
    outputs: ResumedOutputs | None,
    log: ChangeLog,
    header: str,
) -> None:
    function, clock = loop.user_function, loop.restarts.clock(loop.grid)
    if clock is not None:
        function = clock.continued(function, settings.solution)
    # In place of the iteration that calls Newton's method until contacts have settled: they do in a run.
    solver.SetUserFunctionDiscontinuousIteration(mbs, function)
    mbs.sys["dynamicSolver"] = solver
    mbs.sys["simulationSettings"] = settings
    with _settings_of_the_loop(settings, loop.grid, clock, outputs):
        try:
            success = _solve_system(solver, mbs, settings, header)
        except Exception as error:
            cause = loop.cause_of(error, log)
            raise cause from cause.__cause__
        finally:
            loop.complete_state()
            solver.SetUserFunctionDiscontinuousIteration(mbs, nothing)  # mbs must not keep itself alive
    if not success:
        raise loop.error or SceneError("the run was stopped before its end time.")
    loop.finish()
