"""What bounds the step of a coupled system: its fastest vibration and its strongest damping.

Both are eigenvalues of the constrained acceleration's derivatives, found by Arnoldi iteration on
differences of the system's own right-hand side: whatever acts on the parts takes part.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..called_system import Bound
from ..compiled import kernel
from ..system import accelerate_and_project

STEP = 1e-6  # of the differences [m, -, m/s, 1/s]
NO_JUMP = 1e-6  # share of the damping forces
NEGLIGIBLE = 1e-6  # damping over the frequency: less is round-off, and bounds no step
FIRST_LOOK, GROWTH = 8, 1.2  # steps of the iteration before its first test, and from one test to the next
FRESH = 0.1  # share of others beside what was the fastest, one of which may have become it
MOST_STEPS = 400  # of the iteration
ROUND_OFF = 1e-12
NO_STATES = slice(0, 0)
OF_LARGEST_STATE = 0.01  # within which decays of first order states are looked for
NO_SWING = 0.01  # share of an eigenvalue that its imaginary part has by round-off, at most
OVERDAMPED = 1e3  # damping over the frequency, beyond which a motion is a decay


class Accuracy(NamedTuple):
    """At which a search for an eigenvalue ends, as shares of it.

    residual: of its vector.   change: of the value, from one test to the next: residuals say little where
        vectors are hardly apart.
    """

    residual: float
    change: float


OF_DAMPING = Accuracy(1e-3, 1e-3)
OF_VIBRATIONS = Accuracy(3e-2, 3e-3)  # their root and their symmetry forgive more


class FastestRates(NamedTuple):
    """frequency: w_max [rad/s] of small vibrations.   damping: largest d [1/s] of v' = -d v.

    Zero means that nothing vibrates and nothing is damped; NaN that forces or accelerations are not finite.
    A frequency is at least d / `OVERDAMPED`, so that damping without stiffness bounds a step, too.
    """

    frequency: float
    damping: float


_Operator = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class AddedForces:
    """Forces -K dq - D v besides those of a system, dq from the configuration q.

    given: (n,) memory from which the system takes them.   stiffness, damping: products K x and D x (n,).
    """

    given: Array
    stiffness: _Operator
    damping: _Operator


def fastest_rates(
    system: Any,
    external: Array,
    q: Array,
    v: Array,
    kept: Array | None = None,
    added: AddedForces | None = None,
    states: slice = NO_STATES,
    in_motion: bool = False,
) -> FastestRates:
    """Of small motions about the configuration q (n,).   external: of the system, at present.

    kept: (2, n) memory of the fastest vibration and decay, from which a search in a scene that has changed a
        little starts; zero at first.
    added: what acts as well.   states: place of first order states in v, about which these motions are.

    The velocities v (n,) count where they pull cables tight, as in bodies that spin about each other;
    gyroscopic forces, which change with small velocities, do not. Friction that jumps where a velocity
    changes its sign has no rate: it makes no motion grow.
    """
    about = slice(None) if in_motion else states
    stiffness, damping, start = _operators(system, external, q, v, added, about)
    kept = np.zeros((2, len(start))) if kept is None else kept
    frequency = float(np.sqrt(_largest_eigenvalue(stiffness, start, 0.0, kept[0], OF_VIBRATIONS)))
    rate = _largest_eigenvalue(damping, start, NEGLIGIBLE * frequency, kept[1])
    return FastestRates(float(np.maximum(frequency, rate / OVERDAMPED)), rate)  # keeps a NaN


def _by_velocities(system: Any, external: Array, q: Array, v: Array) -> Callable[[Array, float], Array]:
    """(x, step) -> change of all accelerations along x (n,), by a central difference with that step."""
    evaluate = Bound(accelerate_and_project, system)

    def rates(v: Array) -> Array:
        result = np.zeros((2, len(v)))
        evaluate(external, q, v, 0.0, result[0], result[1])
        return result[0]

    return lambda x, step: np.asarray(rates(v + step * x) - rates(v - step * x)) / (2.0 * step)


def decay_of_states(system: Any, external: Array, q: Array, v: Array, states: slice) -> float:
    """Fastest decay [1/s] of first order states by themselves, as of oil that flows through a valve.

    Within a hundredth of the largest state: at the pressure of its tank, flow has no rate.
    Arguments: see `frequency_of_states`.
    """
    step = OF_LARGEST_STATE * float(np.abs(v[states]).max())
    if not step > 0.0:
        return 0.0
    return float(-_own_rates(_by_velocities(system, external, q, v), len(v), states, step).real.min())


def swings_of_states(system: Any, external: Array, q: Array, v: Array, states: slice) -> Array:
    """(2, n) frequencies [rad/s] and decays [1/s] of first order states that swing by themselves.

    As currents of a coil and a condenser. Arguments: see `frequency_of_states`.
    """
    step = max(OF_LARGEST_STATE * float(np.abs(v[states]).max()), STEP)
    rates = _own_rates(_by_velocities(system, external, q, v), len(v), states, step)
    swinging = rates[rates.imag > NO_SWING * np.abs(rates)]
    return np.stack([swinging.imag, -swinging.real])


def _own_rates(change: Callable[[Array, float], Array], size: int, states: slice, step: float) -> Array:
    """(n,) eigenvalues of y' by y [1/s], or NaN.   change: see `_by_velocities`.   size: of all."""
    columns = [change(np.eye(1, size, place)[0], step)[states] for place in range(states.start, states.stop)]
    known = np.isfinite(columns).all()
    return np.asarray(np.linalg.eigvals(columns) if known else np.full(len(columns), np.nan))


