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
from ..compiled import kernel
from ..errors import RedundantConstraintError
from .parts import respond

PIVOT_TOLERANCE = 1e-10  # of a pivot of S, relative to its diagonal entry


class JointBlock:
    """Rows of the joints on one part.

    Args:
        system: of the part.   dofs: its place in the coupled vectors.   rows: (k,) which rows.

    Attributes:
        jacobian: (k, n_dof), set by whoever knows the joints.   response: (k, n_dof) A^-1 J^T.
    """

    def __init__(self, system: Any, dofs: slice, rows: np.ndarray) -> None:
        self.system = system
        self.dofs = dofs
        self.rows = rows
        self.jacobian: Array = np.zeros((len(rows), dofs.stop - dofs.start))
        self.response: Array = np.zeros_like(self.jacobian)


@dataclass(frozen=True, eq=False)
class JointTerms:
    """Joints at (t, q, v).

    value: c (m,) [m, rad].   drift: c_t (m,).   gamma: -(d2c/dt2 at zero acceleration) (m,), Eq. (27).
    """

    value: Array
    drift: Array
    gamma: Array


class JointSolve:
    """The solve of S.   names: of the rows, for messages.   blocks: J by parts."""

    def __init__(self, blocks: Sequence[JointBlock], names: Sequence[str]) -> None:
        self._blocks = blocks
        self._names = names
        self._schur: Array = np.zeros((len(names), len(names)))
        self._factor: Array = np.zeros((len(names), len(names)))

    def factorise(self) -> None:
        """S of the present Jacobians; the parts are factorised.

        Raises:
            RedundantConstraintError: names the first row that depends on others.
        """
        self._schur[:] = 0.0
        for block in self._blocks:
            respond(block.system, block.jacobian, block.response)
            _add_product(block.rows, block.jacobian, block.response, self._schur)
        self._factor = _factorise(self._schur, self._names)

    def times_jacobian(self, x: Array) -> Array:
        """J x (m,).   x: (n,)."""
        result = np.zeros(len(self._names))
        for block in self._blocks:
            _add_times(block.rows, block.jacobian, x[block.dofs], result)
        return result

    def joint_force(self, nu: Array, dofs: slice) -> Array:
        """J^T nu on one part.   nu: (m,).   dofs: its place."""
        force = np.zeros(dofs.stop - dofs.start)
        for block in self._blocks:
            if block.dofs == dofs:
                _subtract_rows(block.rows, block.jacobian, -nu, force)
        return force

    def apply(self, x: Array, target: Array) -> Array:
        """x -= A^-1 J^T nu in place, such that J x = target; returns nu (m,)."""
        nu: Array
        nu, _ = lapack.dpotrs(self._factor, self.times_jacobian(x) - target, lower=1)
        for block in self._blocks:
            _subtract_rows(block.rows, block.response, nu, x[block.dofs])
        return nu


@kernel
def _add_product(rows, jacobian, response, schur):
    """schur += J R^T in the places `rows`; lower triangle."""
    for a in range(len(rows)):
        for b in range(len(rows)):
            if rows[b] <= rows[a]:
                total = 0.0
                for i in range(jacobian.shape[1]):
                    total += jacobian[a, i] * response[b, i]
                schur[rows[a], rows[b]] += total


@kernel
def _add_times(rows, jacobian, x, result):
    """result += J x in the places `rows`."""
    for a in range(len(rows)):
        total = 0.0
        for i in range(len(x)):
            total += jacobian[a, i] * x[i]
        result[rows[a]] += total


@kernel
def _subtract_rows(rows, matrix, nu, x):
    """x -= matrix^T nu, nu at the places `rows`."""
    for a in range(len(rows)):
        for i in range(len(x)):
            x[i] -= matrix[a, i] * nu[rows[a]]


def _factorise(schur: Array, names: Sequence[str]) -> Array:
    """Cholesky factor L of S, of which the lower triangle is set."""
    factor: Array
    factor, info = lapack.dpotrf(schur, lower=1)
    if info == 0:
        diagonal = factor.diagonal()
        dependent = ~(diagonal * diagonal > PIVOT_TOLERANCE * schur.diagonal())
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
