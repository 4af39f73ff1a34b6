"""A generalised force on a node: constant, or a function of time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..errors import SceneError


@dataclass(frozen=True, eq=False)
class LoadFunction:
    """Of a load at t [s]: its components are scale times function(mbs, t, value).   value: given with it."""

    function: Callable[..., Any]
    mbs: Any
    value: Any
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """A generalised force on coordinates of one node.

    node: node number.
    coordinates: the nodal coordinate that each component acts on.
    constant: (m,) components [N, Nm].
    history: its user function, or None if the load is constant.
    is_pure: whether that one depends on the time alone, so that it may be asked ahead of time.
    number: of the load in its mbs.   scale: of what is set there.
    """

    node: int
    coordinates: tuple[int, ...]
    constant: Array
    history: LoadFunction | None
    is_pure: bool = False
    number: int = -1
    scale: float = 1.0

    unit: ClassVar[str] = "N"

    @property
    def place(self) -> str:
        """For messages."""
        return f"node {self.node}"

    def is_in_space(self, component: int, dim: int) -> bool:
        """Whether a component acts on the cable; the z component of a force on a planar one does not."""
        return len(self.coordinates) == 1 or self.coordinates[component] < dim

    def unit_forces(self, cable: Cable, nodes: Sequence[int]) -> Array:
        """(m, n_dof) generalised force per unit of each component; zero for one out of the plane [-].

        nodes: numbers of the nodes of the cable.
        """
        dim = cable.dimension
        forces = np.zeros((len(self.coordinates), cable.reference.size))
        for component, coordinate in enumerate(self.coordinates):
            if self.is_in_space(component, dim):
                forces[component, nodes.index(self.node) * 2 * dim + coordinate] = 1.0
        return forces


class ConstantForces:
    """Constant loads on nodes of a cable, which may be set by their numbers."""

    def __init__(self, cable: Cable, nodes: Sequence[int], loads: Sequence[NodalLoad]) -> None:
        """nodes: numbers of the nodes of the cable.   loads: without functions."""
        ends = np.cumsum([0, *(len(load.constant) for load in loads)]).tolist()
        self._rows = {
            load.number: (load, slice(*own)) for load, own in zip(loads, pairwise(ends), strict=True)
        }
        self._patterns = np.zeros((ends[-1], cable.reference.size))
        self._values = np.zeros(ends[-1])
        for load, (first, end) in zip(loads, pairwise(ends), strict=True):
            self._patterns[first:end] = load.unit_forces(cable, nodes)
            self._values[first:end] = load.constant
        are_in_space = [
            load.is_in_space(k, cable.dimension) for load in loads for k in range(len(load.constant))
        ]
        self._out_of_plane = [row for row, is_there in enumerate(are_in_space) if not is_there]
        self._owners = [load for load in loads for _ in load.constant]

    def change(self, values: Mapping[int, Sequence[float]]) -> set[int]:
        """Set loads to (m,) as in the mbs, by their numbers; returns those that are forces on this cable."""
        found = self._rows.keys() & values
        for number in found:
            load, own = self._rows[number]
            self._values[own] = [load.scale * x for x in values[number]]
        return found

    @property
    def force(self) -> Array:
        """(n_dof,) generalised force [N, Nm].

        Raises:
            SceneError: a load has a component out of the plane of its cable.
        """
        for row in self._out_of_plane:
            if self._values[row]:
                raise out_of_plane(self._owners[row], self._values[row])
        return self._values.dot(self._patterns)


def out_of_plane(load: Any, value: float) -> SceneError:
    """What is said of a load, nodal or a weight, whose z component a planar cable does not take."""
    return SceneError(
        f"load on {load.place} has the z component {value:g} {load.unit}, but its cable is planar: create "
        "the cable with dimension=3."
    )
