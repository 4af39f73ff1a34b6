"""Distance: a rigid, massless rod that swings freely holds a node at a distance from a point or a node."""

import numpy as np

from ..cable.link import Link, Motion, rest
from ..checks import require_positive

KIND = "distance"


def hanger(node: int, anchor: Motion, length: float) -> Link:
    """A rod of that length [m] from a fixed or moving anchor to a node."""
    dim = anchor.at(0.0).shape[1]
    require_positive("length of the hanger [m]", length)
    return Link(KIND, (node,), np.array([[1.0, 0.0]]), anchor, np.zeros(dim), length)


def rod(nodes: tuple[int, int], dim: int, length: float) -> Link:
    """A rod of that length [m] between two nodes of one cable in `dim` dimensions."""
    require_positive("length of the rod [m]", length)
    weights = np.array([[1.0, 0.0], [-1.0, 0.0]])
    return Link(KIND, nodes, weights, rest(np.zeros(dim)), np.zeros(dim), length)
