"""Springs and dashpots that do not act yet: contacts that are open now, as if they were closed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from ..called_system import Bound
from ..system import accelerate_and_project
from .coupled_system import CoupledSystem
from .joints import JointBlock, JointTerms
from .small_vibrations import FastestRates, fastest_rates


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

    def forces(self, moved: Array, v: Array) -> Array:
        """(n,) forces after displacements `moved` (n,) with velocities v (n,)."""
        result = np.zeros(len(v))
        for matrix, motion in ((self._stiffness, moved), (self._damping, v)):
            if motion.any():  # the product takes longer than the look
                result -= matrix @ motion
        return result


class _InContact:
    """Native items where these contacts act as well; see `coupled_system.Items`."""

    joints: Sequence[str]
    blocks: Sequence[JointBlock]

    def __init__(self, system: CoupledSystem, contacts: ClosedContacts, q: Array) -> None:
        self.joints = system.native_items.joints
        self.blocks = system.native_items.blocks
        self._open = system.native_items
        self._contacts = contacts
        self._dofs = [part.dofs for part in system.wholes]
        self._start = q.copy()

    def forces(self, t: float, q: Array, v: Array) -> Sequence[Array]:
        added = self._contacts.forces(q - self._start, v)
        result = [force.copy() for force in self._open.forces(t, q, v)]
        for force, dofs in zip(result, self._dofs, strict=True):
            force[: dofs.stop - dofs.start] += added[dofs]
        return result

    def constrain(self, t: float, q: Array, v: Array) -> JointTerms:
        return self._open.constrain(t, q, v)

    def rates_of_states(self, t: float, q: Array, v: Array) -> Array:
        return self._open.rates_of_states(t, q, v)

    def violations(self, t: float, q: Array) -> Array:
        return self._open.violations(t, q)

    def motions(self, t: float) -> Sequence[Array]:
        return self._open.motions(t)


@dataclass(frozen=True, eq=False)
class _GivenContacts:
    """A compiled system to which these contacts are given as forces (n,).   start: q_0 (n,)."""

    accelerate: Bound
    given: Array
    contacts: ClosedContacts
    start: Array


@accelerate_and_project.register(_GivenContacts)
def _accelerate_in_contact(system, external, q, v, duration, acceleration, end_velocity):
    system.given[:] = system.contacts.forces(q - system.start, v + duration * acceleration)
    system.accelerate(external, q, v, duration, acceleration, end_velocity)


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
        accelerate = Bound(accelerate_and_project, system)
        return fastest_rates(_GivenContacts(accelerate, given, contacts, q.copy()), external, q, v, kept)
    finally:
        given[:] = before


def _rates_of_coupled(
    system: CoupledSystem, external: Array, contacts: ClosedContacts, q: Array, v: Array, kept: Array
) -> FastestRates:
    native_items = system.native_items
    system.native_items = _InContact(system, contacts, q)
    try:
        return fastest_rates(system, external, q, v, kept)
    finally:
        system.native_items = native_items
