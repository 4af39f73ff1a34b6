"""Joints: constraints c(q, t) = 0 between parts, by a Schur complement on the parts' own solves.

With A the saddle-point matrices of all parts, side by side, and J the Jacobian of the joints,

    [A J^T; J 0] [y; nu] = [f; b]:    S nu = J A^-1 f - b,  S = J A^-1 J^T,  y = A^-1 f - A^-1 J^T nu.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import lapack

from ..arrays import Array
from ..errors import RedundantConstraintError
from .parts import respond

PIVOT_TOLERANCE = 1e-10  # of a pivot of S, relative to its diagonal entry


@dataclass(frozen=True, eq=False)
class JointBlock:
    """Rows of the joints on one part.   dofs: of the part.   rows: (k,).   jacobian: (k, n_dof)."""

    system: Any
    dofs: slice
    rows: np.ndarray
    jacobian: Array


@dataclass(frozen=True, eq=False)
class JointTerms:
    """Joints at (t, q, v).

    value: c (m,) [m, rad].   drift: c_t (m,).   gamma: -(d2c/dt2 at zero acceleration) (m,), Eq. (27).
    blocks: Jacobian J = c_q by parts.
    """

    value: Array
    drift: Array
    gamma: Array
    blocks: Sequence[JointBlock]


class JointSolve:
    """S, factorised, for one configuration."""

    def __init__(self, blocks: Sequence[JointBlock], names: Sequence[str]) -> None:
        self._blocks = blocks
        self._number = len(names)
        self._responses = [np.empty_like(block.jacobian) for block in blocks]
        schur = np.zeros((self._number, self._number))
        for block, response in zip(blocks, self._responses, strict=True):
            respond(block.system, block.jacobian, response)
            schur[np.ix_(block.rows, block.rows)] += block.jacobian @ response.T
        self._factor = _factorise(schur, names)

    def times_jacobian(self, x: Array) -> Array:
        """J x (m,).   x: (n,)."""
        result = np.zeros(self._number)
        for block in self._blocks:
            result[block.rows] += block.jacobian @ x[block.dofs]
        return result

    def apply(self, x: Array, target: Array) -> Array:
        """x -= A^-1 J^T nu in place, such that J x = target; returns nu (m,)."""
        nu, _ = lapack.dpotrs(self._factor, self.times_jacobian(x) - target, lower=1)
        for block, response in zip(self._blocks, self._responses, strict=True):
            x[block.dofs] -= nu[block.rows] @ response
        return nu


def _factorise(schur: Array, names: Sequence[str]) -> Array:
    """Cholesky factor L of S; RedundantConstraintError names the first dependent row."""
    factor, info = lapack.dpotrf(schur, lower=1)
    if info == 0:
        pivots = np.diag(factor) ** 2
        dependent = ~(pivots > PIVOT_TOLERANCE * np.diag(schur))
        if not dependent.any():
            return factor
        info = int(np.argmax(dependent)) + 1
    if not np.isfinite(schur).all():
        raise RedundantConstraintError(
            "the Jacobian of the joints is not finite: the run has diverged, or a joint is singular in the "
            "present configuration; reduce stepSize."
        )
    raise RedundantConstraintError(
        f"{names[info - 1]} is not independent of the other constraints in the present configuration: remove "
        "it, or free the axes that other joints hold already."
    )
