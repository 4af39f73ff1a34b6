"""States on the constraint manifold near given ones, which may be far from it."""

import numpy as np

from ..arrays import Array
from .potential import Potential
from .saddle_point import factorise, solve

LARGEST_TURN = 0.4  # of a slope in one step [-]
PROJECTIONS = 100
BOW = 0.3  # slope at the ends of the sag that a taut start is given [-]
SMALLEST_STEP = 1e-6


def feasible(potential: Potential, q: Array, tolerance: float) -> tuple[Array, float]:
    """q moved onto the constraints, and what is left of their largest violation.

    Newton's method with steps that are smallest in the metric of mass and bending, shortened until the
    sum of squares falls.
    """
    values = potential.values(q)
    for _ in range(PROJECTIONS):
        if float(np.abs(values).max(initial=0.0)) <= tolerance:
            break
        try:
            factor = factorise(potential.metric, potential.jacobian(q))
        except RuntimeError:  # constraints depend on each other here
            break
        step = solve(factor, np.zeros(q.size), -values)[0].reshape(q.shape)
        size = cautious(step)
        while size > SMALLEST_STEP:
            trial = potential.values(q + size * step)
            if trial @ trial < values @ values:
                break
            size *= 0.5
        else:
            break
        q, values = q + size * step, trial
    return q, float(np.abs(values).max(initial=0.0))


def bowed(potential: Potential, q: Array) -> Array:
    """q with a sag towards the loads, or anywhere: on a straight line no step makes a cable longer."""
    arc = np.append(0.0, np.cumsum(potential.cable.element_lengths)) * np.pi / potential.cable.length
    chord = q[-1, 0] - q[0, 0]
    chord = chord / max(float(np.linalg.norm(chord)), 1e-300)
    candidates = np.stack([potential.total_force, *np.eye(q.shape[2])])
    across = candidates - np.outer(candidates @ chord, chord)
    sizes = np.linalg.norm(across, axis=1)
    chosen = 0 if sizes[0] > 1e-6 * potential.largest_load else 1 + int(np.argmax(sizes[1:]))
    sag = BOW * potential.cable.length / np.pi * across[chosen] / sizes[chosen]
    bowed = q.copy()
    bowed[:, 0] += np.outer(np.sin(arc), sag)
    bowed[:, 1] += np.outer(np.cos(arc), sag * np.pi / potential.cable.length)
    return bowed


def cautious(step: Array) -> float:
    """How much of a step turns no slope by more than `LARGEST_TURN`."""
    return min(1.0, LARGEST_TURN / max(float(np.abs(step[:, 1]).max()), 1e-300))
