"""What an accuracy costs: fronts, interpolated between neighbours, and never beyond their ends."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from exudyn_inext.errors import InputError
from studies.harness.front import front, is_usable
from studies.harness.study import Row

READ = "read"
TOO_LOOSE = "looser than its front"
NOT_REACHED = "not reached"
EMPTY = "no rows"
LEAST_GAIN = 0.05  # of the error


@dataclass(frozen=True)
class Front:
    """The rows that none beats, cheapest first: errors fall (n,) [m], CPU times rise (n,) [s].

    uncertainty: of the reference [m]; a smaller error counts as large as this, since no more can be said.
    """

    rows: Sequence[Row]
    uncertainty: float

    @property
    def errors(self) -> np.ndarray:
        return np.array([row["errorMax"] for row in self.rows])

    @property
    def seconds(self) -> np.ndarray:
        return np.array([row["cpuSeconds"] for row in self.rows])


@dataclass(frozen=True)
class Reading:
    """CPU time [s] that an error bound costs, None outside of the front; and why."""

    seconds: float | None
    what: str


def front_of(rows: Iterable[Row], uncertainty: float) -> Front:
    """The front of the usable rows; errors below the uncertainty [m] are raised to it.

    A row that gains less than LEAST_GAIN over a cheaper one is left out: half a step at the same error of the
    mesh would otherwise make all accuracies beyond it look twice as costly.
    """
    raised = [row | {"errorMax": max(row["errorMax"], uncertainty)} for row in rows if is_usable(row)]
    kept: list[Row] = []
    for row in front(raised):
        if not kept or row["errorMax"] <= (1.0 - LEAST_GAIN) * kept[-1]["errorMax"]:
            kept.append(row)
    return Front(kept, uncertainty)


def require_above(bound: float, uncertainty: float) -> None:
    """Raises InputError for an error bound [m] that the reference cannot tell, or that is none."""
    if not (math.isfinite(bound) and bound > 0.0):
        raise InputError(f"error bound {bound!r} m: must be a finite number > 0.")
    if bound < uncertainty:
        raise InputError(
            f"error bound {bound:g} m is below the uncertainty of the reference, {uncertainty:g} m: nothing "
            f"can be said there; ask for {uncertainty:g} m or more, or give the scene a better reference."
        )


def read(found: Front, bound: float) -> Reading:
    """CPU time at an error of `bound` [m], on the line through the neighbours on logarithmic scales.

    Raises:
        InputError: bound below the uncertainty of the reference.
    """
    require_above(bound, found.uncertainty)
    if not found.rows:
        return Reading(None, EMPTY)
    errors = found.errors
    if bound > errors[0]:
        return Reading(None, TOO_LOOSE)
    if bound < errors[-1]:
        return Reading(None, NOT_REACHED)
    at = np.interp(-math.log(bound), -np.log(errors), np.log(found.seconds))
    return Reading(float(math.exp(at)), READ)


def speed_up(opponent: Front, own: Front, bound: float) -> float | None:
    """CPU time of the opponent over one's own at an error of `bound` [m]; None outside of either front.

    Raises:
        InputError: bound below the uncertainty of the reference.
    """
    slow, quick = read(opponent, bound).seconds, read(own, bound).seconds
    return None if slow is None or quick is None else slow / quick


@dataclass(frozen=True)
class Loss:
    """Where an opponent is cheaper: errors from `least` to `largest` [m], and why."""

    least: float
    largest: float
    why: str


CHEAPER = "the opponent is cheaper"
ALONE = "only the opponent is as accurate"


def losses(opponent: Front, own: Front) -> list[Loss]:
    """Ranges of the opponent's rows where it wins; neighbouring ones for the same reason are joined."""
    found: list[Loss] = []
    joined = False
    for row in opponent.rows:
        why = _why_lost(row, own)
        error = row["errorMax"]
        if why and joined and found[-1].why == why:
            found[-1] = Loss(error, found[-1].largest, why)
        elif why:
            found.append(Loss(error, error, why))
        joined = bool(why)
    return found


def _why_lost(row: Row, own: Front) -> str:
    """Empty if the front is as cheap at the row's error; looser than its end, its cheapest row serves."""
    if not own.rows or row["errorMax"] < own.errors[-1]:
        return ALONE
    seconds = read(own, min(row["errorMax"], own.errors[0])).seconds
    assert seconds is not None
    return CHEAPER if row["cpuSeconds"] < seconds else ""
