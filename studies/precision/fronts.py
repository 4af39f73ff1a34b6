"""What an accuracy costs: which rows form a front together, and what is read off between its neighbours."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from studies.harness import Row, column
from studies.harness.ratios import (
    BY_NATIVE_SOLVERS,
    EXPLICIT,
    IMPLICIT,
    INEXTENSIBLE,
    NATIVES,
    PEER,
    family_of,
    front,
    is_usable,
)

FAMILIES = (INEXTENSIBLE, BY_NATIVE_SOLVERS, IMPLICIT, EXPLICIT, PEER)
OTHERS = FAMILIES[1:]


def _within(family: str, belongs: Callable[[Row], bool] = lambda row: True) -> Callable[[Row], bool]:
    return lambda row: family_of(row) == family and belongs(row)


OPPONENTS = {name: _within(name.partition(", default")[0], belongs) for name, belongs in NATIVES.items()} | {
    name: _within(name) for name in (PEER, BY_NATIVE_SOLVERS)
}
"""What the inextensible cable, moved by explicit steps, is compared with."""


def members(rows: Sequence[Row], family: str) -> list[Row]:
    """The rows of a family, in their order."""
    return [row for row in rows if family_of(row) == family]


def method_of(row: Row) -> str:
    """Integrator of an inextensible row, with what makes a scheme of its own."""
    if family_of(row) == BY_NATIVE_SOLVERS:
        return f"{row['enforcement']}, {row['integrator']}"
    name = row["integrator"] + (" with corrector" if row.get("corrector") else "")
    return name + (", mass scaling" if row.get("massScaling") else "")


# ---------------------------------------------------------------------------------------- reading


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
        return np.array(column(self.rows, "errorMax"))

    @property
    def seconds(self) -> np.ndarray:
        return np.array(column(self.rows, "cpuSeconds"))


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


def read(found: Front, bound: float) -> Reading:
    """CPU time at an error of `bound` [m], on the line through the neighbours on logarithmic scales."""
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
    """CPU time of the opponent over one's own at an error of `bound` [m]; None outside of either front."""
    slow, quick = read(opponent, bound).seconds, read(own, bound).seconds
    return None if slow is None or quick is None else slow / quick
