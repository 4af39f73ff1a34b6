"""What bounds the step of a coupled system: its fastest vibration and its strongest damping.

Both are eigenvalues of the constrained acceleration's derivatives, found by Arnoldi iteration on
differences of the system's own right-hand side: whatever acts on the parts takes part.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigs

from ..arrays import Array
from ..system import accelerate_and_project

STEP = 1e-6  # of the differences [m, -, m/s, 1/s]
ACCURACY = 1e-3
LARGEST_BASIS = 24
NEGLIGIBLE = 1e-6  # damping over the frequency: less is round-off, and bounds no step
DENSE = 4  # coordinates up to which the matrix is built
MOST_STEPS = (
    400  # of the iteration that never ends without an answer, and coordinates of a matrix in its place
)
OVERDAMPED = 1e3  # damping over the frequency, beyond which a motion is a decay


class FastestRates(NamedTuple):
    """frequency: w_max [rad/s] of small vibrations.   damping: largest d [1/s] of v' = -d v.

    Zero means that nothing vibrates and nothing is damped; NaN that forces or accelerations are not finite.
    A frequency is at least d / `OVERDAMPED`, so that damping without stiffness bounds a step, too.
    """

    frequency: float
    damping: float


def fastest_rates(system: Any, external: Array, q: Array, v: Array) -> FastestRates:
    """Of small motions about the configuration q (n,).   external: of the system, at present.

    The velocities v (n,) count where they pull cables tight, as in bodies that spin about each other;
    gyroscopic forces, which change with small velocities, do not. Friction that jumps where a velocity
    changes its sign has no rate: it makes no motion grow.
    """
    rest = np.zeros(len(q))
    evaluate = accelerate_and_project.dispatch(type(system))

    def acceleration(at: Array, rates: Array) -> Array:
        result, rate = np.zeros(len(q)), np.zeros(len(q))
        evaluate(system, external, at, rates, 0.0, result, rate)
        return result

    def projected(v: Array) -> Array:
        result, memory = np.zeros(len(q)), np.zeros(len(q))
        evaluate(system, external, q, v, 0.0, memory, result)
        return result

    offset = projected(rest)  # moving supports

    def stiffness(x: Array) -> Array:
        difference = acceleration(q - STEP * x, v) - acceleration(q + STEP * x, v)
        return (projected(difference) - offset) / (2.0 * STEP)

    def damping(x: Array) -> Array:
        def difference(step: float) -> Array:
            return acceleration(q, -step * x) - acceleration(q, step * x)

        smooth = difference(2.0 * STEP) - difference(STEP)  # a jump, as of Coulomb friction, drops out
        return (projected(smooth) - offset) / (2.0 * STEP)

    start = projected(np.cos(np.arange(len(q), dtype=float) ** 2 * 1.6180339887)) - offset
    frequency = float(np.sqrt(_largest_eigenvalue(stiffness, start)))
    rate = _largest_eigenvalue(damping, start, NEGLIGIBLE * frequency)
    return FastestRates(float(np.maximum(frequency, rate / OVERDAMPED)), rate)  # keeps a NaN


def _largest_eigenvalue(operator: Callable[[Array], Array], start: Array, negligible: float = 0.0) -> float:
    """The eigenvalue of largest real part; zero if none is positive, NaN if something is not finite.

    negligible: growth of the start that is nothing but round-off.
    """

    def scaled(x: Array) -> Array:
        norm = float(np.abs(x).max())
        return norm * operator(np.real(x) / norm) if norm > 0.0 else np.zeros(len(start))

    if not start.any():
        return 0.0
    first = scaled(start) if np.isfinite(start).all() else start
    if not np.isfinite(first).all():
        return np.nan
    if np.linalg.norm(first) <= negligible * np.linalg.norm(start):
        return 0.0
    if len(start) <= DENSE or not first.any():
        return _positive(_of_matrix(scaled, len(start)) if first.any() else 0.0)
    found = _by_restarts(scaled, start)
    if not np.isfinite(found):
        found = _reliably(scaled, start)
    return _positive(found)


def _positive(value: float) -> float:
    """The value if it is positive or NaN, else zero."""
    return 0.0 if value <= 0.0 else value


def _by_restarts(operator: Callable[[Array], Array], start: Array) -> float:
    """By the library's restarted iteration, which ends early as a rule; NaN if it did not find any."""
    size = len(start)
    linear = LinearOperator((size, size), matvec=lambda x: operator(np.ravel(x)), dtype=float)
    try:
        values = eigs(
            linear,
            k=1,
            which="LR",
            v0=start,
            ncv=min(size, LARGEST_BASIS),
            tol=ACCURACY,
            return_eigenvectors=False,
        )
    except ArpackNoConvergence as error:
        values = error.eigenvalues
    except ArpackError:  # the iteration ended in round-off: what it looks for is hardly there
        return np.nan
    return float(np.real(values).max()) if len(values) else np.nan


def _reliably(operator: Callable[[Array], Array], start: Array) -> float:
    """Without a test of convergence: all eigenvalues, or so many steps that the largest one is found.

    The largest eigenvalue of n after m steps lies within some (ln n / m)^2 of the range: J. Kuczynski,
    H. Wozniakowski, SIAM J. Matrix Anal. Appl. 13 (1992) 1094-1122.
    """
    size = len(start)
    return _of_matrix(operator, size) if size <= MOST_STEPS else _by_arnoldi(operator, start, MOST_STEPS)


def _of_matrix(operator: Callable[[Array], Array], size: int) -> float:
    matrix = np.stack([operator(column) for column in np.eye(size)], axis=1)
    return _rightmost(matrix)


def _rightmost(matrix: Array) -> float:
    """Largest real part of the eigenvalues; NaN if the matrix is not finite."""
    return float(np.real(np.linalg.eigvals(matrix)).max()) if np.isfinite(matrix).all() else np.nan


def _by_arnoldi(operator: Callable[[Array], Array], start: Array, steps: int) -> float:
    """Largest real part of the Ritz values after so many steps of Arnoldi's iteration."""
    basis, hessenberg = np.zeros((steps, len(start))), np.zeros((steps, steps))
    basis[0] = start / np.linalg.norm(start)
    for k in range(steps):
        image = operator(basis[k])
        size = np.linalg.norm(image)
        for _ in range(2):  # the second time against round-off
            share = basis[: k + 1] @ image
            image = image - share @ basis[: k + 1]
            hessenberg[: k + 1, k] += share
        norm = np.linalg.norm(image)
        if k + 1 == steps or not norm > 1e-12 * size:
            return _rightmost(hessenberg[: k + 1, : k + 1])
        hessenberg[k + 1, k] = norm
        basis[k + 1] = image / norm
    raise AssertionError  # the last step returns
