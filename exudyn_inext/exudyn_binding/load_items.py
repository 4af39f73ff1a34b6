"""Loads of an mbs on the nodes of a cable: constant and user-function ones."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array
from .cable_data import CableItem

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """A generalised force on coordinates of one node.

    node: node number.
    coordinates: the nodal coordinate that each component acts on.
    constant: (m,) components [N, Nm].
    history: t -> its components as the user function returns them, or None if the load is constant.
    is_pure: whether the history depends on the time alone, so that it may be asked ahead of time.
    """

    node: int
    coordinates: tuple[int, ...]
    constant: Array
    history: Callable[[float], Any] | None
    is_pure: bool = False

    unit: ClassVar[str] = "N"

    @property
    def place(self) -> str:
        """For messages."""
        return f"node {self.node}"

    def is_in_space(self, component: int, dim: int) -> bool:
        """Whether a component acts on the cable; the z component of a force on a planar one does not."""
        return len(self.coordinates) == 1 or self.coordinates[component] < dim

    def unit_forces(self, item: CableItem) -> Array:
        """(m, n_dof) generalised force per unit of each component; zero for one out of the plane [-]."""
        dim = item.cable.dimension
        forces = np.zeros((len(self.coordinates), item.cable.reference.size))
        for component, coordinate in enumerate(self.coordinates):
            if self.is_in_space(component, dim):
                forces[component, item.nodes.index(self.node) * 2 * dim + coordinate] = 1.0
        return forces


def read_load(mbs: Any, number: int) -> NodalLoad | None:
    """Load `number` of mbs, or None if it is of a kind that is not supported."""
    data = mbs.GetLoad(number)
    marker = mbs.GetMarker(data["markerNumber"])
    kinds = (data["loadType"], marker["markerType"])
    if kinds[0] == "ForceVector" and kinds[1] in _POSITION_MARKERS and not data["bodyFixed"]:
        coordinates: tuple[int, ...] = (0, 1, 2)
        value, user_function = data["loadVector"], data["loadVectorUserFunction"]
    elif kinds == ("Coordinate", "NodeCoordinate"):
        coordinates = (int(marker["coordinate"]),)
        value, user_function = data["load"], data["loadUserFunction"]
    else:
        return None
    return NodalLoad(
        node=int(marker["nodeNumber"]),
        coordinates=coordinates,
        constant=np.atleast_1d(np.asarray(value, dtype=float)),
        history=history_of(mbs, user_function, value),
        is_pure=is_of_time_alone(user_function),
    )


def is_of_time_alone(user_function: Any) -> bool:
    """Whether a load has a user function that says so of itself."""
    return bool(user_function) and getattr(user_function["function"], "dependsOnTimeOnly", False) is True


def history_of(mbs: Any, user_function: Any, value: Any) -> Callable[[float], Any] | None:
    """t -> what the user function of a load returns; None without one.   value: of the load."""
    if not user_function:
        return None
    function = user_function["function"]
    return lambda t: function(mbs, t, value)
