"""Springs and dashpots that do not act yet: contacts that are open now, as if they were closed."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from .coupled_system import CoupledSystem
from .joints import JointBlock, JointTerms
from .small_vibrations import AddedForces, FastestRates, fastest_rates


class ClosedContacts:
    """Linear contact forces -B^T k B (q - q_0) - C^T d C v.

    motion: B (m, n), sparse: relative displacements of contact points from coordinates.
    damped: C (m, n), the same without what is damped implicitly.
    stiffness: k (m,) [N/m].   damping: d (m,) [N s/m].
    """

    def __init__(self, motion: Any, damped: Any, stiffness: Array, damping: Array) -> None:
        self._stiffness, self._damping = (
            csr_array(rows.T @ (values[:, np.newaxis] * rows))
            for rows, values in ((motion, stiffness), (damped, damping))
        )

    def given_in(self, memory: Array) -> AddedForces:
        """These forces for a system that takes them from this memory (n,)."""
        return AddedForces(memory, self._stiffness.__matmul__, self._damping.__matmul__)


class _WithForces:
    """Native items where given forces (n,) act as well; see `coupled_system.Items`."""

    joints: Sequence[str]
    blocks: Sequence[JointBlock]

    def __init__(self, system: CoupledSystem, given: Array) -> None:
        self.joints = system.native_items.joints
        self.blocks = system.native_items.blocks
        self._open = system.native_items
        self._given = given
        self._dofs = [part.dofs for part in system.wholes]

    def forces(self, t: float, q: Array, v: Array) -> Sequence[Array]:
        result = [force.copy() for force in self._open.forces(t, q, v)]
        for force, dofs in zip(result, self._dofs, strict=True):
            force[: dofs.stop - dofs.start] += self._given[dofs]
        return result

    def constrain(self, t: float, q: Array, v: Array) -> JointTerms:
        return self._open.constrain(t, q, v)

    def rates_of_states(self, t: float, q: Array, v: Array) -> Array:
        return self._open.rates_of_states(t, q, v)

    def violations(self, t: float, q: Array) -> Array:
        return self._open.violations(t, q)

    def motions(self, t: float) -> Sequence[Array]:
        return self._open.motions(t)


def rates_in_contact(
    system: Any,
    external: Array,
    given: Array | None,
    contacts: ClosedContacts,
    q: Array,
    v: Array,
    kept: Array,
) -> FastestRates:
    """As `fastest_rates`, while these contacts act, too.

    given: (n,) forces besides those of its items that act on a compiled system; None for a `CoupledSystem`.
    """
    if given is None:
        return _rates_of_coupled(system, external, contacts, q, v, kept)
    before = given.copy()
    try:
        return fastest_rates(system, external, q, v, kept, contacts.given_in(given))
    finally:
        given[:] = before


def _rates_of_coupled(
    system: CoupledSystem, external: Array, contacts: ClosedContacts, q: Array, v: Array, kept: Array
) -> FastestRates:
    native_items, given = system.native_items, np.zeros(len(q))
    system.native_items = _WithForces(system, given)
    try:
        return fastest_rates(system, external, q, v, kept, contacts.given_in(given))
    finally:
        system.native_items = native_items
