"""Conventional cables with an implicit integrator: whether they do better."""

from collections.abc import Sequence
from dataclasses import replace

from .pilot import CONVENTIONAL, Choice, Pilot, Problem
from .survey import Search

INTEGRATOR = "generalizedAlpha"
REFINEMENT = 0.5  # of the step from one mesh to the next; the coarsest one takes the sample period
FEWEST_STEPS = 8  # of a run
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
        if pilots and pilots[-1].expected_seconds(elements, step) > most:
            break
        pilots.append(problem.run(Choice(CONVENTIONAL, INTEGRATOR, elements, step)))
    return pilots


def coarsen(problem: Problem, search: Search, pilot: Pilot) -> list[Pilot]:
    """Longer and longer steps of the same mesh, as long as they are accurate enough.

    Args:
        problem: to be run.   search: what they are compared with.   pilot: the shortest of these steps.
    """
    pilots: list[Pilot] = []
    step = pilot.choice.step_size / REFINEMENT
    while pilot in search.good and problem.end_time >= FEWEST_STEPS * step:
        pilot = problem.run(replace(pilot.choice, step_size=step))
        search.compare_with_finest(pilot)
        pilots.append(pilot)
        step /= REFINEMENT
    return pilots
