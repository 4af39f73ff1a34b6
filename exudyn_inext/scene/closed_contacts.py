"""Springs and dashpots that do not act yet: contacts that are open now, as if they were closed."""

from typing import Any

import numpy as np
import scipy

from ..arrays import Array
from .small_vibrations import AddedForces, FastestRates, fastest_rates


class ClosedContacts:
    """Linear contact forces -B^T k B (q - q_0) - C^T d C v.

    motion: B (m, n), sparse: relative displacements of contact points from coordinates.
    damped: C (m, n), the same without what is damped implicitly.
    stiffness: k (m,) [N/m].   damping: d (m,) [N s/m].
    """

    def __init__(self, motion: Any, damped: Any, stiffness: Array, damping: Array) -> None:
        self._stiffness, self._damping = (
            scipy.sparse.csr_array(rows.T @ (values[:, np.newaxis] * rows))
            for rows, values in ((motion, stiffness), (damped, damping))
        )

    def rates(
        self, system: Any, external: Array, given: Array, q: Array, v: Array, kept: Array
    ) -> FastestRates:
        """As `fastest_rates`, while these forces act, too.   given: (n,) others, which the system takes."""
        before = given.copy()
        try:
            added = AddedForces(given, self._stiffness.__matmul__, self._damping.__matmul__)
            return fastest_rates(system, external, q, v, kept, added)
        finally:
            given[:] = before
