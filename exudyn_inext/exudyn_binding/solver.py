"""SolveExplicit: an explicit integrator inside Exudyn's own time loop."""

import copy
import math
import warnings
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np

from ..errors import DivergenceError, InextensibleError, InputError, SceneError
from ..integrators import find_integrator
from ..integrators.step_size import StepSizeBounds, choose_step, rule_step, step_above_limit
from .cable_run import CableRun
from .scene import initial_state, read_scene, require_assembled
from .settings import ExplicitSettings


@dataclass(frozen=True)
class TimeGrid:
    """Steps of Exudyn's time loop, each cut into equal steps of the integrator.

    start: [s].   loop_steps: number of Exudyn steps.   substeps: integrator steps in each of them.
    h: step of the integrator [s].
    """

    start: float
    loop_steps: int
    substeps: int
    h: float


class ExplicitTimeLoop:
    """Exudyn calls `advance` once for each step of its time loop."""

    def __init__(self, runs: list[CableRun], scheme: Any, grid: TimeGrid) -> None:
        self.runs = runs
        self.scheme = scheme
        self.grid = grid
        self.error: InextensibleError | None = None
        self._written: list[list[float]] = []

    def start(self, mbs: Any) -> None:
        """Evaluate all cables at the start of the run."""
        for run in self.runs:
            run.start(self.grid.start)
        self._written = [
            mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Initial),
            mbs.systemData.GetODE2Coordinates_t(exudyn.ConfigurationType.Initial),
        ]

    def advance(self, solver: Any, mbs: Any, settings: Any) -> bool:
        """One step of Exudyn's time loop: from the start-of-step to the end-of-step state."""
        data = mbs.systemData
        end = data.GetTime()
        begin = end - self.grid.substeps * self.grid.h
        self._take_over_changes(data, begin)
        coordinates = [np.zeros(len(self._written[0])) for _ in range(3)]
        for run in self.runs:
            run.advance(self.scheme, begin, self.grid.h, self.grid.substeps)
            if not run.is_finite():
                self.error = _divergence(run, begin, end)
                raise self.error
            for target, values in zip(
                coordinates, (run.displacements(), run.state.v, run.state.a), strict=True
            ):
                target[run.scene_cable.indices] = values
        data.SetODE2Coordinates(coordinates[0])
        data.SetODE2Coordinates_t(coordinates[1])
        data.SetODE2Coordinates_tt(coordinates[2])
        self._written = [data.GetODE2Coordinates(), data.GetODE2Coordinates_t()]
        return True

    def _take_over_changes(self, data: Any, time: float) -> None:
        """A user function may have set coordinates since the last step: restart from them."""
        present = [data.GetODE2Coordinates(), data.GetODE2Coordinates_t()]
        if np.array_equal(present[0], self._written[0]) and np.array_equal(present[1], self._written[1]):
            return
        q, v = np.asarray(present[0]), np.asarray(present[1])
        for run in self.runs:
            indices = run.scene_cable.indices
            run.set_coordinates(q[indices] + run.scene_cable.cable.reference.ravel(), v[indices])
            run.start(time)


def SolveExplicit(
    mbs: Any, simulationSettings: Any = None, explicitSettings: ExplicitSettings | None = None
) -> dict[str, Any]:
    """Explicit dynamics of a scene of inextensible cables, in Exudyn's own time loop.

    Sensors, solution files, pre- and post-step user functions and the SolutionViewer work as
    with mbs.SolveDynamic. Exudyn's steps are as long as the outputs allow: numberOfSteps of the
    time integration is a lower bound of their number, the write periods of sensors and solution
    file another one; between them the integrator runs in one compiled call.

    Args:
        mbs: assembled system; its inextensible cables start from the initial configuration.
        simulationSettings: exudyn.SimulationSettings; used are startTime, endTime, numberOfSteps,
            verboseMode and all solution (output) settings.
        explicitSettings: integrator, step size, stabilisation.

    Returns:
        dict with 'success', 'integrator', 'stepSize' [s], 'steps', 'loopSteps', 'decidedBy' (what
        bounded the step), 'bounds' (StepSizeBounds) and 'path' (which solver path ran and why).

    Raises:
        SceneError: mbs not assembled, inconsistent, or contains what is not supported yet.
        StepSizeError: stepSize is above the stability limit.
        RedundantConstraintError: constraints that depend on each other.
        DivergenceError: the run left the finite numbers; mbs holds the last finite state.

    Example:
        report = SolveExplicit(mbs, simulationSettings, ExplicitSettings(stepSize=2.5e-3))
    """
    settings = copy.deepcopy(simulationSettings or exudyn.SimulationSettings())
    explicit = explicitSettings or ExplicitSettings()
    integrator = find_integrator(explicit.integrator)
    scheme = explicit.scheme or integrator.scheme()
    require_assembled(mbs)
    cables = read_scene(mbs)
    if not cables:
        raise SceneError(
            "mbs has no inextensible cable: add one with CreateInextensibleCable, or use mbs.SolveDynamic."
        )
    start = float(settings.timeIntegration.startTime)
    runs = [
        CableRun(cable, initial_state(mbs, cable), explicit.stabilizationRate, integrator)
        for cable in cables
    ]
    bounds = _bounds(runs, start, explicit, integrator, scheme)
    wanted, decided_by = _wanted_step(bounds, explicit)
    grid = _time_grid(mbs, settings, wanted)
    loop = ExplicitTimeLoop(runs, scheme, grid)
    loop.start(mbs)
    mbs.sys["simulationSettings"] = simulationSettings or settings
    _run(mbs, settings, loop)
    return {
        "success": True,
        "integrator": explicit.integrator,
        "stepSize": grid.h,
        "steps": grid.loop_steps * grid.substeps,
        "loopSteps": grid.loop_steps,
        "decidedBy": decided_by if grid.substeps > 1 or grid.h > 0.999 * wanted else "output interval",
        "bounds": bounds,
        "path": f"compiled: {len(runs)} cable(s) with known loads, {grid.substeps} step(s) a call",
    }


