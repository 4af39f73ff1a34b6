"""Guide: the slope of a node is held, its position is free; its nodal constraint (18) falls away."""

import numpy as np

from ..cable.cable import Cable
from .held_nodes import HeldNodes


def of_cable(cable: Cable) -> HeldNodes:
    """All guides of `cable`."""
    nodes = np.flatnonzero(~cable.fixed[:, 0] & cable.fixed[:, 1])
    return HeldNodes("guide", nodes, (1,), cable.reference)
