"""Advise: model, mesh, integrator and step for a wanted accuracy, from pilot runs of the user's scene."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...advice.advice import (
    candidate_sentence,
    choice_sentence,
    convergence_sentence,
    cost_sentence,
    step_function_sentence,
    stretch_sentence,
)
from ...advice.candidates import LENIENCE, climb, coarsen
from ...advice.cost import predicted_seconds
from ...advice.pilot import EXTENSIBLE, Choice, Pilot
from ...advice.search import expected_error, extrapolated, most_accurate, try_families
from ...advice.survey import INTEGRATOR, SHARE_OF_TOLERANCE, Search, survey_meshes
from ...checks import require_functions, require_integer, require_positive
from ...errors import InputError
from ...items.arguments import settings_of
from ..reports import AdviceReport
from .pilot_runs import Build, PilotRuns

NUMBERS = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96)
SAMPLES = 500
MOST_SAMPLES = 1e6
LARGEST_NUMBER = 100_000
OPTIONAL = ("samplePeriod", "axialStiffness")


@dataclass(frozen=True)
class AdviceSettings:
    """How pilots are run.

    Args:
        samplePeriod: [s] at which the sensor is compared; None: a five hundredth of endTime.
        numbersOfElements: that pilots may have, increasing; those that cannot be built are left out.
        pilotBudget: CPU time that solutions on finer and finer meshes may take together [s].
        axialStiffness: EA of the real cables [N]; None: stretch is not looked at.
        buildConventional: function of a number of elements that builds the same scene with native cables,
            returning (mbs, sensorNumber); None: native cables are not compared.
        dependsOnTimeOnly: user functions that depend on the time alone, see ExplicitSettings.
    """

    samplePeriod: float | None = None
    numbersOfElements: Sequence[int] = NUMBERS
    pilotBudget: float = 20.0
    axialStiffness: float | None = None
    buildConventional: Build | None = None
    dependsOnTimeOnly: bool | Sequence[Any] | None = None

    def __post_init__(self) -> None:
        """Check all of them.

        Raises:
            InputError: a number out of range, or numbers of elements that do not increase.
        """
        for name in ("samplePeriod", "pilotBudget", "axialStiffness"):
            if getattr(self, name) is not None or name not in OPTIONAL:
                object.__setattr__(self, name, require_positive(name, getattr(self, name)))
        numbers = self.numbersOfElements
        if not isinstance(numbers, list | tuple) or len(numbers) < 3:
            raise InputError(f"numbersOfElements = {numbers!r}: must be a list of at least three integers.")
        checked = [require_integer("numbersOfElements", n, 1, LARGEST_NUMBER) for n in numbers]
        if sorted(set(checked)) != checked:
            raise InputError(f"numbersOfElements = {numbers!r}: must increase.")
        require_builder("buildConventional", self.buildConventional, optional=True)
        require_functions("dependsOnTimeOnly", self.dependsOnTimeOnly)


def require_builder(name: str, build: Any, optional: bool = False) -> None:
    """Raise InputError for what cannot build a scene."""
    if not callable(build) and not (optional and build is None):
        raise InputError(
            f"{name} = {build!r}: must be a function of a number of elements that returns "
            "(mbs, sensorNumber)."
        )


def Advise(
    build: Build,
    tolerance: float,
    endTime: float,
    budget: float | None = None,
    settings: AdviceSettings | None = None,
) -> dict[str, Any]:
    """Formulation, mesh, integrator and step for a wanted accuracy, from pilot runs of the scene itself.

    RATTLE runs on finer and finer meshes until Richardson's extrapolation says that the finest one is good
    to a fifth of the tolerance. Runs with other integrators, steps and scaled masses are compared with it,
    in the order of their expected cost, as long as they could be the cheapest. Where `pilotBudget` ends
    before, mesh and error are extrapolated; otherwise, what is returned is measured.

    Args:
        build: function of a number of elements N (of each cable) that builds and assembles the scene, and
            returns (mbs, sensorNumber); the sensor, with storeInternal=True, shows what has to be accurate,
            such as the position of a node.
        tolerance: largest error of the sensor's value in the whole run, in its units.
        endTime: of the run [s].
        budget: CPU time that a run may take [s]; None: as much as the tolerance asks for.
        settings: how pilots are run, and what is known of the real cable.

    Returns:
        dict, which prints as a summary, with 'formulation' ('inextensible', 'extensible' or
        'conventional'), 'axialStiffness' [N] (to be given to the cables of `build`, or None), 'dimension',
        'numberOfElements', 'numberOfLengthConstraints' (None of cables that stretch),
        'integrator', 'stepSize' [s], 'stabilizationRate' [1/s], 'massScaling'
        [-], 'explicitSettings' (to be handed to SolveExplicit; None for conventional cables),
        'predictedError', 'predictedSeconds' (CPU), 'extrapolated', 'meetsTolerance', 'meetsBudget',
        'reasons' (sentences), 'tried' (list of dicts, one a pilot, with 'label', 'formulation', 'integrator',
        'numberOfElements', 'stepSize' [s], 'massScaling', 'seconds' (CPU), 'error' and 'failure') and
        'pilotSeconds' (CPU, of these).

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
    given: AdviceSettings = settings_of(AdviceSettings, "settings", settings)
    return _Session(build, tolerance, end_time, limit, given).result()


