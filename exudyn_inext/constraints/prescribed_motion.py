"""Prescribed motion: coordinates of a node's position follow a given function of time, Eqs. (27), (28)."""

from collections.abc import Sequence

import numpy as np

from ..cable.link import Link, Motion

MOVING, AT_REST = "prescribed motion", "coordinate"
KINDS = MOVING, AT_REST


def prescribed(node: int, motion: Motion, axes: Sequence[int], of_slope: bool = False) -> list[Link]:
    """The given coordinates (0 for x, ...) of a node's position, or slope, follow `motion`, or rest."""
    dim = motion.at(0.0).shape[1]
    weights = np.array([[0.0, 1.0] if of_slope else [1.0, 0.0]])
    kind = AT_REST if motion.rests else MOVING
    return [Link(kind, (node,), weights, motion, np.eye(dim)[axis]) for axis in axes]
