"""Unit slope at the nodes, Eq. (18)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array

from ..arrays import Array
from ..cable.cable import Cable


@dataclass(frozen=True, eq=False)
class NodalInextensibility:
    """c = r_x . r_x - 1 at `nodes`; clamped nodes are left out, where it is redundant.

    nodes: (m,) node indices.
    """

    nodes: np.ndarray
    name: str = "nodal inextensibility"

    @property
    def number(self) -> int:
        return len(self.nodes)

    def value(self, q: Array, t: float = 0.0) -> Array:
        slopes = q[self.nodes, 1]
        return np.einsum("ki,ki->k", slopes, slopes) - 1.0

    def rate(self, q: Array, v: Array, t: float = 0.0) -> Array:
        return 2.0 * np.einsum("ki,ki->k", q[self.nodes, 1], v[self.nodes, 1])

    def jacobian(self, q: Array, t: float = 0.0) -> csr_array:
        dim = q.shape[2]
        columns = (2 * dim * self.nodes[:, None] + dim + np.arange(dim)).ravel()
        rows = np.repeat(np.arange(self.number), dim)
        entries = 2.0 * q[self.nodes, 1].ravel()
        return csr_array((entries, (rows, columns)), shape=(self.number, q.size))

    def gamma(self, q: Array, v: Array, t: float = 0.0) -> Array:
        slope_rates = v[self.nodes, 1]
        return -2.0 * np.einsum("ki,ki->k", slope_rates, slope_rates)

    def hessian(self, multipliers: Array, shape: tuple[int, ...]) -> csr_array:
        diagonal = np.zeros(shape)
        diagonal[self.nodes, 1] = 2.0 * multipliers[:, None]
        return csr_array(diags_array(diagonal.ravel()))

    def describe(self, row: int, node_names: Sequence[Any]) -> str:
        return f"slope of node {node_names[self.nodes[row]]}"


def of_cable(cable: Cable) -> NodalInextensibility:
    """The nodal constraints of `cable`, none if it has an axial stiffness."""
    needed = ~cable.fixed[:, 1] & (not cable.stretches)
    return NodalInextensibility(np.flatnonzero(needed))
