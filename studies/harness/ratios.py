"""Which rows win: cheapest at an accuracy, the front of cost and accuracy, ratios of CPU time.

Ratios are native CPU time over the inextensible cable's: at the paper's settings, and best against best.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .store import Row
from .table import TextTable, at_most, number, timing_noise, verdict_on

CONVENTIONAL, INEXTENSIBLE = "conventional", "inextensible"
DEFAULT, ONE_SETTING, TUNED = "default settings", "one setting", "tuned"
"""How the inextensible rows were chosen: not at all; by one rule for all scenes; for the scene."""
OURS = (DEFAULT, ONE_SETTING, TUNED)
IMPLICIT, EXPLICIT = "native, implicit", "native, explicit"
BY_NATIVE_SOLVERS, PEER = "inextensible, native solvers", "rigid links (MuJoCo)"
HEADER = ("CPU time over that of the inextensible cable", "paper", "here")


def is_implicit(row: Row) -> bool:
    return row["integrator"] in ("generalizedAlpha", "trapezoidal")


def is_explicit(row: Row) -> bool:
    return not is_implicit(row)


def is_explicit_zhai(row: Row) -> bool:
    """The paper's scheme."""
    return bool(row["integrator"].lower() == "zhai")


def by_default(belongs: Callable[[Row], bool]) -> Callable[[Row], bool]:
    """The same with Exudyn's default quadrature of the elastic forces."""
    return lambda row: belongs(row) and row.get("quadrature", "full") == "full"


NATIVES: Mapping[str, Callable[[Row], bool]] = {
    IMPLICIT: is_implicit,
    f"{IMPLICIT}, default quadrature": by_default(is_implicit),
    EXPLICIT: is_explicit,
    f"{EXPLICIT}, default quadrature": by_default(is_explicit),
}
"""Kinds of native rows that the inextensible cable is compared with."""


def family_of(row: Row) -> str:
    """Rows that make up a front together."""
    formulation = str(row["formulation"])
    if formulation == INEXTENSIBLE:
        return formulation if row.get("enforcement", "projection") == "projection" else BY_NATIVE_SOLVERS
    if formulation == CONVENTIONAL:
        return IMPLICIT if is_implicit(row) else EXPLICIT
    return PEER


def kind_of(row: Row) -> tuple[Any, ...]:
    """Rows of the same kind compete with each other."""
    return (row["formulation"], is_explicit(row), row.get("choice"), row.get("quadrature", "full") == "full")


def is_usable(row: Row, error: str = "errorMax") -> bool:
    """Whether the row has both a time and an error."""
    return row["cpuSeconds"] is not None and row[error] is not None


def cheapest(rows: Iterable[Row], error_bound: float) -> Row | None:
    """The usable row of least CPU time with errorMax <= error_bound [m]; None if there is none."""
    candidates = [row for row in rows if is_usable(row) and row["errorMax"] <= error_bound]
    return min(candidates, key=lambda row: row["cpuSeconds"], default=None)


def best(rows: Iterable[Row], bound: float) -> dict[str, Row | None]:
    """The cheapest rows within the bound [m]: ours, by how they were chosen; native ones."""
    kinds: dict[str, list[Row]] = {name: [] for name in (*OURS, *NATIVES)}
    for row in rows:
        natives = [name for name, belongs in NATIVES.items() if belongs(row)]
        ours = {TUNED, row.get("choice", TUNED)} & set(OURS)
        own = {CONVENTIONAL: natives, INEXTENSIBLE: ours}
        for name in own.get(row["formulation"], ()):
            kinds[name].append(row)
    return {name: cheapest(some, bound) for name, some in kinds.items()}


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


@dataclass(frozen=True)
class Ratio:
    """CPU time of native cables over that of the inextensible one.

    what: the native rows.   here: measured; None where one of the times is missing.
    paper: at the paper's settings, what the paper states; None for rows of equal accuracy.
    """

    what: str
    paper: float | None
    here: float | None


def equal_accuracy(rows: Sequence[Row], bounds: Sequence[float]) -> list[Ratio]:
    """Cheapest native rows of each kind over the cheapest inextensible one.   bounds: of both errors [m]."""
    found = []
    for bound in bounds:
        chosen = best(rows, bound)
        for name in NATIVES:
            label = f": {native['label']}" if (native := chosen[name]) else ""
            text = f"cheapest run, {name}, with error <= {bound:g} m{label}"
            found.append(Ratio(text, None, time_ratio(native, chosen[TUNED])))
    return found


def ratio_tables(found: Sequence[Ratio]) -> list[TextTable]:
    """One table, none without ratios."""
    lines = [
        (ratio.what, "" if ratio.paper is None else number(ratio.paper), number(ratio.here))
        for ratio in found
    ]
    return [TextTable("", HEADER, lines)] if found else []


def ratio_sentences(found: Sequence[Ratio], quick: bool) -> list[str]:
    """The strongest native rows of equal accuracy; then the paper's settings, beside the paper.

    quick: whether few rows were run, for a short motion: they decide nothing on the best of their kind.
    """
    words = {None: "equal within noise", True: "a smaller gain", False: "a larger gain"}
    measured = [(ratio.what, ratio.paper, ratio.here) for ratio in found if ratio.here is not None]
    sentences = [
        f"{what}: {number(here)} times the CPU time of the inextensible cable, {number(paper)} in the paper "
        f"({words[at_most(here, paper, timing_noise(quick))]})."
        for what, paper, here in measured
        if paper is not None
    ]
    tuned = [(here, what) for what, paper, here in measured if paper is None]
    if quick or not tuned:
        return sentences
    closest, what = min(tuned, key=lambda one: one[0])
    verdict = verdict_on(1.0, closest, 1.0, "is always cheaper", "is NOT always cheaper")
    equal = (
        f"At equal accuracy, the inextensible cable {verdict}: the closest of {len(tuned)} comparisons is "
        f"{number(closest)} ({what})."
    )
    return [equal, *sentences]
