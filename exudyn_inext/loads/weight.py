"""Gravity of some elements of a cable: constant, or a function of time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from .gravity import gravity_force
from .nodal import LoadFunction, out_of_plane


@dataclass(frozen=True, eq=False)
class ElementWeight:
    """Gravity of some elements of a cable.

    cable: number of its object.   elements: which ones; one that is named twice has it twice.
    constant: (3,) gravity acceleration [m/s^2].   history, is_pure, number: see `NodalLoad`.
    """

    cable: int
    elements: tuple[int, ...]
    constant: Array
    history: LoadFunction | None
    is_pure: bool
    number: int

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


class ConstantWeights:
    """Gravity of the elements of a cable: its own, and constant loads, which may be set by their numbers."""

    def __init__(self, cable: Cable, gravity: Array, weights: Sequence[ElementWeight]) -> None:
        """gravity: (dim,) its own [m/s^2].   weights: of one element each."""
        self._cable, self._own = cable, np.tile(gravity, (cable.number_of_elements, 1))
        self._weights = weights
        self._rows = {weight.number: row for row, weight in enumerate(weights)}
        self._elements = np.array([weight.elements[0] for weight in weights], dtype=int)
        self._vectors = np.array([weight.constant for weight in weights]).reshape(-1, 3)

    def change(self, values: Mapping[int, Sequence[float]]) -> set[int]:
        """Set loads to (3,) [m/s^2], by their numbers; returns those that are weights of this cable."""
        found = self._rows.keys() & values
        for number in found:
            for name in ("gravity", "force"):
                self.__dict__.pop(name, None)
            self._vectors[self._rows[number]] = values[number]
        return found

    @cached_property
    def gravity(self) -> Array:
        """(N, dim) acceleration of each element [m/s^2]; not to be written to.

        Raises:
            SceneError: a weight has a component out of the plane of its cable.
        """
        result, dim = self._own.copy(), self._cable.dimension
        if self._vectors[:, dim:].any():
            row = np.flatnonzero(self._vectors[:, dim])[0]
            raise out_of_plane(self._weights[row], self._vectors[row, dim])
        np.add.at(result, self._elements, self._vectors[:, :dim])
        return result

    @cached_property
    def force(self) -> Array:
        """(n_dof,) generalised force [N, Nm], not to be written to; raises as `gravity`."""
        return gravity_force(self._cable, self.gravity).ravel()
