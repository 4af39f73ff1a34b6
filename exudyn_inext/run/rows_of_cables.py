"""Cables in a row: where one ends with the place and slope of the next, bending waves pass on.

A cable in two pieces, as where its section changes, has the waves of one, and a short piece none of its own.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable, Section
from ..scene.model import CableInScene


class Row(NamedTuple):
    """Elements of the row that a cable is part of.

    lengths: (m,) l [m].   times: (m,) l^2 sqrt(rho_A / EI), of bending waves [s].   own: place of its own.
    """

    lengths: Array
    times: Array
    own: slice


def rows_of(cables: Sequence[CableInScene]) -> list[Row]:
    """The row of each cable of a scene."""
    following = _following(cables)
    found: dict[int, Row] = {}
    begins = set(range(len(cables))) - set(following.values())
    for k in (*begins, *range(len(cables))):  # rings begin anywhere
        row: list[int] = []
        while k not in found and k not in row:
            row.append(k)
            k = following.get(k, k)
        found |= dict(zip(row, _in_row([cables[j].cable for j in row]), strict=True)) if row else {}
    return [found[k] for k in range(len(cables))]


def _following(cables: Sequence[CableInScene]) -> dict[int, int]:
    """Which cable follows which: no other one has the node between them."""
    nodes = {k: one.item.given_nodes for k, one in enumerate(cables) if not one.cable.closed}
    number = Counter(node for one in cables for node in one.item.given_nodes)
    starts = {given[0]: k for k, given in nodes.items()}
    ends = ((k, given[-1]) for k, given in nodes.items())
    return {k: starts[node] for k, node in ends if number[node] == 2 and node in starts}


def _in_row(cables: Sequence[Cable]) -> Iterator[Row]:
    lengths = [cable.element_lengths for cable in cables]
    ends = np.cumsum(list(map(len, lengths)))
    times = [_slowness(cable.section) * cable.element_lengths**2 for cable in cables]
    for end, own in zip(ends, lengths, strict=True):
        yield Row(np.concatenate(lengths), np.concatenate(times), slice(end - len(own), end))


def _slowness(section: Section) -> float:
    return math.sqrt(section.mass_per_length / section.bending_stiffness)
