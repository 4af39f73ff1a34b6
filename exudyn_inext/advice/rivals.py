"""Conventional cables with an implicit integrator: whether they do better."""

from collections.abc import Sequence

from .pilot import CONVENTIONAL, Choice, Pilot, Problem
from .survey import expected_seconds

INTEGRATOR = "generalizedAlpha"
REFINEMENT = 0.5  # of the step from one mesh to the next; the coarsest one takes the sample period
LENIENCE = 2.0  # times the cost of the best inextensible run, that a rung is expected to cost at most


def climb(problem: Problem, meshes: Sequence[int], most: float) -> list[Pilot]:
    """Refine mesh and step together, as long as the next run is not expected to be too expensive.

    Args:
        problem: to be run; it can build conventional cables.   meshes: numbers of elements.
        most: CPU time of a run [s].
    """
    pilots: list[Pilot] = []
    for rung, elements in enumerate(meshes):
        choice = Choice(CONVENTIONAL, INTEGRATOR, elements, problem.period * REFINEMENT**rung)
        if pilots and expected_seconds(pilots[-1], choice, problem) > most:
            break
        pilots.append(problem.run(choice))
    return pilots
