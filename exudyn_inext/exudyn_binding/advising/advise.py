"""Advise: model, mesh, integrator and step for a wanted accuracy, from pilot runs of the user's scene."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from ...advice.advice import (
    Advice,
    choice_sentence,
    convergence_sentence,
    is_conventional,
    rival_sentence,
    stretch_sentence,
)
from ...advice.cost import predicted_seconds
from ...advice.pilot import INEXTENSIBLE, Choice
from ...advice.rivals import LENIENCE, climb, judge_by_themselves, judge_rivals
from ...advice.search import Tried, expected_error, extrapolated, most_accurate, search_inextensible
from ...advice.stretch import stretch_error
from ...advice.survey import survey_meshes
from ...checks import require_positive
from ...errors import InputError
from ...run.settings import ExplicitSettings
from .advice_settings import MOST_SAMPLES, SAMPLES, AdviceSettings, require_builder
from .pilot_runs import Build, PilotRuns


def Advise(
    build: Build,
    tolerance: float,
    endTime: float,
    budget: float | None = None,
    settings: AdviceSettings | None = None,
) -> dict[str, Any]:
    """Formulation, mesh, integrator and step for a wanted accuracy, from pilot runs of the scene itself.

    RATTLE runs on finer and finer meshes until Richardson's extrapolation says that the finest one is good to
    a fifth of the tolerance. It judges runs with other integrators, steps and scaled masses, which are tried
    in the order of their expected cost as long as they could be the cheapest. Where `pilotBudget` ends
    before, mesh and error are extrapolated. What is returned is measured otherwise.

    Args:
        build: function of a number of elements N (of each cable) that builds and assembles the scene, and
            returns (mbs, sensorNumber); the sensor, with storeInternal=True, shows what has to be accurate,
            such as the position of a node.
        tolerance: largest error of the sensor's value in the whole run, in its units.
        endTime: of the run [s].
        budget: CPU time that a run may take [s]; None: as much as the tolerance asks for.
        settings: how pilots are run, and what is known of the real cable.

    Returns:
        dict with 'formulation' ('inextensible' or 'conventional'), 'dimension', 'numberOfElements',
        'numberOfLengthConstraints', 'integrator', 'stepSize' [s], 'stabilizationRate' [1/s], 'massScaling'
        [-], 'explicitSettings' (to be handed to SolveExplicit; None for conventional cables),
        'predictedError', 'predictedSeconds' (CPU), 'extrapolated', 'meetsTolerance', 'meetsBudget',
        'reasons' (sentences), 'tried' (list of dicts, one a pilot) and 'pilotSeconds' (CPU, of these).

    Raises:
        InputError: arguments out of their limits, a builder that returns something else, or a tolerance
            that is too far below what the pilots resolve.
        SceneError: solutions on finer and finer meshes do not converge; or what SolveExplicit raises.

    Example:
        advice = Advise(build, tolerance=1e-3, endTime=5.0)
        mbs, sensor = build(advice["numberOfElements"])
        SolveExplicit(mbs, simulationSettings, advice["explicitSettings"])
    """
    require_builder("build", build)
    tolerance, end_time = require_positive("tolerance", tolerance), require_positive("endTime", endTime)
    limit = float("inf") if budget is None else require_positive("budget", budget)
    settings = AdviceSettings() if settings is None else settings
    if not isinstance(settings, AdviceSettings):
        raise InputError(f"settings = {settings!r}: must be AdviceSettings.")
    return _Session(build, tolerance, end_time, limit, settings).result()


class _Session:
    """One piece of advice."""

    def __init__(
        self, build: Build, tolerance: float, end_time: float, budget: float, settings: AdviceSettings
    ) -> None:
        self._tolerance, self._budget, self._settings = tolerance, budget, settings
        period = settings.samplePeriod or end_time / SAMPLES
        if end_time / period > MOST_SAMPLES:
            raise InputError(
                f"samplePeriod = {period:g} s: these are more than {MOST_SAMPLES:g} samples in endTime = "
                f"{end_time:g} s; give a larger one."
            )
        self._problem = PilotRuns(build, settings.buildConventional, end_time, period)
        numbers, cost = settings.numbersOfElements, settings.pilotBudget
        self._survey = survey_meshes(self._problem, tolerance, numbers, cost)
        self._search = search_inextensible(self._problem, self._survey, tolerance)

    def result(self) -> dict[str, Any]:
        """See `Advise`."""
        advice = self._advice()
        choice = advice.choice
        explicit = _explicit_settings(choice) if choice.formulation == INEXTENSIBLE else None
        return {
            "formulation": choice.formulation,
            "dimension": self._problem.dimension,
            "numberOfElements": choice.elements,
            "numberOfLengthConstraints": self._problem.length_constraints[choice.elements]
            if explicit
            else None,
            "integrator": choice.integrator,
            "stepSize": choice.step_size,
            "stabilizationRate": explicit.stabilizationRate if explicit else None,
            "massScaling": choice.mass_scaling,
            "explicitSettings": explicit,
            "predictedError": advice.error,
            "predictedSeconds": advice.seconds,
            "extrapolated": advice.extrapolated,
            "meetsTolerance": advice.error <= self._tolerance,
            "meetsBudget": advice.seconds <= self._budget,
            "reasons": list(advice.reasons),
            "tried": [_row(tried) for tried in self._tried],
            "pilotSeconds": sum(tried.pilot.seconds for tried in self._tried),
        }

    @cached_property
    def _rivals(self) -> list[Tried]:
        if self._settings.buildConventional is None:
            return []
        best = None if self._stretches else self._search.best
        most = LENIENCE * best.pilot.seconds if best else self._settings.pilotBudget
        pilots = climb(self._problem, self._survey, most)
        if self._stretches:
            return judge_by_themselves(pilots)
        judge_rivals(self._search, pilots)
        return [tried for tried in self._search.tried if is_conventional(tried)]

    @cached_property
    def _tried(self) -> list[Tried]:
        """All that was run; where cables stretch, that is an error of the inextensible ones."""
        if not (self._stretch and self._stretches):
            return self._search.tried
        return [*(Tried(t.pilot, t.error + self._stretch[0]) for t in self._search.tried), *self._rivals]

    @cached_property
    def _stretch(self) -> tuple[float, str] | None:
        """What stretch moves the sensor by, and the sentence on it."""
        stiffness = self._settings.axialStiffness
        if stiffness is None:
            return None
        tension = self._problem.tension(self._survey.pilots[0].choice)
        error = stretch_error(tension, stiffness, self._survey.finest.values)
        return error, stretch_sentence(tension, stiffness, error, self._tolerance)

    @property
    def _stretches(self) -> bool:
        return self._stretch is not None and self._stretch[0] > self._tolerance

    def _advice(self) -> Advice:
        reasons = [convergence_sentence(self._search)]
        if self._stretch:
            reasons.append(self._stretch[1])
        rivals = self._rivals
        if rivals:
            own = [] if self._stretches else [t for t in self._search.good if not is_conventional(t)]
            best = min(own, key=_seconds, default=None)
            reasons.append(rival_sentence(rivals, best, self._tolerance))
        best = self._best_conventional(rivals) if self._stretches else self._search.best
        if best is None and not self._stretches:
            return self._extrapolated(reasons)
        if best is None:
            best = self._closest(reasons)
        return self._measured(self._within_budget(best.pilot.seconds, reasons) or best, reasons)

    def _best_conventional(self, rivals: Sequence[Tried]) -> Tried | None:
        good = [one for one in rivals if one.works and one.error <= self._tolerance]
        return min(good, key=_seconds, default=None)

    def _closest(self, reasons: list[str]) -> Tried:
        """Where cables stretch and no conventional run was good enough, or none could be built."""
        reasons.append(
            "No conventional run within the tolerance was found"
            + (": give buildConventional." if self._settings.buildConventional is None else ".")
        )
        return min(self._rivals or self._tried, key=lambda one: one.error)

    def _within_budget(self, seconds: float, reasons: list[str]) -> Tried | None:
        """What replaces a run of that CPU time [s]; None if that is within the budget, or no pilot is."""
        if seconds <= self._budget:
            return None
        found = most_accurate(self._tried, self._budget)
        if found is None:
            reasons.append(f"No pilot took less than the budget of {self._budget:g} s.")
            return None
        reasons.append(
            f"The tolerance needs {seconds:.2g} s, more than the budget of {self._budget:g} s: "
            "the most accurate run within the budget is advised."
        )
        return found

    def _extrapolated(self, reasons: list[str]) -> Advice:
        choice = extrapolated(self._problem, self._survey, self._tolerance)
        if choice is None:
            raise InputError(
                f"tolerance = {self._tolerance:g}: the pilots resolve {self._survey.uncertainty:.2g} at best "
                f"({self._survey.finest.choice.label}), too far from it to extrapolate: give a larger "
                "pilotBudget, finer numbersOfElements, or a larger tolerance."
            )
        seconds = predicted_seconds(self._survey.pilots, choice, self._problem.end_time)
        affordable = self._within_budget(seconds, reasons)
        if affordable:
            return self._measured(affordable, reasons)
        error = expected_error(self._survey, choice)
        reasons.insert(0, f"{choice.label}: error and CPU time are extrapolated from coarser meshes.")
        return Advice(choice, error, seconds, True, tuple(reasons))

    def _measured(self, best: Tried, reasons: list[str]) -> Advice:
        reasons.insert(0, choice_sentence(best, self._tolerance))
        return Advice(best.pilot.choice, best.error, best.pilot.seconds, False, tuple(reasons))


def _seconds(tried: Tried) -> float:
    return tried.pilot.seconds


def _explicit_settings(choice: Choice) -> ExplicitSettings:
    return ExplicitSettings(choice.integrator, stepSize=choice.step_size, massScaling=choice.mass_scaling)


def _row(tried: Tried) -> dict[str, Any]:
    pilot = tried.pilot
    return {
        "label": pilot.choice.label,
        "formulation": pilot.choice.formulation,
        "integrator": pilot.choice.integrator,
        "numberOfElements": pilot.choice.elements,
        "stepSize": pilot.choice.step_size,
        "massScaling": pilot.choice.mass_scaling,
        "seconds": pilot.seconds,
        "error": tried.error,
        "failure": pilot.failure,
    }
