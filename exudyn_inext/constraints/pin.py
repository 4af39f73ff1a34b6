"""Pin: the position of a node is held, its slope is free to turn."""

import numpy as np

from ..cable.cable import Cable
from .held_nodes import HeldNodes


def of_cable(cable: Cable) -> HeldNodes:
    """All pins of `cable`."""
    nodes = np.flatnonzero(cable.fixed[:, 0] & ~cable.fixed[:, 1])
    return HeldNodes("pin", nodes, (0,), cable.reference)
