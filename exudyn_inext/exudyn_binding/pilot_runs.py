"""Pilot runs of a scene that a user's function builds."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from typing import Any

import exudyn
import numpy as np

from ..adviser.pilot import CONVENTIONAL, Choice, Pilot
from ..adviser.stretch import Tension
from ..arrays import Array
from ..errors import DivergenceError, InputError, SceneError
from .cable_forces import CableForces
from .scene import read_scene
from .settings import ExplicitSettings
from .solver import SolveExplicit

Build = Callable[[int], Any]
"""Number of elements -> (mbs, sensorNumber)."""

LOOKS_AT_TENSION = 40
REPEATS_BELOW = 0.2  # [s] of CPU time: shorter runs are taken twice, the shorter time counts
NEWTON_TOLERANCE = 1e-5
DENSE = 8  # elements up to which a dense solve is quicker


class PilotRuns:
    """Runs of inextensible cables with SolveExplicit, and of native ones with generalized-alpha.

    Args:
        build: of inextensible cables.   build_conventional: of native ones, or None.
        end_time: [s].   period: of the sensor's samples [s].
    """

    def __init__(
        self, build: Build, build_conventional: Build | None, end_time: float, period: float
    ) -> None:
        self._build = build
        self._build_conventional = build_conventional
        self.end_time = end_time
        self.period = period
        self._limits: dict[tuple[int, str], float] = {}
        self.dimension = 0

    def step_limit(self, elements: int, integrator: str) -> float:
        """See `Problem`; a short run also compiles what the pilots need."""
        if (elements, integrator) not in self._limits:
            mbs, _ = _built(self._build, elements)
            cables = read_scene(mbs).cables
            if not cables:
                raise SceneError(
                    "build: the mbs has no inextensible cable; add one with CreateInextensibleCable."
                )
            self.dimension = max(cable.cable.dimension for cable in cables)
            end = min(1e-3, self.end_time)
            report = SolveExplicit(mbs, _settings(end, end), ExplicitSettings(integrator))
            bounds = report["bounds"]
            self._limits[elements, integrator] = bounds.safety * bounds.stability_limit
        return self._limits[elements, integrator]

    def run(self, choice: Choice) -> Pilot:
        """See `Problem`."""
        pilot = self._run_once(choice)
        if pilot.failure or pilot.seconds > REPEATS_BELOW:
            return pilot
        again = self._run_once(choice)
        return min(pilot, again, key=lambda one: one.seconds)

    def _run_once(self, choice: Choice) -> Pilot:
        if choice.formulation == CONVENTIONAL:
            return self._run_conventional(choice)
        mbs, sensor = _built(self._build, choice.elements)
        explicit = ExplicitSettings(
            choice.integrator, stepSize=choice.step_size, massScaling=choice.mass_scaling
        )
        settings = _settings(self.end_time, self.period)
        start = time.process_time()
        try:
            report = SolveExplicit(mbs, settings, explicit)
        except DivergenceError as error:
            return Pilot(choice, np.zeros((0, 1)), time.process_time() - start, 0, str(error))
        seconds = time.process_time() - start
        taken = replace(choice, step_size=report["stepSize"])
        return Pilot(taken, _stored(mbs, sensor), seconds, report["steps"])

    def _run_conventional(self, choice: Choice) -> Pilot:
        mbs, sensor = _built(self._build_conventional, choice.elements)
        steps = max(1, round(self.end_time / choice.step_size))
        settings = _settings(self.end_time, self.end_time / steps)
        settings.solution.sensors.writePeriod = self.period
        newton = settings.timeIntegration.newton
        newton.useModifiedNewton = newton.modifiedNewtonJacUpdatePerStep = True
        newton.relativeTolerance = NEWTON_TOLERANCE
        if choice.elements > DENSE:
            settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        start = time.process_time()
        try:
            with _silence():
                mbs.SolveDynamic(settings)
        except Exception as error:  # Exudyn's solver errors have no common type
            return Pilot(
                choice, np.zeros((0, 1)), time.process_time() - start, 0, f"{type(error).__name__}: {error}"
            )
        return Pilot(choice, _stored(mbs, sensor), time.process_time() - start, steps)

    def tension(self, choice: Choice) -> Tension:
        """Largest one along all cables, at some times of a run."""
        mbs, _ = _built(self._build, choice.elements)
        explicit = ExplicitSettings(choice.integrator, stepSize=choice.step_size)
        cables = read_scene(mbs).cables
        times, found = np.linspace(0.0, self.end_time, LOOKS_AT_TENSION + 1), []
        for start, end in pairwise(times):
            settings = _settings(float(end), float(end - start))
            settings.timeIntegration.startTime = float(start)
            SolveExplicit(mbs, settings, explicit)
            _go_on_from_here(mbs)
            found.append(max(float(CableForces(mbs, cable.number, 21)["tension"].max()) for cable in cables))
        section = cables[0].cable.section
        return Tension(
            rms=float(np.sqrt(np.mean(np.square(found)))),
            largest=max(found),
            length=sum(cable.cable.length for cable in cables),
            mass_per_length=section.mass_per_length,
        )


def _built(build: Build | None, elements: int) -> tuple[Any, int]:
    built = build(elements) if build else None
    if not (isinstance(built, tuple | list) and len(built) == 2 and hasattr(built[0], "systemData")):
        raise InputError(f"build({elements}) returned {built!r}: must return (mbs, sensorNumber).")
    mbs, sensor = built
    number = int(mbs.systemData.NumberOfSensors())
    if (
        isinstance(sensor, bool)
        or not 0 <= int(sensor) < number
        or not mbs.GetSensor(sensor)["storeInternal"]
    ):
        raise InputError(
            f"build({elements}) returned the sensor {sensor!r}: must be the number of a sensor of mbs, which "
            f"has {number}, with storeInternal=True."
        )
    return mbs, int(sensor)


def _settings(end_time: float, step: float) -> Any:
    """Silent, no files, one of Exudyn's steps a sample.   step: [s]."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step
    settings.timeIntegration.endTime = end_time
    settings.timeIntegration.numberOfSteps = max(1, round(end_time / step))
    settings.timeIntegration.verboseMode = 0
    return settings


def _stored(mbs: Any, sensor: int) -> Array:
    """(T, m) values."""
    stored: Array = np.atleast_2d(np.asarray(mbs.GetSensorStoredData(sensor)))[:, 1:]
    return stored


def _go_on_from_here(mbs: Any) -> None:
    """The next run begins with the state of mbs."""
    data, initial = mbs.systemData, exudyn.ConfigurationType.Initial
    data.SetODE2Coordinates(data.GetODE2Coordinates(), initial)
    data.SetODE2Coordinates_t(data.GetODE2Coordinates_t(), initial)
    data.SetODE1Coordinates(data.GetODE1Coordinates(), initial)
    data.SetDataCoordinates(data.GetDataCoordinates(), initial)


@contextmanager
def _silence() -> Iterator[None]:
    before = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = before
