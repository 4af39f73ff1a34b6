"""Static equilibrium: a minimum of the potential energy on the constraint manifold.

Newton's method on the manifold: a step along it, found from the Hessian of the Lagrangian, is followed by
a projection onto the constraints; the energy must fall. Where the Hessian is not positive along the step,
some mass is added; where this does not help, a convex model takes its place: bending stiffness, the tension
where it is positive, some mass, and at first the stiffness of other items. So the search runs downhill to a
stable equilibrium, whether it starts taut, slack or upside down. A point where the constrained Hessian is not
positive definite is left along its worst direction.

The search goes on with the model that served last. The Hessian is tried before it, unless its steps have led
nowhere. Where the energy is concave, steps are longer than their model says.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import Array, SparseArray
from .feasible import LARGEST_TURN, NEARLY, cautious, feasible, followed, straight
from .saddle_point import factorise, solve
from .small_motions import SmallMotions, small_motions
from .stability import eigenvalue_without_potential, round_off, smallest_eigenvalue
from .static_system import StaticSystem

LARGEST_EXCURSION = 100.0  # of a coordinate from its start, in lengths of the longest cable
RESOLUTION = 1e-10  # gain of energy that round-off hides, relative
SHIFTS = (1e-4, 1e-3, 0.01, 0.1, 1.0, 10.0)  # of an indefinite Hessian, in units of the loads' own [-]
ESCAPES = (0.1, 0.01, 1e-3, 1e-4)  # turns of slopes and bodies beside an unstable equilibrium [-]
MOST_HALVINGS = 30  # of a step
CONCAVE = 0.75  # share of the slope by which a step falls that may be longer; its model says a half
POOR = 0.1  # share of a step that is left, after which softer models do not serve for a while
RELIEF = 2  # more of them that do after each other step
SHORT = 0.1  # of a step, which a softer model asks for: a more convex one knows better
GROWS = "all forces are balanced, but loads without a potential make small vibrations grow"
_ARMIJO = 1e-4


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """What the search found.

    q: last state.   multipliers: (m,) of the constraints.
    converged: whether it is a stable equilibrium.   message: why not.
    residual: largest force that is not balanced [N], moments over a length.
    violation: largest violation of a constraint [-, m].   iterations: steps taken.
    smallest_eigenvalue: of the constrained Hessian over the mass: the lowest frequency squared [1/s^2].
    """

    q: Array
    multipliers: Array
    converged: bool
    message: str
    residual: float
    violation: float
    iterations: int
    smallest_eigenvalue: float


class _Step(NamedTuple):
    """A descent direction along the constraints, and the energy's slope along it; it may be missing.

    multipliers: of the constraints, and what force they leave unbalanced.
    level: which of the models gave it.
    """

    direction: Array
    slope: float
    multipliers: Array
    residual: float
    level: int


def _step(potential: StaticSystem, q: Array, multipliers: Array, level: int, least: int) -> _Step:
    """multipliers, level: of the step before.   least: number of the first model that may serve."""
    jacobian, force = potential.jacobian(q), potential.force(q)
    zero, direction, slope, share = np.zeros(jacobian.shape[0]), np.zeros(q.size), 0.0, 0.0
    for number, model in _models(potential, q, multipliers, least, level - 1):
        try:
            step, new = solve(factorise(model, jacobian, potential.order), force, zero)
        except RuntimeError:  # singular
            continue
        fall = float((step * (model @ step)).sum())  # force @ step, but for round-off of jacobian @ step
        own = cautious(potential, step.reshape(q.shape))
        if np.isfinite(fall) and fall > 0.0 and own > share:
            direction, slope, multipliers, share, level = step, -fall, new, own, number
            if share > SHORT:
                break
        elif slope == 0.0 and np.isfinite(new).all():  # balanced forces have no direction, but tension
            multipliers = new
    return _Step(direction, slope, multipliers, potential.size(force - jacobian.T @ multipliers), level)


def _models(
    potential: StaticSystem, q: Array, multipliers: Array, least: int, then: int
) -> Iterator[tuple[int, SparseArray]]:
    """The Hessian, then what is more and more convex, with their numbers.

    least: of the first one.   then: of those after it.
    """
    exact = potential.hessian(q, multipliers, is_rough=True)
    if not least:
        yield 0, exact
    for number, factor in enumerate(SHIFTS, 1):
        if number >= max(least, then):
            yield number, exact + factor * potential.shift * potential.mass
    convex = potential.convex_model(multipliers, potential.shift)
    if potential.of_others is not None:  # without stiffness of contacts, steps run far into these
        yield len(SHIFTS) + 1, convex + potential.of_others
    yield len(SHIFTS) + 2, convex


def _line_search(
    potential: StaticSystem, q: Array, direction: Array, slope: float
) -> tuple[Array | None, float]:
    """The next state on the constraints with less energy; None if there is none along the step.

    And how much of the step that may be taken leads there. Close to the equilibrium, where round-off hides
    the gain of energy, Newton's step is trusted.
    """
    step = direction.reshape(q.shape)
    size = whole = cautious(potential, step)
    follow = followed if size > SHORT else straight
    is_resolved = -slope > RESOLUTION * potential.scale_of_energy(q)

    def found(size: float, share: float) -> Array | None:
        """The state after so much of the step; None: there is none, or it falls by less than that share."""
        trial, left = follow(potential, q, size * step)
        falls = not is_resolved or potential.fall(q, trial) >= -share * size * slope
        return trial if left <= NEARLY and falls and not potential.is_blocked(q, trial) else None

    for _ in range(MOST_HALVINGS):
        trial = found(size, _ARMIJO)
        if trial is not None:
            break
        size *= 0.5
    while trial is not None and is_resolved and 2.0 * size * potential.turn(step) <= LARGEST_TURN:
        further = found(2.0 * size, CONCAVE)
        if further is None:
            break
        trial, size = further, 2.0 * size
    return trial, size / whole


def find_equilibrium(
    potential: StaticSystem, start: Array, tolerance: float = 1e-9, most: int = 500
) -> Equilibrium:
    """The stable equilibrium that lies downhill of `start`.

    Args:
        potential: what moves, its loads and constraints.
        start: coordinates, not necessarily on the constraints.
        tolerance: of the residual, relative to the largest force on the cable [-].
        most: iterations.
    """
    potential.turn_with(start)
    q, violation = feasible(potential, start)
    if violation > NEARLY:
        q, violation = feasible(potential, potential.bowed(start))
    multipliers, first = np.zeros(len(potential.values(q))), q
    if violation > NEARLY:
        message = "the constraints cannot be met"
        return Equilibrium(q, multipliers, False, message, np.inf, violation, 0, np.nan)
    limit = tolerance * potential.largest_load
    balanced = max(1e3 * limit, potential.round_off)
    message, eigenvalue, residual = "", np.nan, np.inf
    iterations, level, least, about = 0, 0, 0, None
    while iterations < most:
        iterations += 1
        potential.turn_with(q)
        previous, following = residual, None
        direction, slope, multipliers, residual, level = _step(potential, q, multipliers, level, least)
        is_stalled = -slope < RESOLUTION**2 * potential.largest_load * potential.length
        is_stalled |= residual < potential.round_off
        if residual > limit and slope < 0.0 and not (is_stalled and residual > 0.5 * previous):
            following, share = _line_search(potential, q, direction, slope)
            least = min(level + 1, len(SHIFTS)) if share < POOR else max(least - RELIEF, 0)
        if following is None:
            about = small_motions(potential, q, multipliers)
            eigenvalue, worst, message = _stability(about, residual <= balanced)
            following = None if message else _escape(potential, q, worst, eigenvalue)
        if following is None:
            break
        q = following
        if potential.excursion(q - first) > LARGEST_EXCURSION * potential.length:
            message = "it runs away: its loads are not balanced by anything that holds it"
            break
    is_stable = eigenvalue > potential.indifferent or (about and eigenvalue > -round_off(about))
    converged = bool(residual <= balanced and is_stable and not message)
    if not converged and not message:
        message = "no stable equilibrium within reach"
    violation = float(np.abs(potential.values(q)).max(initial=0.0))
    return Equilibrium(q, multipliers, converged, message, residual, violation, iterations, eigenvalue)


def _stability(about: SmallMotions, is_balanced: bool) -> tuple[float, Array, str]:
    """The smallest eigenvalue, its vector, and why no search goes on from here; empty if one may."""
    eigenvalue, worst = smallest_eigenvalue(about)
    if not is_balanced or not eigenvalue < about.system.indifferent:
        return eigenvalue, worst, ""
    true = eigenvalue_without_potential(about, eigenvalue)
    return (eigenvalue, worst, GROWS) if true.imag else (true.real, worst, "")


def _escape(potential: StaticSystem, q: Array, worst: Array, eigenvalue: float) -> Array | None:
    """A state with less energy beside an unstable equilibrium; None if it is stable."""
    if not eigenvalue < potential.indifferent:
        return None
    direction = worst / max(potential.turn(worst.reshape(q.shape)), 1e-300)
    trials = []
    for size in (sign * turn for turn in ESCAPES for sign in (1.0, -1.0)):
        trial, left = followed(potential, q, size * direction.reshape(q.shape))
        if left <= NEARLY and not potential.is_blocked(q, trial):
            trials.append((potential.fall(q, trial), trial))
    fall, best = max(trials, key=lambda pair: pair[0], default=(0.0, q))
    return best if fall > 0.0 else None
