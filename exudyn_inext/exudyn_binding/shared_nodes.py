"""Nodes of cables that have the place and slope of other nodes, which are those that users know, and set."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..scene.model import CableItem


class SharedCoordinates(NamedTuple):
    """Of one such node: where its coordinates are in the system, those of the other one, and references.

    own, shared: (2 dim,) indices.   offset: (2 dim,) references of the other one, less its own [m, -].
    """

    own: Array
    shared: Array
    offset: Array


def shared_coordinates(mbs: Any, items: Iterable[CableItem]) -> list[SharedCoordinates]:
    """Of all nodes of these cables that have the place and slope of other ones."""
    found = []
    for pair in (pair for item in items for pair in item.shared.items()):
        own, shared = (np.asarray(mbs.systemData.GetNodeLTGODE2(node)) for node in pair)
        references = [np.asarray(mbs.GetNodeParameter(node, "referenceCoordinates")) for node in pair]
        found.append(SharedCoordinates(own, shared, references[1] - references[0]))
    return found


def share_changes(nodes: Iterable[SharedCoordinates], now: Sequence[Array], before: Sequence[Array]) -> None:
    """Give nodes what was set of those that they share, unless they were set themselves.

    now, before: displacements and velocities (n,) of the system; of `now`, theirs are set in place.
    """
    for node in nodes:
        for values, old, offset in zip(now, before, (node.offset, 0.0), strict=True):
            is_set = [not np.array_equal(values[k], old[k]) for k in (node.own, node.shared)]
            if is_set == [False, True]:
                values[node.own] = values[node.shared] + offset
