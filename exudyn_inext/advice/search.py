"""The cheapest choice that is accurate enough: candidates are tried in the order of their expected cost."""

import math
from collections.abc import Iterator, Sequence

from ..errors import InputError
from .cost import predicted_seconds
from .pilot import EXTENSIBLE, Choice, Pilot, Problem
from .survey import INTEGRATOR as SURVEYOR
from .survey import Search

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


def try_families(problem: Problem, search: Search) -> None:
    """Try all families that could be cheaper than the best so far, cheapest first."""
    if search.uncertainty + search.left_out > search.tolerance:
        return
    waiting = list(dict.fromkeys(_candidates(problem, search)))  # without duplicates, in a fixed order
    while waiting:
        pilots = [pilot for pilot in search.tried if pilot.works]
        expected = {choice: predicted_seconds(pilots, choice, problem.end_time) for choice in waiting}
        choice = min(waiting, key=expected.__getitem__)
        if search.best and expected[choice] > NO_CHEAPER * search.best.seconds:
            break
        waiting.remove(choice)
        search.compare_with_finest(problem.run(choice))


def _candidates(problem: Problem, search: Search) -> Iterator[Choice]:
    for pilot in search.tried:
        if pilot.error > HOPELESS * search.tolerance:
            continue
        elements = pilot.choice.elements
        for integrator, theta, share in FAMILIES:
            if problem.formulation == EXTENSIBLE and integrator != SURVEYOR:
                continue  # only RATTLE takes axial stiffness
            limit = problem.step_limit(elements, "RATTLE" if theta else integrator)
            step = min(share * limit, problem.period)
            yield Choice(problem.formulation, integrator, elements, step, theta)


def extrapolated(problem: Problem, search: Search, tolerance: float) -> Choice | None:
    """The mesh that would be accurate enough; None if it is too far from those that were tried.

    The step keeps its share of the limit, which falls with N^2.
    """
    last = search.finest.choice
    ratio = max(1.0, (SAFETY * search.uncertainty / (tolerance - search.left_out)) ** (1.0 / _order(search)))
    if ratio > FINEST_EXTRAPOLATION:
        return None
    elements = _buildable(problem, math.ceil(last.elements * ratio))
    if elements is None:
        return None
    step = last.step_size * (last.elements / elements) ** 2
    return Choice(last.formulation, last.integrator, elements, step)


def _buildable(problem: Problem, least: int) -> int | None:
    """Smallest number of elements from `least` on that can be built; None: none up to twice as many."""
    for elements in range(least, 2 * least + 1):
        try:
            problem.step_limit(elements, SURVEYOR)
        except InputError:
            continue
        return elements
    return None


def expected_error(search: Search, choice: Choice) -> float:
    """Of the extrapolated choice."""
    ratio = search.finest.choice.elements / choice.elements
    return search.left_out + search.uncertainty * ratio ** _order(search)


def _order(search: Search) -> float:
    """That an extrapolation relies on."""
    return min(search.order, HIGHEST_ORDER)


def most_accurate(tried: Sequence[Pilot], budget: float) -> Pilot | None:
    """Of all that cost no more than the budget [s]."""
    affordable = [pilot for pilot in tried if pilot.works and pilot.seconds <= budget]
    return min(affordable, key=lambda pilot: pilot.error, default=None)
