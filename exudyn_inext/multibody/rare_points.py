"""Points that most scenes do not have, on trees or sliding along cables: scenes call them by address."""

from typing import Any

import numpy as np

from ..called_system import MOST_PROTOCOLS, Called, by_address, call_protocol, called, calls, provide
from ..compiled import protocol
from ..lowered import VECTOR


@protocol
def place_rare_points(system, q):
    """Places, frames and Jacobians at q (n,), and what the points are on; all other points are placed."""


@protocol
def move_rare_points(system, q, v):
    """Velocities at (q, v), (n,) each, accelerations with those of the coordinates zero; all others move."""


PLACING, MOVING = by_address(place_rare_points, VECTOR), by_address(move_rare_points, VECTOR, VECTOR)


@calls(place_rare_points)
def place_called_points(system, q):
    if system.functions[PLACING] != 0:
        call_protocol(system, PLACING, (q,))


@calls(move_rare_points)
def move_called_points(system, q, v):
    if system.functions[MOVING] != 0:
        call_protocol(system, MOVING, (q, v))


NO_POINTS = Called(0, np.zeros(MOST_PROTOCOLS, np.int64))


def called_points(system: Any, number: int) -> Called:
    """The system of that many points, or of what they are on, to be called by address."""
    if not number:
        return NO_POINTS
    points = called(system, place_rare_points, move_rare_points)
    provide(points.functions, system, place_rare_points, move_rare_points)
    return points
