"""Holonomic constraints c(q, t) = 0 of a cable, Eqs. (18)-(20).

The solver enforces them through the structure of the chain (see `cable.saddle_point`); here they are
quadratic forms, for consistency checks, statics and as the oracle of the tests. A kind that is a link has a
file with the function that makes it, and needs nothing else.
"""

from ..arrays import Array
from ..cable.cable import Cable
from .kinds import length, links_by_kind, nodal_inextensibility
from .quadratic import Constraints

__all__ = ["Constraints", "constraints_of_cable"]


def constraints_of_cable(cable: Cable, slope: Array | None = None) -> Constraints:
    """All constraints of `cable`, without redundant ones, sorted by the names of their kinds.

    slope: (dim,) of the first node of a ring, across which the slopes of its ends are joined; None: that of
    the reference.
    """
    kinds = [length(cable), nodal_inextensibility(cable), *links_by_kind(cable, slope)]
    present = sorted((kind for kind in kinds if len(kind.constant)), key=lambda kind: kind.name)
    return Constraints(present, cable.reference.shape)