def _bounds(
    runs: list[CableRun], start: float, explicit: ExplicitSettings, integrator: Any, scheme: Any
) -> StepSizeBounds:
    """The tightest bounds over all cables."""
    frequencies = [run.largest_frequency(start) for run in runs]
    fastest = int(np.argmax(frequencies))
    frequency = frequencies[fastest]
    limit = integrator.frequency_limit(scheme)
    models = [run.scene_cable.cable for run in runs]
    return StepSizeBounds(
        bending=limit / frequency if frequency > 0.0 else math.inf,
        stabilisation=integrator.decay_limit(scheme) / explicit.stabilizationRate,
        rule=min(
            rule_step(
                float(model.element_lengths.min()),
                model.section.mass_per_length,
                model.section.bending_stiffness,
                explicit.stepConstant,
            )
            for model in models
        ),
        largest_frequency=frequency,
        cable=runs[fastest].name,
    )


def _wanted_step(bounds: StepSizeBounds, explicit: ExplicitSettings) -> tuple[float, str]:
    if explicit.stepSize is None:
        return choose_step(bounds, explicit.stepSafety)
    error = step_above_limit(explicit.stepSize, bounds, explicit.integrator)
    if error is not None and not explicit.allowUnstableStep:
        raise error
    if error is not None:
        warnings.warn(str(error), stacklevel=3)
    return explicit.stepSize, "stepSize"


def _time_grid(mbs: Any, settings: Any, wanted: float) -> TimeGrid:
    """As few loop steps as the outputs allow, each with equal integrator steps of at most `wanted`."""
    time = settings.timeIntegration
    duration = time.endTime - time.startTime
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(
            f"endTime - startTime = {duration} s: must be a finite number > 0; set timeIntegration.endTime."
        )
    interval = duration / time.numberOfSteps
    if settings.solution.file.write:
        interval = min(interval, settings.solution.file.writePeriod)
    if settings.solution.sensors.active and mbs.systemData.NumberOfSensors() > 0:
        interval = min(interval, settings.solution.sensors.writePeriod)
    interval = max(interval, min(wanted, duration / time.numberOfSteps))
    loop_steps = math.ceil(duration / interval * (1.0 - 1e-9))
    substeps = math.ceil(duration / loop_steps / wanted * (1.0 - 1e-9))
    return TimeGrid(time.startTime, loop_steps, substeps, duration / (loop_steps * substeps))


def _run(mbs: Any, settings: Any, loop: ExplicitTimeLoop) -> None:
    settings.timeIntegration.numberOfSteps = loop.grid.loop_steps
    settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    solver = exudyn.MainSolverImplicitSecondOrder()
    solver.SetUserFunctionNewton(mbs, loop.advance)
    mbs.sys["dynamicSolver"] = solver
    try:
        success = solver.SolveSystem(mbs, settings)
    except Exception as error:
        raise loop.error or error from None
    if not success:
        raise loop.error or SceneError("the run was stopped before its end time.")


def _divergence(run: CableRun, begin: float, end: float) -> DivergenceError:
    return DivergenceError(
        f"{run.name} diverged between t = {begin:.6g} s and t = {end:.6g} s: its coordinates are not finite. "
        "mbs holds the last finite state. Likely causes: a step close to the stability limit of a "
        "cable that straightened, or a violent start; reduce stepSize, or change stabilizationRate."
    )
