"""States on the constraint manifold near given ones, which may be far from it."""

import numpy as np

from ..arrays import Array
from .saddle_point import factorise, solve
from .static_system import StaticSystem

LARGEST_TURN = 0.4  # of a slope in one step [-]
PROJECTIONS = 100
SMALLEST_STEP = 1e-6
LEFT = 0.1


def feasible(potential: StaticSystem, q: Array, tolerance: float) -> tuple[Array, float]:
    """q moved onto the constraints, and what is left of their largest violation.

    Newton's method with steps that are smallest in the metric of mass and bending, shortened until the
    sum of squares falls. The Jacobian is kept as long as a step leaves less than `LEFT` of the violation.
    """
    values, factor = potential.values(q), None
    for _ in range(PROJECTIONS):
        if float(np.abs(values).max(initial=0.0)) <= tolerance:
            break
        try:
            factor = factor or factorise(potential.metric, potential.jacobian(q))
        except RuntimeError:  # constraints depend on each other here
            break
        step = solve(factor, np.zeros(q.size), -values)[0].reshape(q.shape)
        size = cautious(potential, step)
        while size > SMALLEST_STEP:
            trial = potential.values(q + size * step)
            if trial @ trial < values @ values:
                break
            size *= 0.5
        else:
            break
        factor = factor if trial @ trial < LEFT**2 * (values @ values) else None
        q, values = q + size * step, trial
    return q, float(np.abs(values).max(initial=0.0))


def cautious(potential: StaticSystem, step: Array) -> float:
    """How much of a step turns no slope and no body by more than `LARGEST_TURN`."""
    return min(1.0, LARGEST_TURN / max(potential.turn(step), 1e-300))
