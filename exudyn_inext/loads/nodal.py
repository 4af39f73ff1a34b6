"""A generalised force on a node: constant, or a function of time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


def out_of_plane(load: Any, value: float) -> SceneError:
    """What is said of a load, nodal or a weight, whose z component a planar cable does not take."""
    return SceneError(
        f"load on {load.place} has the z component {value:g} {load.unit}, but its cable is planar: create "
        "the cable with dimension=3."
    )
