"""Numbers of springs, loads and their points that change along a line while steps are taken."""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..compiled import inlined, kernel

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


def with_room(ramps: Ramps, number: int) -> Ramps:
    """The same ones, or such with memory for so many numbers."""
    if number <= len(ramps.kind):
        return ramps
    (kind, place), (before, value) = np.zeros((2, 2 * number), np.int64), np.zeros((2, 2 * number))
    return ramps._replace(kind=kind, place=place, before=before, value=value)


class Numbers(NamedTuple):
    """kind, place: (K,) of which records, and where among them.   before: (K,) memory for their values."""

    kind: np.ndarray
    place: np.ndarray
    before: Array


@kernel
def note_numbers(ramps, kind, place, before):
    """Write the present values of `Numbers` to `before`."""
    for k in range(len(kind)):
        before[k] = _number(ramps, kind[k], place[k])


@kernel
def begin_ramps(ramps, kind, place, before):
    """Let those of `Numbers` that are not what they were `before` change along lines.

    Places of whole numbers, such as -1, are no number when they are read as a real one.
    """
    number = 0
    for k in range(len(kind)):
        value = _number(ramps, kind[k], place[k])
        if value != before[k] and value == value:
            ramps.kind[number], ramps.place[number] = kind[k], place[k]
            ramps.before[number], ramps.value[number] = before[k], value
            number += 1
    ramps.number[0] = number


@inlined
def _number(ramps, kind, place):
    if kind == CONNECTORS:
        return ramps.connectors[place]
    if kind == LINEAR_FORCES:
        return ramps.linear_forces[place]
    if kind == LOADS:
        return ramps.loads[place]
    return ramps.points[place]


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
