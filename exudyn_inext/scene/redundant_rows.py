"""Rows of joints that depend on others, and what is said of them."""

import math
from collections.abc import Sequence

import numpy as np
import scipy

from ..arrays import Array
from ..errors import RedundantConstraintError

PIVOT_TOLERANCE = 1e-10  # of a pivot of S, relative to its diagonal entry
MOST_NAMED = 5  # joints
NOT_FINITE = (
    "the Jacobian of the joints is not finite: the run has diverged, or a joint is singular in the present "
    "configuration."
)


def dependent_rows(schur: Array, names: Sequence[str]) -> RedundantConstraintError:
    """What is said where S, of which the lower triangle is set, is not positive definite."""
    if not np.isfinite(schur).all():
        return RedundantConstraintError(NOT_FINITE)
    pivots = shares_of_pivots(schur)
    least = max(PIVOT_TOLERANCE, pivots.min())
    return not_independent([name for name, pivot in zip(names, pivots, strict=True) if pivot <= least])


def shares_of_pivots(schur: Array) -> Array:
    """(m,) pivots of S (m, m) in a Cholesky factorisation, as shares of its diagonal.

    A row depends on those before it if its pivot vanishes. Only the lower triangle of S is read.
    """
    whole, factor = schur + np.tril(schur, -1).T, np.zeros_like(schur)
    kept: list[int] = []
    pivots = np.zeros(len(schur))
    for row, diagonal in enumerate(schur.diagonal()):
        k = len(kept)
        x = scipy.linalg.solve_triangular(factor[:k, :k], whole[row, kept], lower=True) if k else np.zeros(0)
        pivots[row] = 1.0 - x @ x / diagonal if diagonal > 0.0 else 0.0
        if pivots[row] > PIVOT_TOLERANCE:
            factor[k, :k], factor[k, k] = x, math.sqrt(pivots[row] * diagonal)
            kept.append(row)
    return pivots


def not_independent(names: Sequence[str]) -> RedundantConstraintError:
    """What is said of rows; of many joints, the first ones are named."""
    joints: dict[str, list[str]] = {}
    for name in names:
        joint, _, number = name.strip(",").partition(", equation ")
        joints.setdefault(joint, []).append(number)
    said = [f"{one}, equation{'s'[: len(own) - 1]} {', '.join(own)}," for one, own in joints.items()]
    others = f" and {len(said) - MOST_NAMED} other joints" if len(said) > MOST_NAMED else ""
    return RedundantConstraintError(
        f"{' '.join(said[:MOST_NAMED])}{others} {'is' if len(names) == 1 else 'are'} not independent of the "
        "other constraints in the present configuration: remove joints of which all equations are named, "
        "free the axes of others (constrainedAxes; CreateGenericJoint in place of joints without them), or "
        "give cables that are straight between joints their axialStiffness."
    )
