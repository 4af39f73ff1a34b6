"""Solutions on finer and finer meshes, until the finest one can tell the error of the others."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from ..errors import InputError, SceneError
from .pilot import Choice, Pilot, Problem

ORDERS = (0.5, 8.0)


def observed_order(elements: Sequence[int], differences: Sequence[float]) -> float | None:
    """p of errors C N^-p, from solutions on three meshes; None if they do not converge.

    |x_0 - x_1| / |x_1 - x_2| = (N_0^-p - N_1^-p) / (N_1^-p - N_2^-p); larger orders than 8 count as 8.

    Args:
        elements: N_0 < N_1 < N_2.   differences: |x_0 - x_1| and |x_1 - x_2|, in the same norm.

    Source: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911), 307-357; P. J. Roache, J. Fluids Eng. 116
    (1994), 405-413.
    """
    coarse, fine = differences
    if not np.isfinite(differences).all():
        return None
    if fine == 0.0:
        return ORDERS[1]
    n0, n1, n2 = elements

    def excess(p: float) -> float:
        return float((n0**-p - n1**-p) / (n1**-p - n2**-p) - coarse / fine)

    if excess(ORDERS[0]) > 0.0:
        return None
    if excess(ORDERS[1]) < 0.0:
        return ORDERS[1]
    return float(scipy.optimize.brentq(excess, *ORDERS))


def remaining_error(coarse: int, fine: int, difference: float, order: float) -> float:
    """Error of the finer of two solutions that converge with that order.

    Args:
        coarse, fine: numbers of elements.   difference: of the solutions.   order: p of C N^-p.
    """
    return difference * fine**-order / (coarse**-order - fine**-order)


INTEGRATOR = "RATTLE"
SHARE_OF_LIMIT = 0.5
SHARE_OF_TOLERANCE = 0.2  # the finest solution is that much better than what it is compared with
CAUTION = 3.0  # the finest meshes count as of no higher order, which luck may feign


@dataclass(eq=False)
class Search:
    """All that was tried, and what the finest mesh says of it.

    tolerance: in units of what is observed.
    meshes: pilots of one integrator on finer and finer meshes; the last one is the reference.
    order: observed.   uncertainty: error of the last mesh.   tried: all pilots.
    stretching: the finest mesh once more, with axial stiffness that all others leave out.
    """

    tolerance: float
    meshes: list[Pilot]
    order: float
    uncertainty: float
    tried: list[Pilot] = field(default_factory=list)
    stretching: Pilot | None = None

    @property
    def finest(self) -> Pilot:
        return self.meshes[-1]

    @property
    def good(self) -> list[Pilot]:
        """Those within the tolerance."""
        return [pilot for pilot in self.tried if pilot.works and pilot.error <= self.tolerance]

    @property
    def best(self) -> Pilot | None:
        """The cheapest one within the tolerance, or None."""
        return min(self.good, key=lambda pilot: pilot.seconds, default=None)

    def compare_with_finest(self, pilot: Pilot) -> None:
        """Add a pilot, compared with the finest solution."""
        if pilot.works:
            pilot.error = self.uncertainty + self._distance(pilot)
        self.tried.append(pilot)

    def _distance(self, pilot: Pilot) -> float:
        if self.stretching and pilot.choice.is_conventional:
            return pilot.distance(self.stretching)
        return self.left_out + pilot.distance(self.finest)

    @property
    def left_out(self) -> float:
        """What stretch moves, where the cables have none."""
        return self.stretching.distance(self.finest) if self.stretching else 0.0

    def leave_out(self, stretching: Pilot) -> None:
        """Let all errors contain what stretch moves.   stretching: see above."""
        self.stretching = stretching
        for pilot in self.tried:
            pilot.error += self.left_out


def survey_meshes(problem: Problem, tolerance: float, numbers: Sequence[int], budget: float) -> Search:
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
    refused = ""
    found: tuple[float, float] | None = None  # order and uncertainty
    for elements in numbers:
        try:
            step = min(SHARE_OF_LIMIT * problem.step_limit(elements, INTEGRATOR), problem.period)
        except InputError as error:
            refused = str(error)
            continue
        spent = sum(pilot.seconds for pilot in pilots + failed)
        if len(pilots) >= 3 and spent + pilots[-1].expected_seconds(elements, step) > budget:
            break
        pilot = problem.run(Choice(problem.formulation, INTEGRATOR, elements, step))
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
    search = Search(tolerance, pilots, *found)
    for pilot in pilots + failed:
        search.compare_with_finest(pilot)
    return search


def _convergence(pilots: Sequence[Pilot]) -> tuple[float, float] | None:
    """Order and error of the last pilot; None if the last three do not converge."""
    if len(pilots) < 3:
        return None
    numbers, differences = _last_three(pilots)
    order = observed_order(numbers, differences)
    if order is None:
        return None
    return order, remaining_error(numbers[1], numbers[2], differences[1], min(order, CAUTION))


def _last_three(pilots: Sequence[Pilot]) -> tuple[list[int], tuple[float, float]]:
    """Their numbers of elements, and the distances between them."""
    coarse, middle, fine = pilots[-3:]
    numbers = [pilot.choice.elements for pilot in (coarse, middle, fine)]
    return numbers, (coarse.distance(middle), middle.distance(fine))


def _not_converged(pilots: Sequence[Pilot]) -> str:
    numbers, differences = _last_three(pilots)
    return (
        f"solutions with {numbers[0]}, {numbers[1]} and {numbers[2]} elements do not converge: they differ "
        f"by {differences[0]:.2g} and {differences[1]:.2g}. The motion may depend on the "
        "smallest disturbances: shorten endTime, observe something less sensitive, or give finer "
        "numbersOfElements and a larger pilotBudget."
    )