def frequency_of_states(system: Any, external: Array, q: Array, v: Array, states: slice) -> float:
    """Largest frequency [rad/s] of first order states that push on velocities, and are changed by them.

    As of oil under pressure: with v' = B y and y' = C v it is the root of the largest eigenvalue of -C B.
    states: their place in v.   Other arguments: see `fastest_rates`.
    """
    change, number = _by_velocities(system, external, q, v), states.stop - states.start
    product = np.zeros((number, number))
    for column, place in enumerate(range(states.start, states.stop)):
        push = change(np.eye(1, len(v), place)[0], STEP * max(1.0, abs(v[place])))
        push[states] = 0.0
        size = float(np.abs(push).max())
        if not np.isfinite(size):
            return math.nan
        if size > 0.0:
            product[:, column] = -size * change(push / size, STEP)[states]
    largest = np.linalg.eigvals(product).real.max() if np.isfinite(product).all() else math.nan
    return math.sqrt(_positive(float(largest)))


def _operators(
    system: Any,
    external: Array,
    q: Array,
    v: Array,
    added: AddedForces | None = None,
    states: slice = NO_STATES,
) -> tuple[_Operator, _Operator, Array]:
    """Derivatives of -a with respect to q and v, and where to start; all on the constraints.

    Arguments: see `fastest_rates`.
    """
    evaluate, nothing = Bound(accelerate_and_project, system), np.zeros(len(q))
    at_present = -added.damping(v) if added else 0.0
    at_rest = nothing.copy()
    at_rest[states] = v[states]  # flow of oil has no rate at the pressure of its tank
    has_jumps = None

    def accelerated(q: Array, v: Array, force: Array | float = 0.0) -> Array:
        """Accelerations, and velocities projected onto the constraints.   force: (n,) added."""
        result = np.zeros((2, len(q)))
        if added:
            added.given[:] = force
        evaluate(external, q, v, 0.0, result[0], result[1])
        return result

    def stiffness(x: Array) -> Array:
        """Along constraints, but for present accelerations over lengths: nothing beside the fastest ones."""
        move, force = STEP * x, STEP * added.stiffness(x) if added else 0.0
        before, after = (accelerated(q + s * move, v, at_present - s * force)[0] for s in (-1.0, 1.0))
        return np.asarray(before - after) / (2.0 * STEP)

    def damping(x: Array) -> Array:
        """A jump, as of Coulomb friction, drops out of d(2 h) - d(h), d(h) = a(-h) - a(h).

        It keeps to the constraints, since what these ask of a is even in v. The start moves everything: where
        nothing jumps then, d(h) is enough from there on.
        """
        nonlocal has_jumps
        force = added.damping(x) if added else 0.0

        def difference(h: float) -> Array:
            before, after = at_rest - h * x, at_rest + h * x
            return accelerated(q, before, h * force)[0] - accelerated(q, after, -h * force)[0]

        near = difference(STEP)
        if has_jumps is False:
            return near / (2.0 * STEP)
        smooth = difference(2.0 * STEP) - near
        if has_jumps is None:
            has_jumps = bool(np.linalg.norm(smooth - near) > NO_JUMP * np.linalg.norm(near))
        return smooth / (2.0 * STEP)

    anywhere = np.cos(np.arange(len(q), dtype=float) ** 2 * 1.6180339887)
    of_supports = accelerated(q, nothing)[1]
    return stiffness, damping, np.asarray(accelerated(q, anywhere)[1] - of_supports)


