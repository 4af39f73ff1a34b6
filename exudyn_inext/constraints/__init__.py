"""Holonomic constraints c(q, t) = 0 of a cable, Eqs. (18)-(20).

The solver enforces them through the structure of the chain (see `cable.saddle_point`); here they are
quadratic forms, for consistency checks, statics and as the oracle of the tests. A kind that is a link has a
file with the function that makes it, and needs nothing else.
"""

from collections.abc import Sequence

from ..arrays import Array
from ..cable.cable import Cable
from .kinds import length, links_by_kind, nodal_inextensibility
from .quadratic import Constraints, Kind

__all__ = ["Constraints", "constraints_of_cable", "constraints_of_cables", "kinds_of_cable"]


def constraints_of_cable(cable: Cable) -> Constraints:
    """All constraints of `cable`, see `kinds_of_cable`."""
    return constraints_of_cables([cable], [kinds_of_cable(cable)])


def kinds_of_cable(cable: Cable, slope: Array | None = None) -> list[Kind]:
    """All constraints of `cable`, without redundant ones, sorted by the names of their kinds.

    slope: (dim,) of the first node of a ring, across which the slopes of its ends are joined; None: that of
    the reference.
    """
    kinds = [length(cable), nodal_inextensibility(cable), *links_by_kind(cable, slope)]
    return sorted((kind for kind in kinds if len(kind.constant)), key=lambda kind: kind.name)


def constraints_of_cables(cables: Sequence[Cable], kinds: Sequence[Sequence[Kind]]) -> Constraints:
    """Those of cables of one dimension whose nodes follow each other.   kinds: of each cable."""
    nodes, all_kinds = 0, []
    for cable, own in zip(cables, kinds, strict=True):
        all_kinds += [kind._replace(places=kind.places + 2 * nodes) for kind in own]
        nodes += len(cable.reference)
    return Constraints(all_kinds, (nodes, 2, cables[0].dimension))
