"""Which coordinates may be moved at once to find a sparse Jacobian by differences.

A. R. Curtis, M. J. D. Powell, J. K. Reid, On the estimation of sparse Jacobian matrices, IMA J. Applied
Mathematics 13 (1974) 117-119. That symmetric ones need fewer: M. J. D. Powell, P. L. Toint, On the estimation
of sparse Hessian matrices, SIAM J. Numerical Analysis 16 (1979) 1060-1074.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np


class Round(NamedTuple):
    """Coordinates that are moved together.

    places: (k,) of them.   rows, columns: (e,) entries of the Jacobian that this tells of.
    """

    places: np.ndarray
    rows: np.ndarray
    columns: np.ndarray


def rounds_of(groups: Iterable[np.ndarray], first_shared: int) -> list[Round]:
    """Rounds in which each row depends on one coordinate at most, of a symmetric Jacobian.

    groups: coordinates of each item, each of which may act on all others of it.
    first_shared: coordinates from this one on are in many groups: rounds of the others leave their rows out.
    """
    reach: dict[int, frozenset[int]] = {}  # rows that a coordinate acts on
    for group in groups:
        own = frozenset(group.tolist())
        alone = frozenset(place for place in own if place < first_shared)
        for place in own:
            rows_of_place = alone if place in alone else own
            reach[place] = reach[place] | rows_of_place if place in reach else rows_of_place
    rounds: list[tuple[list[int], set[int]]] = []
    for place in sorted(reach):
        free = [one for one in rounds if one[1].isdisjoint(reach[place])]
        if not free:
            rounds.append(([], set()))
        places, rows = free[0] if free else rounds[-1]
        places.append(place)
        rows |= reach[place]
    return [_round(places, [sorted(reach[place]) for place in places]) for places, _ in rounds]


def _round(places: list[int], reached: list[list[int]]) -> Round:
    at = np.array(places, dtype=np.int64)
    return Round(at, np.concatenate(reached), np.repeat(at, [len(rows) for rows in reached]))
