"""Coordinates held at their reference values: what pins and clamps are made of."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array


@dataclass(frozen=True, eq=False)
class HeldNodes:
    """c = q - q_reference for all coordinates of the given kinds at the given nodes.

    name: what the support is called.
    nodes: (m,) node indices.
    kinds: 0 for the position, 1 for the slope.
    reference: (n, 2, dim) reference configuration.
    """

    name: str
    nodes: np.ndarray
    kinds: tuple[int, ...]
    reference: Array

    @property
    def number(self) -> int:
        return len(self.nodes) * len(self.kinds) * self.reference.shape[2]

    def _held(self, q: np.ndarray) -> np.ndarray:
        return q[np.ix_(self.nodes, np.array(self.kinds))].ravel()

    def value(self, q: Array, t: float = 0.0) -> Array:
        return self._held(q - self.reference)

    def rate(self, q: Array, v: Array, t: float = 0.0) -> Array:
        return self._held(v)

    def jacobian(self, q: Array, t: float = 0.0) -> csr_array:
        columns = self._held(np.arange(q.size).reshape(q.shape))
        entries = (np.ones(self.number), (np.arange(self.number), columns))
        return csr_array(entries, shape=(self.number, q.size))

    def gamma(self, q: Array, v: Array, t: float = 0.0) -> Array:
        return np.zeros(self.number)

    def hessian(self, multipliers: Array, shape: tuple[int, ...]) -> csr_array:
        size = int(np.prod(shape))
        return csr_array((size, size))

    def describe(self, row: int, node_names: Sequence[Any]) -> str:
        node, rest = divmod(row, len(self.kinds) * self.reference.shape[2])
        kind, axis = divmod(rest, self.reference.shape[2])
        what = ("position", "slope")[self.kinds[kind]]
        return f"{what} {'xyz'[axis]} of node {node_names[self.nodes[node]]}"
