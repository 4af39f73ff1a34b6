"""The cheapest choice that is accurate enough: candidates are tried in the order of their expected cost."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from ..errors import InputError
from .cost import predicted_seconds
from .pilot import INEXTENSIBLE, Choice, Pilot, Problem
from .survey import INTEGRATOR as SURVEYOR
from .survey import Survey

# integrator, theta, step over the limit without mass scaling
FAMILIES = (
    ("RATTLE", 0.0, 1.0),
    ("Zhai", 0.0, 1.0),
    ("Zhai", 0.0, 0.5),
    ("RATTLE", 0.25, 2.0),
    ("RATTLE", 0.25, 4.0),
    ("Zhai", 0.3, 2.0),
    ("Zhai", 0.3, 4.0),
)
HOPELESS = 1.5  # times the tolerance: the error of a mesh for which no other step is tried
FINEST_EXTRAPOLATION = 4.0  # times the elements of the finest pilot
SAFETY = 1.5  # of an extrapolated error
NO_CHEAPER = 1.0 + 1e-9  # times the cost of the best: what is as cheap but for round-off is tried
HIGHEST_ORDER = 4.0  # that an extrapolation relies on


@dataclass(eq=False)
class Tried:
    """A pilot and its error, inclusive of the uncertainty of what it was compared with."""

    pilot: Pilot
    error: float

    @property
    def works(self) -> bool:
        return not self.pilot.failure


@dataclass(eq=False)
class Search:
    """All that was tried.   best: cheapest one within the tolerance, or None."""

    tolerance: float
    survey: Survey
    tried: list[Tried] = field(default_factory=list)

    @property
    def best(self) -> Tried | None:
        return min(self.good, key=lambda tried: tried.pilot.seconds, default=None)

    @property
    def good(self) -> list[Tried]:
        return [tried for tried in self.tried if tried.works and tried.error <= self.tolerance]

    def add(self, pilot: Pilot) -> Tried:
        """Judge a pilot against the finest solution."""
        error = float("inf")
        if not pilot.failure:
            finest = self.survey.finest
            error = self.survey.uncertainty + (0.0 if pilot is finest else pilot.distance(finest))
        self.tried.append(Tried(pilot, error))
        return self.tried[-1]


def search_inextensible(problem: Problem, survey: Survey, tolerance: float) -> Search:
    """Try all families that could be cheaper than the best so far, cheapest first."""
    search = Search(tolerance, survey)
    for pilot in (*survey.pilots, *survey.failed):
        search.add(pilot)
    if survey.uncertainty > tolerance:
        return search
    waiting = list(dict.fromkeys(_candidates(problem, search)))  # without duplicates, in a fixed order
    while waiting:
        pilots = [tried.pilot for tried in search.tried if tried.works]
        expected = {choice: predicted_seconds(pilots, choice, problem.end_time) for choice in waiting}
        choice = min(waiting, key=expected.__getitem__)
        if search.best and expected[choice] > NO_CHEAPER * search.best.pilot.seconds:
            break
        waiting.remove(choice)
        search.add(problem.run(choice))
    return search


def _candidates(problem: Problem, search: Search) -> Iterator[Choice]:
    for tried in list(search.tried):
        if tried.error > HOPELESS * search.tolerance:
            continue
        elements = tried.pilot.choice.elements
        for integrator, theta, share in FAMILIES:
            limit = problem.step_limit(elements, "RATTLE" if theta else integrator)
            step = min(share * limit, problem.period)
            yield Choice(INEXTENSIBLE, integrator, elements, step, theta)


def extrapolated(problem: Problem, survey: Survey, tolerance: float) -> Choice | None:
    """The mesh that would be accurate enough; None if it is too far from those that were tried.

    The step keeps its share of the limit, which falls with N^2.
    """
    last = survey.finest.choice
    ratio = max(1.0, (SAFETY * survey.uncertainty / tolerance) ** (1.0 / _order(survey)))
    if ratio > FINEST_EXTRAPOLATION:
        return None
    elements = _buildable(problem, math.ceil(last.elements * ratio))
    if elements is None:
        return None
    step = last.step_size * (last.elements / elements) ** 2
    return Choice(INEXTENSIBLE, last.integrator, elements, step)


def _buildable(problem: Problem, least: int) -> int | None:
    """Smallest number of elements from `least` on that can be built; None: none up to twice as many."""
    for elements in range(least, 2 * least + 1):
        try:
            problem.step_limit(elements, SURVEYOR)
        except InputError:
            continue
        return elements
    return None


def expected_error(survey: Survey, choice: Choice) -> float:
    """Of the extrapolated choice."""
    return survey.uncertainty * (survey.finest.choice.elements / choice.elements) ** _order(survey)


def _order(survey: Survey) -> float:
    """That an extrapolation relies on."""
    return min(survey.order, HIGHEST_ORDER)


def most_accurate(tried: Sequence[Tried], budget: float) -> Tried | None:
    """Of all that cost no more than the budget [s]."""
    affordable = [one for one in tried if one.works and one.pilot.seconds <= budget]
    return min(affordable, key=lambda one: one.error, default=None)
