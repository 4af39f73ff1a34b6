"""What supports and links do to a cable at rest, from the multipliers of the search."""

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.support_forces import SupportForces
from ..constraints import constraints_of_cable
from ..constraints.kinds import HELD
from ..constraints.prescribed_motion import KIND as MOTION


def support_forces(cable: Cable, q: Array, multipliers: Array, time: float) -> SupportForces:
    """At one state q (n, 2, dim).   multipliers: (m,) of all its constraints.   time: of its motions [s]."""
    constraints = constraints_of_cable(cable)
    of_links, held = np.zeros(len(cable.links)), np.zeros(constraints.number)
    for kind in {link.kind for link in cable.links}:
        of_links[[link.kind == kind for link in cable.links]] = multipliers[constraints.rows[kind]]
    for kind in constraints.rows.keys() & {*HELD, MOTION}:
        held[constraints.rows[kind]] = multipliers[constraints.rows[kind]]
    on_coordinates: Array = (constraints.jacobian(q, time).T @ held).reshape(q.shape)
    if cable.closed:
        on_coordinates[0] += on_coordinates[-1]
    return SupportForces(on_coordinates[np.newaxis], of_links[np.newaxis], np.zeros((1, q.size)))