class _Session:
    """One piece of advice: all that was tried, and the reasons so far."""

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
        self._problem = PilotRuns(
            build, settings.buildConventional, end_time, period, settings.dependsOnTimeOnly
        )
        self._reasons: list[str] = []
        self._search = self._survey()

    def _survey(self) -> Search:
        """Explicit runs of the present formulation on finer and finer meshes."""
        settings = self._settings
        search = survey_meshes(
            self._problem, self._tolerance, settings.numbersOfElements, settings.pilotBudget
        )
        self._reasons.append(convergence_sentence(search))
        return search

    def result(self) -> dict[str, Any]:
        """See `Advise`."""
        self._add_stretch()
        try_families(self._problem, self._search)
        self._add_candidates()
        advised = self._search.best
        if advised is None:
            advised = self._extrapolated()
        advised = self._within_budget(advised) or advised
        choice, tried = advised.choice, self._search.tried
        is_extrapolated = advised not in tried
        if is_extrapolated:
            said = f"{choice.label}: error and CPU time are extrapolated from coarser meshes."
        else:
            said = choice_sentence(advised, self._tolerance)
        if self._problem.has_step_functions:
            self._reasons.append(step_function_sentence(self._problem.samples))
        explicit = None if choice.is_conventional else self._problem.explicit_settings(choice)
        stretches = choice.formulation == EXTENSIBLE
        constraints = self._problem.length_constraints if explicit and not stretches else {}
        return AdviceReport(
            {
                "formulation": choice.formulation,
                "axialStiffness": self._settings.axialStiffness if stretches else None,
                "dimension": self._problem.dimension,
                "numberOfElements": choice.elements,
                "numberOfLengthConstraints": constraints.get(choice.elements),
                "integrator": choice.integrator,
                "stepSize": choice.step_size,
                "stabilizationRate": explicit.stabilizationRate if explicit else None,
                "massScaling": choice.mass_scaling,
                "explicitSettings": explicit,
                "predictedError": advised.error,
                "predictedSeconds": advised.seconds,
                "extrapolated": is_extrapolated,
                "meetsTolerance": advised.error <= self._tolerance,
                "meetsBudget": advised.seconds <= self._budget,
                "reasons": [said, *self._reasons],
                "tried": [_row(pilot) for pilot in tried],
                "pilotSeconds": sum(pilot.seconds for pilot in tried),
            }
        )

    def _add_stretch(self) -> None:
        """The finest run once more, of cables that stretch; if that matters, survey these as well."""
        stiffness, rigid = self._settings.axialStiffness, self._search
        if stiffness is None or self._problem.formulation == EXTENSIBLE:
            return
        stretching, elements = self._problem.stretching(stiffness), rigid.finest.choice.elements
        step = min(rigid.finest.choice.step_size, stretching.step_limit(elements, INTEGRATOR))
        pilot = stretching.run(Choice(EXTENSIBLE, INTEGRATOR, elements, step))
        if pilot.failure:
            self._reasons.append(f"What stretch moves is not known: {pilot.failure}")
            return
        rigid.leave_out(pilot)
        moved = rigid.left_out
        matters = moved > (1.0 - SHARE_OF_TOLERANCE) * self._tolerance  # the mesh has its share of it
        self._reasons.append(stretch_sentence(stiffness, moved, self._tolerance, matters))
        if matters:
            self._problem = stretching
            self._search = self._survey()
            self._search.tried += rigid.tried
            self._reasons.append(cost_sentence(rigid, self._search))

    def _add_candidates(self) -> None:
        """Conventional runs, among what was tried."""
        if self._settings.buildConventional is None:
            return
        search = self._search
        best = search.best
        most = LENIENCE * best.seconds if best else self._settings.pilotBudget
        candidates = climb(self._problem, [pilot.choice.elements for pilot in search.meshes], most)
        for pilot in candidates:
            search.compare_with_finest(pilot)
        good = [pilot for pilot in candidates if pilot in search.good]
        candidates += coarsen(self._problem, search, good[0]) if good else []
        if candidates:
            self._reasons.append(candidate_sentence(candidates, best, self._tolerance))

    def _within_budget(self, advised: Pilot) -> Pilot | None:
        """What replaces a run; None if that is within the budget, or no pilot is."""
        if advised.seconds <= self._budget:
            return None
        found = most_accurate(self._search.tried, self._budget)
        if found is None:
            self._reasons.append(f"No pilot took less than the budget of {self._budget:g} s.")
            return None
        self._reasons.append(
            f"The tolerance needs {advised.seconds:.2g} s, more than the budget of {self._budget:g} s: "
            "the most accurate run within the budget is advised."
        )
        return found

    def _extrapolated(self) -> Pilot:
        """What a run on a finer mesh is expected to give."""
        search = self._search
        choice = extrapolated(self._problem, search, self._tolerance)
        if choice is None:
            raise InputError(
                f"tolerance = {self._tolerance:g}: the pilots resolve {search.uncertainty:.2g} at best "
                f"({search.finest.choice.label}), too far from it to extrapolate: give a larger "
                "pilotBudget, finer numbersOfElements, or a larger tolerance."
            )
        seconds = predicted_seconds(search.meshes, choice, self._problem.end_time)
        steps = round(self._problem.end_time / choice.step_size)
        error = expected_error(search, choice)
        return Pilot(choice, search.finest.values, seconds, steps, error=error)


def _row(pilot: Pilot) -> dict[str, Any]:
    return {
        "label": pilot.choice.label,
        "formulation": pilot.choice.formulation,
        "integrator": pilot.choice.integrator,
        "numberOfElements": pilot.choice.elements,
        "stepSize": pilot.choice.step_size,
        "massScaling": pilot.choice.mass_scaling,
        "seconds": pilot.seconds,
        "error": pilot.error,
        "failure": pilot.failure,
    }
