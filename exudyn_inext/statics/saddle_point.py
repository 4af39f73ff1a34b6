"""Factorisation of [B J^T; J 0]: steps along, or back to, the constraint manifold.

Each constraint is eliminated after all coordinates that it acts on, where its pivot is no longer zero: then
an order of few filled entries holds for all B and J of a scene.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy

from ..arrays import Array, SparseArray
from ..sparse import bordered, order_of, rows_of

FEW = 120  # unknowns, of which a dense factor costs less
PIVOT = 0.01  # least diagonal entry, over the largest one below it
_OPTIONS: dict[str, Any] = {
    "permc_spec": "NATURAL",
    "diag_pivot_thresh": PIVOT,
    "relax": 1,
    "panel_size": 1,
    "options": {"SymmetricMode": True},
}


class Factor(NamedTuple):
    """LU of a matrix: a sparse one and the places (n + m,) of its unknowns, or a dense one and its pivots."""

    lu: "scipy.sparse.linalg.SuperLU | Array"
    places: np.ndarray


def order_of_elimination(model: SparseArray, jacobian: SparseArray) -> np.ndarray:
    """(n,) the place of each coordinate, for all matrices that have entries where these have some."""
    rows, columns, _ = bordered(model, jacobian)
    return order_of(rows, columns, sum(jacobian.shape))[: len(model.indptr) - 1]


def factorise(model: SparseArray, jacobian: SparseArray, order: np.ndarray | None = None) -> Factor:
    """LU of [B J^T; J 0].

    order: (n,) place of each coordinate in the order of elimination; None: as they are.

    Raises:
        RuntimeError: the matrix is singular.
    """
    number, size = jacobian.shape
    total = size + number
    if total <= FEW:
        dense = np.zeros((total, total), order="F")
        dense[:size, :size] = model.toarray()
        dense[size:, :size] = below = jacobian.toarray()
        dense[:size, size:] = below.T
        lu, pivots, is_singular = scipy.linalg.lapack.dgetrf(dense, overwrite_a=True)
        if is_singular:
            raise RuntimeError("the matrix is singular")
        return Factor(lu, pivots)
    order = np.arange(size) if order is None else order
    last = np.full(number, -1)
    np.maximum.at(last, rows_of(jacobian), order[jacobian.indices])
    places = np.empty(total, np.int32)
    places[np.argsort(np.append(order, last + 0.5), kind="stable")] = np.arange(total)
    rows, columns, values = bordered(model, jacobian)
    matrix = scipy.sparse.csc_array((values, (places[rows], places[columns])), shape=(total, total))
    return Factor(scipy.sparse.linalg.splu(matrix, **_OPTIONS), places)


def solve(factor: Factor, force: Array, target: Array) -> tuple[Array, Array]:
    """x and multipliers of [B J^T; J 0] [x; lam] = [force; target], factorised."""
    known = np.concatenate([force, target])
    if isinstance(factor.lu, scipy.sparse.linalg.SuperLU):
        permuted = np.empty_like(known)
        permuted[factor.places] = known
        solution = factor.lu.solve(permuted)[factor.places]
    else:
        solution = scipy.linalg.lapack.dgetrs(factor.lu, factor.places, known, overwrite_b=True)[0]
    return solution[: len(force)], solution[len(force) :]
