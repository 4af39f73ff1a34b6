"""Gravity of some elements of a cable: constant, or a function of time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from .gravity import gravity_force
from .nodal import LoadFunction


@dataclass(frozen=True, eq=False)
class ElementWeight:
    """Gravity of some elements of a cable.

    cable: number of its object.   elements: which ones; one that is named twice has it twice.
    constant: (3,) gravity acceleration [m/s^2].   history, is_pure: see `NodalLoad`.
    """

    cable: int
    elements: tuple[int, ...]
    constant: Array
    history: LoadFunction | None
    is_pure: bool

    unit: ClassVar[str] = "m/s^2"

    @property
    def follows_state(self) -> bool:
        """Whether its user function may depend on more than the time."""
        return self.history is not None and not self.is_pure

    @property
    def place(self) -> str:
        """For messages."""
        return f"element {self.elements[0]} of object {self.cable}"

    def is_in_space(self, component: int, dim: int) -> bool:
        """Whether a component acts on the cable; the z component on a planar one does not."""
        return component < dim

    def gravity(self, components: Array, shape: tuple[int, int]) -> Array:
        """(N, dim) = `shape` gravity acceleration of all elements [m/s^2].   components: (3,) of these."""
        result = np.zeros(shape)
        np.add.at(result, list(self.elements), components[: shape[1]])
        return result

    def unit_forces(self, cable: Cable, nodes: Sequence[int]) -> Array:
        """(3, n_dof) generalised force per unit of each component [kg, kg m]."""
        shape = cable.number_of_elements, cable.dimension
        forces = [gravity_force(cable, self.gravity(unit, shape)) for unit in np.eye(3)]
        return np.reshape(forces, (3, cable.reference.size))