class VibrationTracker:
    """w_max of a scene in motion, cheaply: the fastest vibration is kept and improved from time to time.

    vibration: (2, n) see `fastest_rates`; zero at first.
    """

    ITERATIONS = 2  # of each improvement

    def __init__(self, size: int) -> None:
        self.vibration = np.zeros((2, size))

    def frequency(self, system: Any, external: Array, q: Array, v: Array) -> float:
        """w_max [rad/s]; NaN if it is not found.   Arguments: see `fastest_rates`."""
        x = self.vibration[0]
        if not x.any():
            return fastest_rates(system, external, q, v, self.vibration).frequency
        stiffness, _, start = _operators(system, external, q, v)
        size = np.linalg.norm(start)
        if not size > 0.0:
            return 0.0 if size == 0.0 else np.nan
        x += FRESH / size * start
        growth = 0.0
        for _ in range(self.ITERATIONS):
            largest = float(np.abs(x).max())
            image = largest * stiffness(x / largest)
            growth = float(np.linalg.norm(image) / np.linalg.norm(x))
            if not 0.0 < growth < np.inf:
                x[:] = 0.0
                return 0.0 if growth == 0.0 else np.nan
            x[:] = image / np.linalg.norm(image)
        return float(np.sqrt(growth))


def _largest_eigenvalue(
    operator: _Operator,
    start: Array,
    negligible: float = 0.0,
    kept: Array | None = None,
    accuracy: Accuracy = OF_DAMPING,
) -> float:
    """The eigenvalue of largest real part; zero if none is positive, NaN if something is not finite.

    negligible: growth of the start that is nothing but round-off.
    kept: (n,) vector of an earlier search, or zero; of this one, where it has found any.
    accuracy: at which the search ends.
    """
    kept = np.zeros(len(start)) if kept is None else kept

    def scaled(x: Array) -> Array:
        norm = float(np.abs(x).max())
        return norm * operator(x / norm) if norm > 0.0 else np.zeros(len(start))

    if not start.any():
        return 0.0
    if kept.any():
        start = kept + FRESH / np.linalg.norm(start) * start
    first = scaled(start) if np.isfinite(start).all() else start
    if not np.isfinite(first).all():
        return np.nan
    if np.linalg.norm(first) <= negligible * np.linalg.norm(start):
        return 0.0
    return _positive(_by_arnoldi(scaled, start, first, kept, accuracy) if first.any() else 0.0)


def _positive(value: float) -> float:
    """The value if it is positive or NaN, else zero."""
    return 0.0 if value <= 0.0 else value


def _by_arnoldi(operator: _Operator, start: Array, first: Array, found: Array, accuracy: Accuracy) -> float:
    """Largest real part of an eigenvalue, once its Ritz value has converged; NaN if something is not finite.

    first: image of the start.   found: (n,) output, the real part of its vector.
    accuracy: see `_largest_eigenvalue`.

    At the latest after `MOST_STEPS`: within some (ln n / m)^2 of the range after m steps, n the coordinates:
    J. Kuczynski, H. Wozniakowski, SIAM J. Matrix Anal. Appl. 13 (1992) 1094-1122.
    """
    most, next_look, before = min(len(start), MOST_STEPS), FIRST_LOOK, np.inf
    basis, hessenberg = np.zeros((FIRST_LOOK, len(start))), np.zeros((most, most))
    scale = np.linalg.norm(start)
    basis[0] = start / scale
    for k in range(most):
        image = operator(basis[k]) if k else first / scale
        size = math.sqrt(image @ image)
        norm = _orthogonalise(basis, k + 1, image, hessenberg[k])
        if not math.isfinite(norm):
            return math.nan
        is_last = k + 1 == most or norm <= ROUND_OFF * size
        if is_last or k + 1 == next_look:
            value, error, vector = _rightmost(hessenberg[: k + 1, : k + 1].T, norm)
            is_settled = abs(value - before) <= accuracy.change * abs(value)
            if is_last or (is_settled and error <= accuracy.residual * abs(value)):
                found[:] = vector @ basis[: k + 1]
                return value
            next_look, before = int(GROWTH * next_look) + 1, value
            basis = np.concatenate([basis, np.zeros((next_look - len(basis), len(start)))])
        hessenberg[k, k + 1] = norm
        basis[k + 1] = image / norm
    raise AssertionError  # the last step returns


@kernel
def _orthogonalise(basis, number, image, shares):
    """Take what lies along the first rows of a basis off the image; returns the norm of what is left.

    Args:
        basis: (k, n) orthonormal rows, of which `number` count.   image: (n,) in place.
        shares: output: what was along each of them, added.
    """
    for _ in range(2):  # the second time against round-off
        for j in range(number):
            share = 0.0
            for i in range(len(image)):
                share += basis[j, i] * image[i]
            for i in range(len(image)):
                image[i] -= share * basis[j, i]
            shares[j] += share
    square = 0.0
    for i in range(len(image)):
        square += image[i] * image[i]
    return np.sqrt(square)


def _rightmost(matrix: Array, norm: float) -> tuple[float, float, Array]:
    """Largest real part of a Ritz value, the residual of its vector, and the real part of that.

    norm: of the next vector.
    """
    values, vectors = np.linalg.eig(matrix)
    which = int(np.argmax(values.real))
    return float(values[which].real), norm * float(abs(vectors[-1, which])), vectors[:, which].real
