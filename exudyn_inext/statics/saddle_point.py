"""Sparse factorisation of [B J^T; J 0]: steps along, or back to, the constraint manifold."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import SuperLU, splu

from ..arrays import Array
from ..sparse import bordered


def factorise(model: csr_array, jacobian: csr_array) -> SuperLU:
    """LU of [B J^T; J 0]."""
    return splu(bordered(model, jacobian))


def solve(factor: SuperLU, force: Array, target: Array) -> tuple[Array, Array]:
    """x and multipliers of [B J^T; J 0] [x; lam] = [force; target], factorised."""
    solution = factor.solve(np.concatenate([force, target]))
    return solution[: len(force)], solution[len(force) :]
