"""Whether an equilibrium is stable: the smallest eigenvalue of the constrained Hessian."""

import numpy as np
import scipy

from ..arrays import Array
from .saddle_point import factorise, solve
from .small_motions import SmallMotions

LANCZOS_STEPS = 60
BETWEEN = 10  # steps between two looks
SETTLED = 1e-12  # change of the inverse eigenvalues, relative to the largest one
ROUND_OFF = 2e-12  # of a stiffness, relative
OF_FORCES = 1e-9  # of one that is found by differences, relative to the loads [1/m, m]
SMALL = 0.01  # eigenvalue, in units of the loads' own [-]
LOWEST = 10  # eigenvalues, among which two may have come together
TOGETHER = 1e-3  # imaginary part of an eigenvalue that is no round-off, relative to it and to the shift
NEGLIGIBLE = 1e-10  # of the inverse eigenvalues: round-off of those that are infinite


def smallest_eigenvalue(about: SmallMotions) -> tuple[float, Array]:
    """Of the Hessian on the constraints' null space, over the mass [1/s^2], and its vector (n_dof,).

    Lanczos iteration with the inverse, orthogonalised: if some eigenvalues are negative, the one nearest
    to zero of those that are no round-off of something indifferent.
    """
    potential, q, _, hessian, jacobian, _ = about
    rows = min(LANCZOS_STEPS, q.size - jacobian.shape[0])
    if rows < 1:
        return np.inf, np.zeros(q.size)
    zero = np.zeros(jacobian.shape[0])
    try:
        inverse = factorise(hessian, jacobian, potential.order)
        project = factorise(potential.mass, jacobian, potential.order)
    except RuntimeError:  # singular: something moves without any force
        return 0.0, np.zeros(q.size)
    vector, _ = solve(project, np.random.default_rng(1).standard_normal(q.size), zero)
    basis, images = np.zeros((2, rows, q.size))  # images: mass times basis
    reduced = np.zeros((rows, rows))
    values = vectors = np.zeros((0, 0))
    for row in range(rows):
        for _ in range(2):
            shares = np.einsum("ri,i->r", images[:row], vector)  # BLAS would keep other cores awake
            vector = vector - np.einsum("ri,r->i", basis[:row], shares)
        image = potential.mass @ vector
        norm = np.sqrt(vector @ image)
        basis[row], images[row] = vector / norm, image / norm
        vector, _ = solve(inverse, images[row], zero)
        reduced[row, : row + 1] = np.einsum("ri,i->r", images[: row + 1], vector)
        if row == rows - 1 or row % BETWEEN == BETWEEN - 1:
            before, (values, vectors) = values, scipy.linalg.eigh(reduced[: row + 1, : row + 1], lower=True)
            if len(before) and _are_settled(before, values):
                break

    def mode(k: int) -> Array:
        return np.einsum("r,ri->i", vectors[:, k], basis[: len(values)])

    negative = np.flatnonzero(values < -NEGLIGIBLE * abs(values).max())
    unstable = negative[values[negative] * potential.indifferent < 1.0]
    for k in (*unstable, *negative[:1]):  # round-off of a free turn, nearest to zero, hides no other one
        if (found := mode(k)) @ (hessian @ found) < 0.0:
            return float(1.0 / values[k]), found
    return float(1.0 / values[-1]), mode(-1)


def eigenvalue_without_potential(about: SmallMotions, lowest: float) -> complex:
    """Of the whole Hessian, with its skew part: the lowest real one, or one that is not real [1/s^2].

    Small motions grow if it is not real: the skew part feeds two vibrations, which have come together.
    lowest: of the symmetric part; the result if nobody knows better. No real one is lower.
    """
    system, jacobian = about.system, about.jacobian
    size, number = about.q.size, min(LOWEST, about.q.size - jacobian.shape[0] - 2)
    if number < 1 or not abs(about.skew).max() > 0.0:
        return complex(lowest)
    zero, start = np.zeros(jacobian.shape[0]), np.random.default_rng(1).standard_normal(size)
    try:
        factor = factorise(about.hessian + about.skew, jacobian, system.order)
        inverse = scipy.sparse.linalg.LinearOperator(
            (size, size), lambda x: solve(factor, system.mass @ x, zero)[0]
        )
        found = 1.0 / scipy.sparse.linalg.eigs(inverse, number, v0=inverse @ start, return_eigenvectors=False)
    except RuntimeError:  # singular, or not found
        return complex(lowest)
    pairs = found[np.abs(found.imag) > TOGETHER * np.maximum(np.abs(found), system.shift)]
    if len(pairs):
        return complex(pairs[np.argmin(pairs.real)])
    return complex(found.real.min() if abs(found).max() > abs(lowest) else lowest)


def round_off(about: SmallMotions) -> float:
    """By how much an eigenvalue may be off and still be small beside what the loads cause [1/s^2].

    0 for an inextensible cable by itself, whose Hessian contains no differences.
    """
    potential = about.system
    if potential.indifferent == 0.0:
        return 0.0
    stiffness, mass = abs(about.hessian.diagonal()), potential.mass.diagonal()
    moved = mass > 0.0
    errors = ROUND_OFF * stiffness[moved] + OF_FORCES * potential.largest_load
    return min(float((errors / mass[moved]).max(initial=0.0)), SMALL * potential.shift)


def _are_settled(before: Array, values: Array) -> bool:
    """Whether more steps have left the smallest and the largest of the inverse eigenvalues alone."""
    size = SETTLED * max(abs(values[0]), abs(values[-1]))
    return bool(abs(before[0] - values[0]) < size and abs(before[-1] - values[-1]) < size)
