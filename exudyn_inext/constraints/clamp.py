"""Clamp: position and slope of a node are held; its nodal constraint (18) falls away."""

import numpy as np

from ..cable.cable import Cable
from .held_nodes import HeldNodes


def of_cable(cable: Cable) -> HeldNodes:
    """All clamps of `cable`."""
    nodes = np.flatnonzero(cable.fixed[:, 0] & cable.fixed[:, 1])
    return HeldNodes("clamp", nodes, (0, 1), cable.reference)
