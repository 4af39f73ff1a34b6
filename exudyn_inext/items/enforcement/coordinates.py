"""Coordinates of a cable's object in the shape that the kernels take, and results back."""

from typing import Any

import exudyn
import numpy as np
import scipy

from ...arrays import Array, SparseArray
from ...cable.cable import Cable


class Coordinates:
    """Conversions for one cable: Exudyn's vectors have each node once, (n, 2, dim) arrays repeat the first
    node of a closed cable at the end.

    shape: (n, 2, dim).   size: number of the object's coordinates.
    """

    def __init__(self, cable: Cable) -> None:
        self.shape = cable.reference.shape
        self.size = cable.reference[: len(cable.reference) - cable.closed].size
        self._reference = cable.reference
        self._closed = cable.closed

    def nodal(self, vector: Any) -> Array:
        """(size,) -> (n, 2, dim), values as they are."""
        rows: Array = np.array(vector, dtype=float).reshape(-1, *self.shape[1:])
        return np.concatenate([rows, rows[:1]]) if self._closed else rows

    def total(self, displacements: Any) -> Array:
        """(size,) displacements, as objects get them -> (n, 2, dim) positions [m] and slopes [-]."""
        return self.nodal(displacements) + self._reference

    def vector(self, nodal: Array) -> Array:
        """(..., n, 2, dim) forces or gradients -> (..., size); the two ends of a closed cable are added."""
        if self._closed:
            nodal = nodal.copy()
            nodal[..., 0, :, :] += nodal[..., -1, :, :]
        return nodal.reshape(*nodal.shape[:-3], -1)[..., : self.size]

    def matrix(self, dense: Array) -> Array:
        """(n_dof, n_dof) -> (size, size), as `vector` on both sides."""
        n_dof = int(np.prod(self.shape))
        if not self._closed:
            return dense.reshape(n_dof, n_dof)
        rows = self.vector(dense.reshape(n_dof, *self.shape))
        return self.vector(rows.T.reshape(self.size, *self.shape)).T

    def sparse_matrix(self, nodal: SparseArray) -> exudyn.MatrixContainer:
        """(n_dof, n_dof) -> (size, size), as `matrix`, in the form that costs Exudyn O(size)."""
        entries = nodal.tocoo()
        places = (entries.row % self.size, entries.col % self.size)
        matrix = scipy.sparse.csr_matrix((entries.data, places), shape=(self.size, self.size))
        matrix.eliminate_zeros()  # which Exudyn's sparse matrices may not hold
        container = exudyn.MatrixContainer()
        container.SetWithSparseMatrix(matrix)
        return container
