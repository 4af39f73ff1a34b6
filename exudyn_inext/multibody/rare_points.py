"""Points that most scenes do not have, on trees or sliding along cables: scenes call them by address."""

from ..called_system import of_parts
from ..compiled import protocol
from ..lowered import VECTOR


@protocol
def place_rare_points(system, q):
    """Places, frames and Jacobians at q (n,), and what the points are on; all other points are placed."""


@protocol
def move_rare_points(system, q, v):
    """Velocities at (q, v), (n,) each, accelerations with those of the coordinates zero; all others move."""


of_parts(place_rare_points, VECTOR)
of_parts(move_rare_points, VECTOR, VECTOR)
