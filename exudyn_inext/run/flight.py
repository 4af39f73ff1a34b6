"""How fast a scene flies along: the mean velocity of what nothing ties to its surroundings.

Whoever flies with it sees the same motion, so errors are compared with ways and energies as seen from there.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..sparse import Entries


class Flight(NamedTuple):
    """Translations of all that a run moves, as far as it can fly.

    ways: (dim, n) velocities of the coordinates in each of them [-]; (0, n): something ties the run.
    momenta: (dim, n) of these velocities [kg, kg m].
    """

    ways: Array
    momenta: Array

    def along(self, v: Array) -> tuple[Array, Array]:
        """(n,) velocities and momenta of a translation that has the momentum of the velocities v (n,)."""
        mean = np.linalg.solve(self.momenta @ self.ways.T, self.momenta @ v)
        return mean @ self.ways, mean @ self.momenta


def is_tied(cable: Cable) -> bool:
    """Whether supports, other links, or what flows around it act on a cable."""
    return bool(cable.fixed.any() or cable.links or cable.drag)


def flight_of(ways: Array, mass: Entries) -> Flight:
    """See `Flight`.   mass: of all coordinates."""
    rows, columns, values = mass
    momenta = [np.bincount(rows, values * way[columns], len(way)) for way in ways]
    return Flight(ways, np.reshape(momenta, ways.shape))
