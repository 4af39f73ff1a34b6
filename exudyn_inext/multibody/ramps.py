"""Numbers of springs, loads and their points that change along a line while steps are taken."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import inlined

CONNECTORS, LINEAR_FORCES, LOADS, POINTS = range(4)


class Ramps(NamedTuple):
    """connectors, linear_forces, loads, points: all numbers of these records, in place.

    number: (1,) of those that change.   kind, place: (K,) of which records, and where among them.
    before, value: (K,) at the start, and at the end.
    """

    connectors: Array
    linear_forces: Array
    loads: Array
    points: Array
    number: np.ndarray
    kind: np.ndarray
    place: np.ndarray
    before: Array
    value: Array


def ramps_of(*records: Any) -> Ramps:
    """None yet.   records: connectors, linear forces, loads, points."""
    connectors, linear_forces, loads, points = (own.view(np.float64) for own in records)
    (kind, place), (before, value) = np.zeros((2, 0), np.int64), np.zeros((2, 0))
    number = np.zeros(1, np.int64)
    return Ramps(connectors, linear_forces, loads, points, number, kind, place, before, value)


def with_ramps(ramps: Ramps, found: Sequence[tuple[int, Any, Any, Any]]) -> Ramps:
    """The same ones, or such with more memory, with these numbers.

    found: kind; (k,) places, values before, values.
    """
    number = sum(len(places) for _, places, _, _ in found)
    if number > len(ramps.kind):
        (kind, place), (before, value) = np.zeros((2, 2 * number), np.int64), np.zeros((2, 2 * number))
        ramps = ramps._replace(kind=kind, place=place, before=before, value=value)
    first = 0
    for records, *columns in found:
        rows = slice(first, first + len(columns[0]))
        ramps.kind[rows] = records
        for memory, own in zip((ramps.place, ramps.before, ramps.value), columns, strict=True):
            memory[rows] = own
        first = rows.stop
    ramps.number[0] = number
    return ramps


@inlined
def follow_ramps(ramps, functions):
    """Set all numbers that change.   functions: (F,) of time; the last one is the share that is missing."""
    for k in range(ramps.number[0]):
        missing = functions[len(functions) - 1]
        value = missing * ramps.before[k] + (1.0 - missing) * ramps.value[k]
        if ramps.kind[k] == CONNECTORS:
            ramps.connectors[ramps.place[k]] = value
        elif ramps.kind[k] == LINEAR_FORCES:
            ramps.linear_forces[ramps.place[k]] = value
        elif ramps.kind[k] == LOADS:
            ramps.loads[ramps.place[k]] = value
        else:
            ramps.points[ramps.place[k]] = value
