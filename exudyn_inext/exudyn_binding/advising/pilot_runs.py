"""Pilot runs of a scene that a user's function builds."""

import time
import warnings
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import exudyn
import numpy as np

from ...advice.pilot import CONVENTIONAL, EXTENSIBLE, INEXTENSIBLE, Choice, Pilot
from ...arrays import Array
from ...cable.cable import CurvatureMeasure
from ...errors import DivergenceError, InputError, SceneError, StepSizeError
from ...items.arguments import sensor_number
from ...items.functions_of_time import step_functions, take_word
from ...run.settings import ExplicitSettings
from ..console import quiet_settings, silence
from ..scene import read_scene, require_assembled
from ..solver import SolveExplicit

Build = Callable[[int], Any]
"""Number of elements -> (mbs, sensorNumber)."""

REPEATS_BELOW = 0.2  # [s] of CPU time: shorter runs are taken twice, the shorter time counts
NEWTON_TOLERANCE = 1e-5
DENSE = 8  # elements up to which a dense solve is quicker


class PilotRuns:
    """Runs of inextensible cables with SolveExplicit, and of native ones with generalized-alpha.

    Args:
        build: of inextensible cables.   build_conventional: of native ones, or None.
        end_time: [s].   period: of the sensor's samples [s]; made to divide the end time.
        of_time_only: user functions of which the time alone is asked, see ExplicitSettings.
    """

    def __init__(
        self,
        build: Build,
        build_conventional: Build | None,
        end_time: float,
        period: float,
        of_time_only: bool | Sequence[Any] | None = None,
    ) -> None:
        self._build = build
        self._build_conventional = build_conventional
        self.end_time = end_time
        self._of_time_only = of_time_only
        self.samples = max(1, round(end_time / period))
        self.period = end_time / self.samples
        self._limits: dict[tuple[int, str], float] = {}
        self._ran: set[tuple[str, str]] = set()
        self._axial_stiffness: float | None = None
        self.formulation = INEXTENSIBLE
        self.dimension = 0
        self.has_step_functions = False
        self.length_constraints: dict[int, int] = {}  # n_bar of a cable, by its number of elements

    def stretching(self, axial_stiffness: float) -> "PilotRuns":
        """The same scene; cables that have none get this axial stiffness [N], whatever `build` says."""
        found = copy(self)
        found._axial_stiffness, found._limits = axial_stiffness, {}
        return found

    def _scene(self, elements: int) -> tuple[Any, int]:
        """What `build` returns; with axial stiffness if it is to have it."""
        mbs, sensor = _built("build", self._build, elements)
        take_word(mbs, self._of_time_only)
        for item in [cable.item for cable in read_scene(mbs).cables] if self._axial_stiffness else ():
            section = replace(item.cable.section, axial_stiffness=self._axial_stiffness)
            if not item.cable.stretches:
                measure = CurvatureMeasure.SECOND_DERIVATIVE
                item.cable = replace(
                    item.cable, section=section, measure=measure, length_constraints=elements
                )
        return mbs, sensor

    def step_limit(self, elements: int, integrator: str) -> float:
        """See `Problem`; a short run also compiles what the pilots need.

        Raises:
            SceneError: the scene has no inextensible cable.
        """
        if (elements, integrator) not in self._limits:
            mbs, _ = self._scene(elements)
            cables = read_scene(mbs).cables
            if not cables:
                raise SceneError(
                    "build: the mbs has no inextensible cable; add one with CreateInextensibleCable, or make "
                    "native elements one by ReplaceNativeCables."
                )
            if any(cable.cable.stretches for cable in cables):
                self.formulation = EXTENSIBLE
            self.has_step_functions = bool(step_functions(mbs))
            self.dimension = max(cable.cable.dimension for cable in cables)
            self.length_constraints[elements] = max(cable.cable.length_constraints for cable in cables)
            end = min(1e-3, self.end_time)
            report = SolveExplicit(mbs, _settings(end, end), ExplicitSettings(integrator, massScaling=0.0))
            bounds = report["bounds"]
            self._limits[elements, integrator] = bounds.safety * bounds.stability_limit
        return self._limits[elements, integrator]

    def run(self, choice: Choice) -> Pilot:
        """See `Problem`."""
        pilot = self._run_once(choice)
        way = (choice.formulation, choice.integrator)
        is_first = way not in self._ran  # and may have compiled what the short run did not need
        self._ran.add(way)
        if pilot.failure or (pilot.seconds > REPEATS_BELOW and not is_first):
            return pilot
        again = self._run_once(choice)
        return min(pilot, again, key=lambda one: one.seconds)

    def _run_once(self, choice: Choice) -> Pilot:
        if choice.formulation == CONVENTIONAL:
            return self._run_conventional(choice)
        mbs, sensor = self._scene(choice.elements)
        settings, explicit = _settings(self.end_time, self.period), self.explicit_settings(choice)
        start = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # its error decides
                report = SolveExplicit(mbs, settings, explicit)
        except (DivergenceError, StepSizeError) as error:
            return _failed(choice, time.process_time() - start, str(error))
        seconds = time.process_time() - start
        taken = replace(choice, step_size=report["stepSize"])
        return Pilot(taken, self._sampled(mbs, sensor), seconds, report["steps"])

    def _run_conventional(self, choice: Choice) -> Pilot:
        mbs, sensor = _built("buildConventional", self._build_conventional, choice.elements)
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
            with silence():
                mbs.SolveDynamic(settings)
        except Exception as error:  # Exudyn's solver errors have no common type
            return _failed(choice, time.process_time() - start, f"{type(error).__name__}: {error}")
        seconds = time.process_time() - start
        reached = mbs.systemData.GetTime()
        if reached < self.end_time - 0.5 * self.period:  # a user function may stop it, which is no error
            return _failed(choice, seconds, f"stopped at t = {reached:.6g} s")
        return Pilot(choice, self._sampled(mbs, sensor), seconds, steps)

    def _sampled(self, mbs: Any, sensor: int) -> Array:
        """(T, m) values at the same times in all runs; an implicit solver that cuts its steps misses some."""
        stored = np.atleast_2d(np.asarray(mbs.GetSensorStoredData(sensor)))
        times = np.linspace(0.0, self.end_time, self.samples + 1)
        return np.column_stack([np.interp(times, stored[:, 0], column) for column in stored.T[1:]])

    def explicit_settings(self, choice: Choice) -> ExplicitSettings:
        """Of a run with that choice."""
        return ExplicitSettings(
            choice.integrator,
            stepSize=choice.step_size,
            massScaling=choice.mass_scaling,
            dependsOnTimeOnly=self._of_time_only,
        )


def _failed(choice: Choice, seconds: float, why: str) -> Pilot:
    return Pilot(choice, np.zeros((0, 1)), seconds, 0, why)


def _built(name: str, build: Build | None, elements: int) -> tuple[Any, int]:
    """An assembled mbs, and the number of its sensor.   name: of the function, for messages."""
    built = build(elements) if build else None
    if not (isinstance(built, tuple | list) and len(built) == 2 and isinstance(built[0], exudyn.MainSystem)):
        raise InputError(f"{name}({elements}) returned {built!r}: must return (mbs, sensorNumber).")
    mbs, sensor = built
    require_assembled(mbs)
    number = int(mbs.systemData.NumberOfSensors())
    if not (0 <= sensor_number(sensor) < number and mbs.GetSensor(int(sensor))["storeInternal"]):
        raise InputError(
            f"{name}({elements}) returned the sensor {sensor!r}: must be the number of a sensor of mbs, "
            f"which has {number}, with storeInternal=True."
        )
    return mbs, int(sensor)


def _settings(end_time: float, step: float) -> Any:
    """Quiet, one of Exudyn's steps a sample.   step: [s]."""
    return quiet_settings(end_time, max(1, round(end_time / step)), step)
