"""A scene as data: the cables of an mbs, their supports and loads, and what else there is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.support_forces import SupportForces
from ..errors import InputError
from ..loads.nodal import NodalLoad
from ..loads.weight import ElementWeight
from .links import MovingCoordinate

CableLoad = NodalLoad | ElementWeight


@dataclass(eq=False)
class CableItem:
    """An inextensible cable in an mbs, as the solver sees it.

    cable: model without supports; see `change`.
    gravity: (dim,) [m/s^2].
    nodes: node numbers in the order of the arc length, each once.
    enforcement: name of the way in which native solvers enforce inextensibility.
    held: (n, 2, dim) coordinates that the ground holds without a constraint object of the mbs.
    shared: nodes of other cables whose position and slope these nodes have, by their numbers.
    left_out: axial stiffness of the native template of a cable that does not stretch [N]; None: not known.
    replaced: native elements in whose place the cable is, by their numbers, with their properties since then.
    """

    cable: Cable
    gravity: Array
    nodes: tuple[int, ...]
    enforcement: str
    held: np.ndarray
    shared: Mapping[int, int] = field(default_factory=dict)
    left_out: float | None = None
    replaced: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def leaves_stretch_out(self) -> bool:
        """Whether it does not stretch, but its template does."""
        return self.left_out is not None and not self.cable.stretches

    @property
    def given_nodes(self) -> tuple[int, ...]:
        """Node numbers that the user knows: shared ones instead of the cable's own."""
        return tuple(self.shared.get(node, node) for node in self.nodes)

    @property
    def node_names(self) -> tuple[int, ...]:
        """(n,) node numbers; the first one of a closed cable comes again at the end."""
        return (*self.nodes, self.nodes[0]) if self.cable.closed else self.nodes

    def change(self, **properties: Any) -> None:
        """Give the cable other properties, for all runs of SolveExplicit that start from now on.

        Raises:
            InputError: items of the mbs were made from the present ones.
        """
        if self.enforcement != "projection":
            raise InputError(
                f"enforcement = {self.enforcement!r}: its native items do not know point masses and drag; "
                "create the cable with enforcement='projection' and move it by SolveExplicit."
            )
        self.cable = replace(self.cable, **properties)


class Reaction(NamedTuple):
    """Where the Lagrange multiplier of a constraint comes from, see `put_reactions`.

    row: of the algebraic equations of the mbs.
    place: of the coordinate (n, 2, dim) that it holds or moves, or of a rod among the links.
    gradient: of the constraint along that coordinate [-]; 0 for a rod.
    """

    row: int
    place: int
    gradient: float = 0.0


def put_reactions(reactions: Sequence[Reaction], forces: SupportForces, multipliers: Array) -> None:
    """Into the multipliers (k, m) of all algebraic equations; of those that hold the same, the first."""
    left = forces.on_coordinates.reshape(len(multipliers), -1).copy()
    for row, place, gradient in reactions:
        if gradient:
            multipliers[:, row] = left[:, place] / gradient
            left[:, place] = 0.0
        else:
            multipliers[:, row] = forces.of_links[:, place]


@dataclass(frozen=True, eq=False)
class CableInScene:
    """A cable with its supports and loads.

    cable: model with supports and links.
    item: the items that it came from.
    indices: (n_dof,) places of its coordinates in the system vector.
    loads: on its nodes, and weights of its elements.
    moving: coordinates that follow a motion.
    reactions: of supports, motions and rods that are objects of the mbs.
    number: of its object.   name: for messages.
    """

    cable: Cable
    item: CableItem
    indices: np.ndarray
    loads: list[CableLoad]
    moving: list[MovingCoordinate]
    reactions: Sequence[Reaction]
    number: int
    name: str

    @property
    def among_others(self) -> "CableInScene":
        """Without the loads that Exudyn evaluates together with those of other items: all but weights."""
        return replace(self, loads=[load for load in self.loads if isinstance(load, ElementWeight)])


@dataclass(frozen=True, eq=False)
class Scene:
    """The inextensible cables of an mbs, and what else it contains.

    foreign: what does not belong to the cables alone: bodies, connectors, joints, other loads.
    own_constraints: numbers of the objects that are supports and links of the cables.
    enforcing: of those by which the cables keep their length under other solvers.
    held: coordinates that other constraints hold, by the numbers of these.
    """

    cables: list[CableInScene]
    foreign: list[str]
    own_constraints: frozenset[int]
    enforcing: list[int]
    held: Mapping[int, "HeldCoordinate"]

    @property
    def evaluated_by_kernels(self) -> tuple[list[int], list[int]]:
        """Cables and constraints that Exudyn must not evaluate beside the kernels; see `switched_off`."""
        return [cable.number for cable in self.cables], self.enforcing


@dataclass(frozen=True, eq=False)
class HeldCoordinate:
    """A native constraint that holds one nodal coordinate at its reference value.

    gradient: of the constraint along it [-].
    """

    node: int
    coordinate: int
    gradient: float = 1.0

    @property
    def nodes(self) -> tuple[int, ...]:
        return (self.node,)
