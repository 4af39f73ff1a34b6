"""Which rows win: cheapest at an accuracy, the front of cost and accuracy, ratios of CPU time.

Ratios are native CPU time over the inextensible cable's: at the paper's settings, and best against best.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from .store import Row
from .table import column

CONVENTIONAL, INEXTENSIBLE = "conventional", "inextensible"
DEFAULT, ONE_SETTING, TUNED = "default settings", "one setting", "tuned"
"""How the inextensible rows were chosen: not at all; by one rule for all scenes; for the scene."""
OURS = (DEFAULT, ONE_SETTING, TUNED)
IMPLICIT, EXPLICIT = "native, implicit", "native, explicit"
BY_NATIVE_SOLVERS, PEER = "inextensible, native solvers", "rigid links (MuJoCo)"
BY_DEFAULT = ", default quadrature"
"""Of the elastic forces, as Exudyn has it."""
NATIVES = (IMPLICIT, IMPLICIT + BY_DEFAULT, EXPLICIT, EXPLICIT + BY_DEFAULT)
"""Kinds of native rows that the inextensible cable is compared with."""
OPPONENTS = (*NATIVES, PEER, BY_NATIVE_SOLVERS)
"""What the inextensible cable, moved by explicit steps, is compared with."""


def family_of(row: Row) -> str:
    """Rows that make up a front together."""
    formulation = str(row["formulation"])
    if formulation == INEXTENSIBLE:
        return formulation if row.get("enforcement", "projection") == "projection" else BY_NATIVE_SOLVERS
    if formulation == CONVENTIONAL:
        return IMPLICIT if row["integrator"] in ("generalizedAlpha", "trapezoidal") else EXPLICIT
    return PEER


def kinds_of(row: Row) -> tuple[str, ...]:
    """Its family; of ours, how it was chosen; of native rows, whether the quadrature is the default one."""
    family = family_of(row)
    if family == INEXTENSIBLE:
        return family, TUNED, row.get("choice", TUNED)
    is_default = family in NATIVES and row.get("quadrature", "full") == "full"
    return (family, family + BY_DEFAULT) if is_default else (family,)


def members(rows: Iterable[Row], kind: str) -> list[Row]:
    """The rows of a kind, in their order."""
    return [row for row in rows if kind in kinds_of(row)]


def is_usable(row: Row, error: str = "errorMax") -> bool:
    """Whether the row has both a time and an error."""
    return row["cpuSeconds"] is not None and row[error] is not None


def cheapest(rows: Iterable[Row], error_bound: float) -> Row | None:
    """The usable row of least CPU time with errorMax <= error_bound [m]; None if there is none."""
    candidates = [row for row in rows if is_usable(row) and row["errorMax"] <= error_bound]
    return min(candidates, key=lambda row: row["cpuSeconds"], default=None)


def best(rows: Sequence[Row], bound: float) -> dict[str, Row | None]:
    """The cheapest rows within the bound [m]: ours, by how they were chosen; native ones."""
    return {name: cheapest(members(rows, name), bound) for name in (*OURS, *NATIVES)}


def front(rows: Iterable[Row], error: str = "errorMax") -> list[Row]:
    """The rows that no other one beats in both time and error, cheapest first.   error: its key."""
    kept: list[Row] = []
    for row in sorted((row for row in rows if is_usable(row, error)), key=lambda row: row["cpuSeconds"]):
        if not kept or row[error] < kept[-1][error]:
            kept.append(row)
    return kept


def time_ratio(slow: Row | None, quick: Row | None) -> float | None:
    """CPU time of `slow` over that of `quick`; None where a time is missing."""
    if slow is None or quick is None or not slow["cpuSeconds"] or not quick["cpuSeconds"]:
        return None
    return float(slow["cpuSeconds"] / quick["cpuSeconds"])


def equal_accuracy(rows: Sequence[Row], bounds: Sequence[float]) -> list[Row]:
    """Cheapest native rows of each kind over the cheapest inextensible one.   bounds: of both errors [m].

    Keys: "what", the native row; "here", the ratio, None where a time is missing; "paper": None.
    """
    found = []
    for bound in bounds:
        chosen = best(rows, bound)
        for name in NATIVES:
            label = f": {native['label']}" if (native := chosen[name]) else ""
            text = f"cheapest run, {name}, with error <= {bound:g} m{label}"
            found.append({"what": text, "paper": None, "here": time_ratio(native, chosen[TUNED])})
    return found


def method_of(row: Row) -> str:
    """Integrator of an inextensible row, with what makes a scheme of its own."""
    if family_of(row) == BY_NATIVE_SOLVERS:
        return f"{row['enforcement']}, {row['integrator']}"
    name = row["integrator"] + (" with corrector" if row.get("corrector") else "")
    return name + (", mass scaling" if row.get("massScaling") else "")


READ = "read"
TOO_LOOSE = "looser than its front"
NOT_REACHED = "not reached"
EMPTY = "no rows"
LEAST_GAIN = 0.05  # of the error


def front_of(rows: Iterable[Row], uncertainty: float) -> list[Row]:
    """The usable rows that none beats, cheapest first; errors below the uncertainty [m] are raised to it.

    A row that gains less than LEAST_GAIN over a cheaper one is left out: half a step at the same error of the
    mesh would otherwise make all accuracies beyond it look twice as costly.
    """
    raised = [row | {"errorMax": max(row["errorMax"], uncertainty)} for row in rows if is_usable(row)]
    kept: list[Row] = []
    for row in front(raised):
        if not kept or row["errorMax"] <= (1.0 - LEAST_GAIN) * kept[-1]["errorMax"]:
            kept.append(row)
    return kept


def read(found: Sequence[Row], bound: float) -> tuple[float | None, str]:
    """CPU time [s] at an error of `bound` [m], on the line through the neighbours on logarithmic scales.

    None outside of the front; and why.
    """
    if not found:
        return None, EMPTY
    errors = column(found, "errorMax")
    if bound > errors[0]:
        return None, TOO_LOOSE
    if bound < errors[-1]:
        return None, NOT_REACHED
    at = np.interp(-math.log(bound), -np.log(errors), np.log(column(found, "cpuSeconds")))
    return float(math.exp(at)), READ


def speed_up(opponent: Sequence[Row], own: Sequence[Row], bound: float) -> float | None:
    """CPU time of the opponent over one's own at an error of `bound` [m]; None outside of either front."""
    (slow, _), (quick, _) = read(opponent, bound), read(own, bound)
    return None if slow is None or quick is None else slow / quick
