"""Constant length of groups of elements, Eq. (19)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.sparse_forms import assembled
from ..element.forms import forms_of_mesh
from ..element.inextensibility import slope_gram_matrix


@dataclass(frozen=True, eq=False)
class LengthConstraint:
    """c_j = sum over the elements of group j of int |r_x|^2 dx, less its reference value.

    gram: (N, 4, 4) slope Gram matrices [1/m, -; -, m].
    group: (N,) group of each element, 0 to n_bar - 1.
    reference: (N,) what int |r_x|^2 dx shall be [m].
    """

    gram: Array
    group: np.ndarray
    reference: Array
    name: str = "length"

    @property
    def number(self) -> int:
        return int(self.group.max(initial=-1)) + 1

    def _sum_groups(self, per_element: Array) -> Array:
        sums: Array = np.zeros(self.number)
        np.add.at(sums, self.group, per_element)
        return sums

    @staticmethod
    def _nodal(q: Array) -> Array:
        """(N, 4, dim) coordinates of the elements."""
        return np.concatenate([q[:-1], q[1:]], axis=1)

    def _product(self, a: Array, b: Array) -> Array:
        """(N,) int a_x . b_x dx of each element."""
        return np.einsum("eai,eab,ebi->e", self._nodal(a), self.gram, self._nodal(b))

    def value(self, q: Array, t: float = 0.0) -> Array:
        return self._sum_groups(self._product(q, q) - self.reference)

    def rate(self, q: Array, v: Array, t: float = 0.0) -> Array:
        return self._sum_groups(2.0 * self._product(q, v))

    def jacobian(self, q: Array, t: float = 0.0) -> csr_array:
        width = 2 * q.shape[2]
        entries = 2.0 * np.einsum("eab,ebi->eai", self.gram, self._nodal(q))
        columns = width * np.arange(len(self.group))[:, None] + np.arange(2 * width)
        rows = np.repeat(self.group, 2 * width)
        return csr_array((entries.ravel(), (rows, columns.ravel())), shape=(self.number, q.size))

    def gamma(self, q: Array, v: Array, t: float = 0.0) -> Array:
        return self._sum_groups(-2.0 * self._product(v, v))

    def hessian(self, multipliers: Array, shape: tuple[int, ...]) -> csr_array:
        weighted = 2.0 * multipliers[self.group][:, None, None] * self.gram
        return assembled(weighted, shape)

    def describe(self, row: int, node_names: Sequence[Any]) -> str:
        elements = np.flatnonzero(self.group == row)
        ends = node_names[elements[0]], node_names[elements[-1] + 1]
        return f"elements between nodes {ends[0]} and {ends[1]}"


def of_cable(cable: Cable) -> LengthConstraint:
    """The length constraints of `cable`, none if its `length_constraints` is 0."""
    constrained = cable.length_constraints > 0 and not cable.stretches
    gram = forms_of_mesh(slope_gram_matrix, cable.element_lengths)
    count = cable.number_of_elements if constrained else 0
    return LengthConstraint(
        gram[:count], cable.group_of_element()[:count], cable.constrained_lengths()[:count]
    )
