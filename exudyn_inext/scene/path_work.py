"""Work of forces along a way of steps, at whose ends they are known."""

import numpy as np

from ..arrays import Array
from ..compiled import inlined, inlined_kernel, kernel

POSITION, FORCE, WAY, CHANGE, SPEED, THROWN, FLIGHT, SUMS = range(8)
WORK, SCATTER, LACK, ADDED, SCALE, FLOOR, STEPS, BEGINNING = range(8)
FASTER = 1.1  # than it came: so no contact throws a body off, closed or not, with steps that are stable
BEGINNINGS = 4.0  # of a motion, after which mass that is no one's counts
RECENT = 0.98  # of a speed is left of it in the next step


def build_path(size: int) -> Array:
    """Memory of the work of forces on `size` coordinates.

    (8, size or more): POSITION and FORCE at present, WAY and CHANGE of the force in the last step, the recent
    SPEED and the largest one THROWN at, see `_thrown_by`, both as ways of a step, the FLIGHT in a step of the
    frame that sees the ways, and the SUMS over all steps: WORK [J], and its SCATTER [J^2]; the largest LACK
    of the work of a step, relative to the energy that the motion has turned over before, SCALE [J], and the
    largest energy ADDED by mass that is no one's, so, too. That is none below its FLOOR [J]; the STEPS since
    it is some, and how many of them are the BEGINNING, see `expect_energy`.
    """
    return np.zeros((8, max(size, 8)))


def begin_path(path: Array, q: Array, force: Array) -> None:
    """From q (n or more,) on, with the force (n,) there."""
    size = len(force)
    path[:SUMS] = 0.0
    path[SUMS, : ADDED + 1] = 0.0
    path[POSITION, :size], path[FORCE, :size] = q[:size], force


def expect_energy(path: Array, scale: float, floor: float, tolerance: float) -> None:
    """Compare the lacks of work with this energy, or with that of a motion that begins.

    The work of a force that sets in at rest is wrong by 1 / (4 n^2) of the energy after n steps, however
    short they are: n is such that this is less than the tolerance.

    Args:
        path: see `build_path`.   scale: that the motion has turned over [J].   floor: what is none [J].
        tolerance: of the lacks [-].
    """
    beginning = 1.0 + 0.5 / np.sqrt(tolerance)
    path[SUMS, [SCALE, FLOOR, BEGINNING]] = scale, floor, beginning
    path[SUMS, STEPS] = beginning if scale > floor else 0.0


@kernel
def gather(vector, places, force):
    """force (n,) from its places (n,) in a system vector; zero where that is -1."""
    for i in range(len(force)):
        force[i] = vector[places[i]] if places[i] >= 0 else 0.0


@inlined
def _thrown_by(path, i, way, change):
    """The way, if a force that acted once, against the last one, has turned it and made it longer; or 0.

    A contact that closes within a step does so where that is above the stability limit of the closed one.
    """
    before, set_in = path[WAY, i], path[CHANGE, i]
    acted_once = set_in * before < 0.0 and set_in * change < 0.0
    is_thrown = acted_once and way * before < 0.0 and abs(way) > FASTER * path[SPEED, i]
    return abs(way) if is_thrown else 0.0


@kernel
def largest_throw(path, first, last, a, h):
    """Which coordinate from `first` up to `last` was thrown off, or is about to be, at the largest speed.

    path: of whole steps.   a: (n,) accelerations at present.   h: step [s]; 0: what is about to be is none.

    Returns:
        Its number, and the way of the step; 0 if there is none.
    """
    place, largest = first, 0.0
    for i in range(first, last):
        before, ahead = path[WAY, i], path[WAY, i] + h**2 * a[i]
        turns = path[CHANGE, i] * before < 0.0 and ahead * before < 0.0
        thrown = path[THROWN, i]
        if turns and abs(ahead) > FASTER * path[SPEED, i]:
            thrown = max(thrown, abs(ahead))
        if thrown > largest:
            place, largest = i, thrown
        path[THROWN, i] = 0.0
    return place, largest


@inlined_kernel
def follow(path, q, force):
    """Count the work of a step to q (n or more,), where the force (n,) acts, by the trapezoidal rule.

    The rule lacks (f' . q'' - f'' . q') / 12, with the derivatives by the number of steps; that is nothing
    if the force is that of linear springs.
    """
    work, lack = 0.0, 0.0
    for i in range(len(force)):
        way, change = q[i] - path[POSITION, i] - path[FLIGHT, i], force[i] - path[FORCE, i]
        work += (path[FORCE, i] + 0.5 * change) * way
        lack += path[CHANGE, i] * way - change * path[WAY, i]
        path[THROWN, i] = max(path[THROWN, i], _thrown_by(path, i, way, change))
        path[SPEED, i] = max(RECENT * path[SPEED, i], abs(way))
        path[POSITION, i], path[FORCE, i] = q[i], force[i]
        path[WAY, i], path[CHANGE, i] = way, change
    path[SUMS, WORK] += work
    path[SUMS, SCATTER] += (lack / 12.0) ** 2
    _compare(path[SUMS], abs(work), abs(lack) / 12.0)


@inlined
def _compare(sums, work, lack):
    """The lack of a step with the energy turned over before.

    From rest, that grows with the square of the number of steps: what it will be after the beginning counts
    till then.
    """
    scale = sums[SCALE]
    if sums[STEPS] < sums[BEGINNING]:
        scale = max(scale, sums[BEGINNING] ** 2 * work)
    if scale > sums[FLOOR]:
        sums[STEPS] += 1.0
        sums[LACK] = max(sums[LACK], lack / scale)
    sums[SCALE] = max(sums[SCALE], abs(sums[WORK]))


@inlined
def compare_added(path, energy):
    """Of mass that is no one's [J], with the energy turned over before, once the motion has begun.

    Loads that set in at rest leave such energy of 0.3 / n^2 times that of the motion after n steps, of a mass
    that they move against a spring.
    """
    sums = path[SUMS]
    if sums[STEPS] >= BEGINNINGS * sums[BEGINNING] and sums[SCALE] > sums[FLOOR]:
        sums[ADDED] = max(sums[ADDED], energy / sums[SCALE])


def take_sums(path: Array) -> tuple[float, float]:
    """Work [J] and scatter [J^2] since the last call."""
    work, scatter = path[SUMS, WORK], path[SUMS, SCATTER]
    path[SUMS, : ADDED + 1] = 0.0
    return float(work), float(scatter)
