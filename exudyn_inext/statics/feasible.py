"""States on the constraint manifold near given ones, which may be far from it."""

import numpy as np

from ..arrays import Array, SparseArray
from ..sparse import one_below_another
from .saddle_point import factorise, solve
from .static_system import StaticSystem

LARGEST_TURN = 0.4  # of a slope in one step [-]
PROJECTIONS = 100
FEW = 15  # after a step, which may be shortened
SMALLEST_STEP = 1e-6
LEFT = 0.1
FEASIBLE = 1e-12  # violation of constraints [-, m]
NEARLY = 1e3 * FEASIBLE  # where round-off allows no less


class WithStrains:
    """A system whose strains are constrained, too: to those that a step from q foresees.

    A stiff cable would resist what a straight step stretches it by when it turns.
    """

    def __init__(self, potential: StaticSystem, q: Array, step: Array) -> None:
        self._potential, self.metric, self.turn = potential, potential.metric, potential.turn
        self.order = potential.order
        self._foreseen = potential.strains(q) + potential.strain_rows(q) @ step.ravel()

    def values(self, q: Array) -> Array:
        """(m + k,)"""
        return np.append(self._potential.values(q), self._potential.strains(q) - self._foreseen)

    def jacobian(self, q: Array) -> SparseArray:
        """(m + k, n)"""
        return one_below_another([self._potential.jacobian(q), self._potential.strain_rows(q)])


def followed(potential: StaticSystem, q: Array, step: Array) -> tuple[Array, float]:
    """`feasible` after a step from q, with the strains that it foresees where these can be."""
    if len(potential.strains(q)):
        found = feasible(WithStrains(potential, q, step), q + step, FEW)
        if found[1] <= NEARLY:
            return found
    return straight(potential, q, step)


def straight(potential: StaticSystem, q: Array, step: Array) -> tuple[Array, float]:
    """`feasible` after a step from q."""
    return feasible(potential, q + step, FEW)


def feasible(
    potential: StaticSystem | WithStrains,
    q: Array,
    most: int = PROJECTIONS,
    tolerance: float = FEASIBLE,
) -> tuple[Array, float]:
    """q moved onto the constraints, and what is left of their largest violation.

    Newton's method with steps that are smallest in the metric of mass and bending, shortened until the
    sum of squares falls. The Jacobian is kept as long as a step leaves less than `LEFT` of the violation.
    Where steps must still be shortened after half of them, there is no way back.
    """
    values, factor = potential.values(q), None
    for attempt in range(most):
        if float(np.abs(values).max(initial=0.0)) <= tolerance:
            break
        try:
            factor = factor or factorise(potential.metric, potential.jacobian(q), potential.order)
        except RuntimeError:  # constraints depend on each other here
            break
        step = solve(factor, np.zeros(q.size), -values)[0].reshape(q.shape)
        size = whole = cautious(potential, step)
        while size > SMALLEST_STEP:
            trial = potential.values(q + size * step)
            if _square(trial) < _square(values):
                break
            size *= 0.5
        else:
            break
        if size < whole and attempt >= most // 2:
            break
        factor = factor if _square(trial) < LEFT**2 * _square(values) else None
        q, values = q + size * step, trial
    return q, float(np.abs(values).max(initial=0.0))


def _square(values: Array) -> float:
    """Sum of squares; BLAS would keep other cores awake for it."""
    return float(np.square(values).sum())


def cautious(potential: StaticSystem | WithStrains, step: Array) -> float:
    """How much of a step turns no slope and no body by more than `LARGEST_TURN`."""
    return min(1.0, LARGEST_TURN / max(potential.turn(step), 1e-300))
