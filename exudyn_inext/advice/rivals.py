"""Conventional cables with an implicit integrator: whether they do better."""

from collections.abc import Sequence

from .pilot import CONVENTIONAL, Choice, Pilot, Problem
from .search import Search, Tried
from .survey import Survey

INTEGRATOR = "generalizedAlpha"
REFINEMENT = 0.5  # of the step from one mesh to the next; the coarsest one takes the sample period
ORDER = 2
LENIENCE = 2.0  # times the cost of the best inextensible run, that a rung is expected to cost at most


def climb(problem: Problem, survey: Survey, most: float) -> list[Pilot]:
    """Refine mesh and step together, as long as the next run is not expected to be too expensive.

    Args:
        problem: to be run; it can build conventional cables.   survey: its meshes are taken.
        most: CPU time of a run [s].
    """
    pilots: list[Pilot] = []
    for rung, own in enumerate(survey.pilots):
        elements, step = own.choice.elements, problem.period * REFINEMENT**rung
        if pilots and _expected_seconds(pilots[-1], elements, step) > most:
            break
        pilots.append(problem.run(Choice(CONVENTIONAL, INTEGRATOR, elements, step)))
    return pilots


def _expected_seconds(last: Pilot, elements: int, step: float) -> float:
    return last.seconds * elements / last.choice.elements * last.choice.step_size / step


def judge_rivals(search: Search, pilots: Sequence[Pilot]) -> None:
    """Compare with the finest inextensible solution: what an inextensible user would call their error."""
    for pilot in pilots:
        search.add(pilot)


def judge_by_themselves(pilots: Sequence[Pilot]) -> list[Tried]:
    """Where cables stretch, the inextensible solution is no judge: the finest conventional one is.

    It has half the step of the next coarser one; with the second order of the scheme, its own error is a
    third of what separates them.
    """
    runs = [pilot for pilot in pilots if not pilot.failure]
    if len(runs) < 2:
        return []
    finest = runs[-1]
    uncertainty = finest.distance(runs[-2]) / (REFINEMENT**-ORDER - 1.0)
    return [
        Tried(pilot, uncertainty + (0.0 if pilot is finest else pilot.distance(finest))) for pilot in runs
    ]
