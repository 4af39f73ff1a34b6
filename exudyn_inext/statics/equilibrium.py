"""Static equilibrium of a cable: a minimum of the potential energy on the constraint manifold.

Newton's method on the manifold: a step along it, found from the Hessian of the Lagrangian, is followed by
a projection onto the constraints; the energy must fall. Where the Hessian is not positive along the step,
some mass is added; where this does not help, a convex model takes its place: bending stiffness, the tension
where it is positive, and some mass. So the search runs downhill to a stable equilibrium, whether it starts
taut, slack or upside down. A point where the constrained Hessian is not positive definite is left along its
worst direction.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from .feasible import bowed, cautious, feasible
from .potential import Potential
from .saddle_point import factorise, solve
from .stability import smallest_eigenvalue

LARGEST_EXCURSION = 100.0  # of a node, in lengths of the cable: no equilibrium there
RESOLUTION = 1e-10  # gain of energy that round-off hides, relative
SHIFTS = (1.0, 10.0)  # of an indefinite Hessian, in units of the loads' own [-]
_ARMIJO = 1e-4


@dataclass(frozen=True)
class StaticOptions:
    """tolerance: of the residual, relative to the largest force on the cable [-].

    iterations: largest number of steps.   feasibility: of the constraints [-, m].
    """

    tolerance: float = 1e-9
    iterations: int = 500
    feasibility: float = 1e-12


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """What the search found.

    q: (n, 2, dim) last state.   converged: whether it is a stable equilibrium.   message: why not.
    residual: largest force that is not balanced [N], moments over the element length.
    violation: largest violation of a constraint [-, m].   iterations: steps taken.
    smallest_eigenvalue: of the constrained Hessian over the mass: the lowest frequency squared [1/s^2].
    """

    q: Array
    converged: bool
    message: str
    residual: float
    violation: float
    iterations: int
    smallest_eigenvalue: float


def _step(potential: Potential, q: Array, multipliers: Array, shift: float) -> tuple[Array, Array, float]:
    """A descent direction along the constraints, new multipliers, and the energy's slope along it."""
    jacobian, force = potential.jacobian(q), potential.force(q)
    exact = potential.hessian(q, multipliers)
    zero = np.zeros(jacobian.shape[0])
    shifted = [csr_array(exact + factor * shift * potential.mass) for factor in SHIFTS]
    for model in (exact, *shifted, potential.convex_model(multipliers, shift)):
        try:
            direction, new = solve(factorise(model, jacobian), force, zero)
        except RuntimeError:  # singular
            continue
        slope = -float(force @ direction)
        if np.isfinite(slope) and slope < 0.0:
            return direction, new, slope
        if np.isfinite(new).all():  # where forces are balanced there is no direction, but tension
            multipliers = new
    return np.zeros(q.size), multipliers, 0.0


def _line_search(
    potential: Potential, q: Array, direction: Array, slope: float, feasibility: float
) -> Array | None:
    """The next state on the constraints with less energy; None if there is none along the step.

    Close to the equilibrium, where round-off hides the gain of energy, Newton's step is trusted.
    """
    step = direction.reshape(q.shape)
    size = cautious(step)
    energy = potential.energy(q)
    is_resolved = -slope > RESOLUTION * (abs(energy) + potential.largest_load * potential.cable.length)
    for _ in range(30):
        trial, left = feasible(potential, q + size * step, feasibility)
        falls = not is_resolved or potential.energy(trial) <= energy + _ARMIJO * size * slope
        if left <= 1e3 * feasibility and falls:
            return trial
        size *= 0.5
    return None


def find_equilibrium(potential: Potential, start: Array, options: StaticOptions) -> Equilibrium:
    """The stable equilibrium that lies downhill of `start`.

    Args:
        potential: cable, loads, constraints.
        start: (n, 2, dim) coordinates, not necessarily on the constraints.
        options: tolerances.
    """
    potential.turn_with(start)
    q, violation = feasible(potential, start, options.feasibility)
    if violation > 1e3 * options.feasibility:
        q, violation = feasible(potential, bowed(potential, start), options.feasibility)
    if violation > 1e3 * options.feasibility:
        return Equilibrium(q, False, "the constraints cannot be met", np.inf, violation, 0, np.nan)
    multipliers = np.zeros(potential.jacobian(q).shape[0])
    shift = potential.largest_load / (potential.cable.section.mass_per_length * potential.cable.length**2)
    limit = options.tolerance * potential.largest_load
    message, eigenvalue, residual = "", np.nan, np.inf
    iterations = 0
    while iterations < options.iterations:
        iterations += 1
        potential.turn_with(q)
        direction, multipliers, slope = _step(potential, q, multipliers, shift)
        previous, residual = (
            residual,
            potential.size(potential.force(q) - potential.jacobian(q).T @ multipliers),
        )
        following = None
        is_stalled = -slope < RESOLUTION**2 * potential.largest_load * potential.cable.length
        if residual > limit and slope < 0.0 and not (is_stalled and residual > 0.5 * previous):
            following = _line_search(potential, q, direction, slope, options.feasibility)
        if following is None:
            eigenvalue, worst = smallest_eigenvalue(potential, q, multipliers)
            following = _escape(potential, q, worst, eigenvalue, options)
        if following is None:
            break
        q = following
        if np.abs(q).max() > LARGEST_EXCURSION * potential.cable.length:
            message = "the cable runs away: its loads are not balanced by anything that holds it"
            break
    converged = residual <= 1e3 * limit and eigenvalue > 0.0 and not message
    if not converged and not message:
        message = "no stable equilibrium within reach"
    violation = float(np.abs(potential.values(q)).max(initial=0.0))
    return Equilibrium(q, converged, message, residual, violation, iterations, eigenvalue)


def _escape(
    potential: Potential, q: Array, worst: Array, eigenvalue: float, options: StaticOptions
) -> Array | None:
    """A state with less energy beside an unstable equilibrium; None if it is stable."""
    if not eigenvalue < 0.0:
        return None
    direction = worst / max(float(np.abs(worst.reshape(q.shape)[:, 1]).max()), 1e-300)
    trials = []
    for size in (0.1, -0.1, 0.01, -0.01):
        trial, left = feasible(potential, q + size * direction.reshape(q.shape), options.feasibility)
        if left <= 1e3 * options.feasibility:
            trials.append((potential.energy(trial), trial))
    energy, best = min(trials, key=lambda pair: pair[0], default=(np.inf, q))
    return best if energy < potential.energy(q) else None
