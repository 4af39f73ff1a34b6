"""Conventional cables with an implicit integrator: whether they do better."""

from collections.abc import Sequence

from .pilot import CONVENTIONAL, Choice, Pilot, Problem

INTEGRATOR = "generalizedAlpha"
REFINEMENT = 0.5  # of the step from one mesh to the next; the coarsest one takes the sample period
ORDER = 2
LENIENCE = 2.0  # times the cost of the best inextensible run, that a rung is expected to cost at most


def climb(problem: Problem, meshes: Sequence[int], most: float) -> list[Pilot]:
    """Refine mesh and step together, as long as the next run is not expected to be too expensive.

    Args:
        problem: to be run; it can build conventional cables.   meshes: numbers of elements.
        most: CPU time of a run [s].
    """
    pilots: list[Pilot] = []
    for rung, elements in enumerate(meshes):
        step = problem.period * REFINEMENT**rung
        if pilots and _expected_seconds(pilots[-1], elements, step) > most:
            break
        pilots.append(problem.run(Choice(CONVENTIONAL, INTEGRATOR, elements, step)))
    return pilots


def _expected_seconds(last: Pilot, elements: int, step: float) -> float:
    return last.seconds * elements / last.choice.elements * last.choice.step_size / step


def judge_by_themselves(pilots: Sequence[Pilot]) -> list[Pilot]:
    """Where cables stretch, the inextensible solution is no judge: the finest conventional one is.

    It has half the step of the next coarser one; with the second order of the scheme, its own error is a
    third of what separates them. Returns those that reached their end, if there are two at least.
    """
    runs = [pilot for pilot in pilots if pilot.works]
    if len(runs) < 2:
        return []
    uncertainty = runs[-1].distance(runs[-2]) / (REFINEMENT**-ORDER - 1.0)
    for pilot in runs:
        pilot.error = uncertainty + pilot.distance(runs[-1])
    return runs
