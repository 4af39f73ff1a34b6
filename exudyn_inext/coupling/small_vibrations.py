"""What bounds the step of a coupled system: its fastest vibration and its strongest damping.

Both are eigenvalues of the constrained acceleration's derivatives, found by Arnoldi iteration on
differences of the system's own right-hand side: whatever acts on the parts takes part.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigs

from ..arrays import Array
from ..system import accelerate_and_project, index_reduced_rates
from .coupled_system import CoupledSystem

STEP = 1e-6  # of the differences [m, -, m/s, 1/s]
ACCURACY = 1e-3
LARGEST_BASIS = 40
DENSE = 4  # coordinates up to which the matrix is built


class FastestRates(NamedTuple):
    """frequency: w_max [rad/s] of small vibrations.   damping: largest d [1/s] of v' = -d v."""

    frequency: float
    damping: float


def fastest_rates(system: CoupledSystem, t: float, q: Array, v: Array) -> FastestRates:
    """Of small motions about the configuration q (n,), at the time t [s].

    The velocities v (n,) count where they pull cables tight, as in bodies that spin about each other;
    gyroscopic forces, which change with small velocities, do not. Friction that jumps where a velocity
    changes its sign has no rate: it makes no motion grow.
    """
    external, rest = np.array([t]), np.zeros(len(q))

    def acceleration(at: Array, rates: Array) -> Array:
        result, rate = np.zeros(len(q)), np.zeros(len(q))
        index_reduced_rates(system, external, at, rates, result, rate)
        return result

    def projected(v: Array) -> Array:
        result, memory = np.zeros(len(q)), np.zeros(len(q))
        accelerate_and_project(system, external, q, v, 0.0, memory, result)
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
    squared = _largest_eigenvalue(stiffness, start)
    return FastestRates(float(np.sqrt(squared)), _largest_eigenvalue(damping, start))


def _largest_eigenvalue(operator: Callable[[Array], Array], start: Array) -> float:
    """The eigenvalue of largest real part, or zero if there is no positive one."""
    size = len(start)
    if not start.any():
        return 0.0

    def scaled(x: Array) -> Array:
        norm = float(np.abs(x).max())
        return norm * operator(np.real(x) / norm) if norm > 0.0 else np.zeros(size)

    def of_matrix() -> Array:
        values = np.linalg.eigvals(np.stack([scaled(column) for column in np.eye(size)], axis=1))
        return np.real(values)

    if size <= DENSE:
        return max(0.0, float(of_matrix().max()))
    if not scaled(start).any():
        return 0.0
    linear = LinearOperator((size, size), matvec=lambda x: scaled(np.ravel(x)), dtype=float)
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
        values = of_matrix()
    return max(0.0, float(np.real(values).max(initial=0.0)))
