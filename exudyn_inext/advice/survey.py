"""Solutions on finer and finer meshes, until the finest one can judge the others."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import InputError, SceneError
from .convergence import observed_order, remaining_error
from .pilot import INEXTENSIBLE, Choice, Pilot, Problem

INTEGRATOR = "RATTLE"
SHARE_OF_LIMIT = 0.5
SHARE_OF_TOLERANCE = 0.2  # the finest solution is that much better than what it has to judge
CAUTION = 3.0  # the finest meshes count as of no higher order, which luck may feign


@dataclass(frozen=True, eq=False)
class Survey:
    """Pilots of one integrator on finer and finer meshes.

    order: observed.   uncertainty: error of the last one.   failed: those that did not reach their end.
    """

    pilots: list[Pilot]
    order: float
    uncertainty: float
    failed: Sequence[Pilot] = ()

    @property
    def finest(self) -> Pilot:
        return self.pilots[-1]


def survey_meshes(problem: Problem, tolerance: float, numbers: Sequence[int], budget: float) -> Survey:
    """Refine until the finest solution is good to a fifth of the tolerance, or the budget is used up.

    Args:
        problem: to be run.   tolerance: in units of what is observed.
        numbers: of elements to try, increasing; those that the scene cannot be built with are left out.
        budget: CPU time for these pilots [s].

    Raises:
        InputError: fewer than three of the numbers can be built and run.
        SceneError: the solutions do not converge.
    """
    pilots: list[Pilot] = []
    failed: list[Pilot] = []
    spent, refused = 0.0, ""
    found: tuple[float, float] | None = None  # order and uncertainty
    for elements in numbers:
        try:
            limit = problem.step_limit(elements, INTEGRATOR)
        except InputError as error:
            refused = str(error)
            continue
        if len(pilots) >= 3 and spent + _seconds_of_next(pilots, elements, problem, limit) > budget:
            break
        pilot = problem.run(Choice(INEXTENSIBLE, INTEGRATOR, elements, _step(problem, limit)))
        spent += pilot.seconds
        if pilot.failure:
            failed.append(pilot)
            refused = pilot.failure
            continue
        pilots.append(pilot)
        found = _convergence(pilots)
        if found and found[1] <= SHARE_OF_TOLERANCE * tolerance:
            break
    if len(pilots) < 3:
        raise InputError(
            f"only {len(pilots)} of numbersOfElements = {tuple(numbers)} could be run, at least 3 must: "
            f"{refused} Give more, or finer ones."
        )
    if found is None:
        raise SceneError(_not_converged(pilots))
    return Survey(pilots, *found, failed)


def _step(problem: Problem, limit: float) -> float:
    return min(SHARE_OF_LIMIT * limit, problem.period)


def _seconds_of_next(pilots: Sequence[Pilot], elements: int, problem: Problem, limit: float) -> float:
    last = pilots[-1]
    steps = problem.end_time / _step(problem, limit)
    return last.seconds * steps / last.steps * elements / last.choice.elements


def _convergence(pilots: Sequence[Pilot]) -> tuple[float, float] | None:
    """Order and error of the last pilot; None if the last three do not converge."""
    if len(pilots) < 3:
        return None
    numbers = [pilot.choice.elements for pilot in pilots[-3:]]
    coarse, middle, fine = pilots[-3:]
    differences = coarse.distance(middle), middle.distance(fine)
    order = observed_order(numbers, differences)
    if order is None:
        return None
    return order, remaining_error(numbers[1], numbers[2], differences[1], min(order, CAUTION))


def _not_converged(pilots: Sequence[Pilot]) -> str:
    coarse, middle, fine = pilots[-3:]
    numbers = [pilot.choice.elements for pilot in (coarse, middle, fine)]
    return (
        f"solutions with {numbers[0]}, {numbers[1]} and {numbers[2]} elements do not converge: they differ "
        f"by {coarse.distance(middle):.2g} and {middle.distance(fine):.2g}. The motion may depend on the "
        "smallest disturbances: shorten endTime, observe something less sensitive, or give finer "
        "numbersOfElements and a larger pilotBudget."
    )
