"""Bodies: M a = F with a mass matrix of small blocks, some of which change with the configuration."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from ..arrays import Array
from ..system import accelerate_and_project, correct_position, index_reduced_rates
from .parts import respond

_DENSE = 40  # coordinates up to which a dense product is the faster one


@dataclass(frozen=True, eq=False)
class MassBlock:
    """Coordinates whose accelerations are coupled by mass.   dofs: (k,).   mass: (k, k), regular."""

    dofs: np.ndarray
    mass: Array


class BodiesSystem:
    """The `system` of all bodies: no constraints of their own, joints are the coupling's.

    Args:
        size: number of coordinates.
        constant: blocks that never change, inverted once.
        variable: dofs (B, k) of the blocks, by their size k, that `set_masses` gives at each evaluation.
    """

    def __init__(self, size: int, constant: Sequence[MassBlock], variable: Sequence[np.ndarray] = ()) -> None:
        self._variable = list(variable)
        self._inverses = [np.zeros((*dofs.shape, dofs.shape[1])) for dofs in self._variable]
        self._constant = _inverse_of_blocks(size, constant)

    def set_masses(self, stack: int, masses: Array) -> None:
        """Masses (B, k, k) of the variable blocks of one size in the present configuration."""
        self._inverses[stack] = np.asarray(np.linalg.inv(masses), dtype=float)

    def accelerations(self, force: Array) -> Array:
        """M^-1 F.   force: (n,) [N, Nm]."""
        result: Array = self._constant @ force
        for dofs, inverses in zip(self._variable, self._inverses, strict=True):
            result[dofs] = (inverses @ force[dofs][:, :, None])[:, :, 0]
        return result

    def responses(self, forces: Array) -> Array:
        """M^-1 F for rows F of forces (rows, n)."""
        result: Array = (self._constant @ forces.T).T
        for dofs, inverses in zip(self._variable, self._inverses, strict=True):
            result[:, dofs] = (inverses @ forces[:, dofs][..., None])[..., 0]
        return result


def _inverse_of_blocks(size: int, blocks: Sequence[MassBlock]) -> Any:
    if size <= _DENSE:
        dense: Array = np.zeros((size, size))
        for block in blocks:
            dense[np.ix_(block.dofs, block.dofs)] = np.linalg.inv(block.mass)
        return dense
    entries = [np.linalg.inv(block.mass).ravel() for block in blocks]
    rows = [np.repeat(block.dofs, len(block.dofs)) for block in blocks]
    columns = [np.tile(block.dofs, len(block.dofs)) for block in blocks]
    if not entries:
        return csr_array((size, size))
    places = (np.concatenate(rows), np.concatenate(columns))
    return csr_array((np.concatenate(entries), places), shape=(size, size))


@index_reduced_rates.register(BodiesSystem)
def bodies_rates(system, external, q, v, acceleration, rate):
    """Arguments: see `index_reduced_rates`."""
    acceleration[:] = system.accelerations(external)
    rate[:] = v


@accelerate_and_project.register(BodiesSystem)
def accelerate_bodies(system, external, q, v, duration, acceleration, end_velocity):
    """Arguments: see `accelerate_and_project`."""
    acceleration[:] = system.accelerations(external)
    end_velocity[:] = v + duration * acceleration


@correct_position.register(BodiesSystem)
def correct_bodies(system, external, q, tolerance, learning, correction):
    """Nothing to correct."""
    return 0.0


@respond.register(BodiesSystem)
def respond_as_bodies(system, jacobian, response):
    """Arguments: see `respond`."""
    response[:] = system.responses(jacobian)
