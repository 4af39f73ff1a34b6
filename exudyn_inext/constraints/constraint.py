"""What a constraint offers."""

from collections.abc import Sequence
from typing import Any, Protocol

from scipy.sparse import csr_array

from ..arrays import Array


class Constraint(Protocol):
    """c(q, t) = 0 with everything that the index reduction needs, Eqs. (27), (28).

    Coordinates and velocities are (n, 2, dim); `number` equations; the Jacobian's columns are the
    coordinates in C order.
    """

    name: str

    @property
    def number(self) -> int: ...

    def value(self, q: Array, t: float = 0.0) -> Array:
        """c (number,)."""

    def rate(self, q: Array, v: Array, t: float = 0.0) -> Array:
        """c_q v + c_t (number,)."""

    def jacobian(self, q: Array, t: float = 0.0) -> csr_array:
        """c_q (number, n_dof)."""

    def gamma(self, q: Array, v: Array, t: float = 0.0) -> Array:
        """-(c_q v)_q v - 2 c_qt v - c_tt (number,)."""

    def hessian(self, multipliers: Array, shape: tuple[int, ...]) -> csr_array:
        """sum_r multipliers_r d2c_r/dq2 (n_dof, n_dof) for coordinates of that shape; constant in q."""

    def describe(self, row: int, node_names: Sequence[Any]) -> str:
        """Where equation `row` acts, for messages; node_names: (n,) what the nodes are called."""
