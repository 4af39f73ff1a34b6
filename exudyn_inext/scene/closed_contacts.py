"""Springs and dashpots that do not act yet: contacts that are open now, as if they were closed."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from .coupled_system import CoupledSystem
from .joints import JointBlock, JointTerms
from .small_vibrations import FastestRates, fastest_rates


class ClosedContacts:
    """Linear contact forces -B^T (k B (q - q_0) + d B v).

    motion: B (m, n), sparse: relative displacements of contact points from coordinates.
    stiffness: k (m,) [N/m].   damping: d (m,) [N s/m].
    """

    def __init__(self, motion: Any, stiffness: Array, damping: Array) -> None:
        self._motion = motion
        self._stiffness = stiffness
        self._damping = damping

    def forces(self, moved: Array, v: Array) -> Array:
        """(n,) forces after displacements `moved` (n,) with velocities v (n,)."""
        springs = self._stiffness * (self._motion @ moved)
        result: Array = -(self._motion.T @ (springs + self._damping * (self._motion @ v)))
        return result


class _InContact:
    """Surroundings where these contacts act as well; see `coupled_system.Surroundings`."""

    joints: Sequence[str]
    blocks: Sequence[JointBlock]

    def __init__(self, system: CoupledSystem, contacts: ClosedContacts, q: Array) -> None:
        self.joints = system.surroundings.joints
        self.blocks = system.surroundings.blocks
        self._open = system.surroundings
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

    def violations(self, t: float, q: Array) -> Array:
        return self._open.violations(t, q)

    def motions(self, t: float) -> Sequence[Array]:
        return self._open.motions(t)


def rates_in_contact(
    system: CoupledSystem, contacts: ClosedContacts, t: float, q: Array, v: Array
) -> FastestRates:
    """As `fastest_rates`, while these contacts act, too."""
    surroundings = system.surroundings
    system.surroundings = _InContact(system, contacts, q)
    try:
        return fastest_rates(system, np.array([t]), q, v)
    finally:
        system.surroundings = surroundings
