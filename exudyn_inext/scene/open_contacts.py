"""Springs and dashpots that do not act yet: contacts that are open now, as if they were closed."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy

from ..arrays import Array
from .small_vibrations import AddedForces, FastestRates, fastest_rates


class OpenContacts:
    """All contacts that are open: if they close, linear forces -B^T k B (q - q_0) - B^T d B v.

    Args:
        motion: B (m, n), sparse: relative displacements of contact points from coordinates.
        stiffness: k (m,) [N/m].   damping: d (m,) [N s/m].
        rate: at which the pressure of others changes, which steps have to resolve [1/s]; 0: there are none.

    name: of them, for messages.   stiffnesses, dampings: which parameters set them.
    """

    def __init__(
        self,
        motion: Any,
        stiffness: Array,
        damping: Array,
        rate: float,
        name: str,
        stiffnesses: Sequence[str],
        dampings: Sequence[str],
    ) -> None:
        self._rate, self._has_springs = rate, len(stiffness) > 0
        self.name, self.stiffnesses, self.dampings = name, stiffnesses, dampings
        self._stiffness, self._damping = (
            scipy.sparse.csr_array(motion.T @ (values[:, np.newaxis] * motion))
            for values in (stiffness, damping)
        )

    def rates(
        self, system: Any, external: Array, given: Array, q: Array, v: Array, kept: Array
    ) -> FastestRates:
        """As `fastest_rates`, if all of them close.   given: (n,) other forces, which the system takes."""
        if not self._has_springs:
            return FastestRates(self._rate, 0.0)
        before = given.copy()
        try:
            added = AddedForces(given, self._stiffness.__matmul__, self._damping.__matmul__)
            rates = fastest_rates(system, external, q, v, kept, added)
            return rates._replace(frequency=max(rates.frequency, self._rate))
        finally:
            given[:] = before
