"""What supports and links do to a cable at rest, from the multipliers of the search."""

import numpy as np

from ..arrays import Array
from ..cable.border import CLOSURE
from ..cable.cable import Cable
from ..cable.support_forces import SupportForces
from ..constraints import constraints_of_cable
from ..constraints.held_nodes import HeldNodes
from ..constraints.links import LinkConstraint
from ..constraints.prescribed_motion import KIND as MOTION


def support_forces(cable: Cable, q: Array, multipliers: Array, time: float) -> SupportForces:
    """At q (n, 2, dim).   multipliers: (m,) of all its constraints.   time: of its motions [s]."""
    on_coordinates, of_links, first = np.zeros(q.shape), np.zeros(len(cable.links)), 0
    for constraint in constraints_of_cable(cable):
        mine = multipliers[first : first + constraint.number]
        first += constraint.number
        if isinstance(constraint, LinkConstraint) and constraint.name != CLOSURE:
            of_links[[link.kind == constraint.name for link in cable.links]] = mine
        if isinstance(constraint, HeldNodes) or constraint.name == MOTION:
            on_coordinates += (constraint.jacobian(q, time).T @ mine).reshape(q.shape)
    if cable.closed:
        on_coordinates[0] += on_coordinates[-1]
    return SupportForces(on_coordinates, of_links)
