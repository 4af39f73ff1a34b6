"""What an inextensible cable in an mbs is, and how it is found there again."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..chain.cable import Cable
from .graphics import cable_graphics


@dataclass(frozen=True, eq=False)
class CableItem:
    """An inextensible cable in an mbs, as the solver sees it.

    cable: model without supports.
    gravity: (dim,) [m/s^2].
    nodes: node numbers in the order of the arc length, each once.
    enforcement: name of the way in which native solvers enforce inextensibility.
    held: (n, 2, dim) coordinates that the ground holds without a constraint object of the mbs.
    """

    cable: Cable
    gravity: Array
    nodes: tuple[int, ...]
    enforcement: str
    held: np.ndarray

    @property
    def node_names(self) -> tuple[int, ...]:
        """(n,) node numbers; the first one of a closed cable comes again at the end."""
        return (*self.nodes, self.nodes[0]) if self.cable.closed else self.nodes


def carrying_graphics(item: CableItem) -> Any:
    """The graphics user function of the cable's object: it also carries the cable's data.

    Every way of enforcement has it, and switching forces or mass of the object off leaves it alone.
    """
    draw = cable_graphics(item.cable, item.node_names)
    draw.cable_item = item
    return draw


def find_cable_item(object_data: dict[str, Any]) -> CableItem | None:
    """The cable behind mbs.GetObject(...) data, or None if the object is something else."""
    if object_data["objectType"] != "GenericODE2":
        return None
    function = object_data["VgraphicsDataUserFunction"]
    return getattr(function["function"], "cable_item", None) if isinstance(function, dict) else None
