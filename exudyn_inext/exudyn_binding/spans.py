"""Supports of a cable, and how far it reaches between them."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..constraints.prescribed_motion import KINDS


def spans_of(cable: Cable, time: float) -> Iterator[tuple[tuple[int, int], float, float]]:
    """Two nodes that are held, the distance of their supports, and how far they reach [m]."""
    arc = np.append(0.0, np.cumsum(cable.element_lengths))
    for (a, here, slack_a), (b, there, slack_b) in combinations(_held_points(cable, time), 2):
        yield (a, b), float(np.linalg.norm(there - here)), abs(arc[b] - arc[a]) + slack_a + slack_b


def _held_points(cable: Cable, time: float) -> list[tuple[int, Array, float]]:
    """(node, point, how far the node may be from it) of pins, clamps, moving supports and hangers."""
    nodes = np.flatnonzero(cable.fixed[:, 0])
    points = [(int(k), cable.reference[k, 0], 0.0) for k in nodes if not (cable.closed and k == nodes[-1])]
    for node in {link.nodes[0] for link in cable.links if link.kind in KINDS}:
        held = [link for link in cable.links if link.kind in KINDS and link.nodes == (node,)]
        if len(held) == cable.dimension:
            points.append((node, sum(link.normal * link.anchor.at(time)[0] for link in held), 0.0))
    hangers = [link for link in cable.links if len(link.nodes) == 1 and np.isfinite(link.length)]
    return points + [(link.nodes[0], link.anchor.at(time)[0], link.length) for link in hangers]
