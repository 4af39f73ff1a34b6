"""Which rows win: cheapest at an accuracy, the front of cost and accuracy, ratios of CPU time.

Ratios are native CPU time over the inextensible cable's: at the paper's settings, and best against best.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from .store import Row
from .table import TextTable, at_most, judged, number, timing_noise

CONVENTIONAL, INEXTENSIBLE = "conventional", "inextensible"
HEADER = ("CPU time over that of the inextensible cable", "paper", "here")


def is_implicit(row: Row) -> bool:
    return row["integrator"] in ("generalizedAlpha", "trapezoidal")


def is_explicit(row: Row) -> bool:
    return not is_implicit(row)


def is_explicit_zhai(row: Row) -> bool:
    """The paper's scheme."""
    return bool(row["integrator"].lower() == "zhai")


def kind_of(row: Row) -> tuple[Any, ...]:
    """Rows of the same kind compete with each other."""
    return (row["formulation"], is_explicit(row), row.get("choice"), row.get("quadrature", "full") == "full")


def by_default(belongs: Callable[[Row], bool]) -> Callable[[Row], bool]:
    """The same with Exudyn's default quadrature of the elastic forces."""
    return lambda row: belongs(row) and row.get("quadrature", "full") == "full"


def is_usable(row: Row) -> bool:
    """Whether the row has both a time and an error."""
    return row["cpuSeconds"] is not None and row["errorMax"] is not None


def cheapest(rows: Iterable[Row], error_bound: float) -> Row | None:
    """The usable row of least CPU time with errorMax <= error_bound [m]; None if there is none."""
    candidates = [row for row in rows if is_usable(row) and row["errorMax"] <= error_bound]
    return min(candidates, key=lambda row: row["cpuSeconds"], default=None)


def front(rows: Iterable[Row]) -> list[Row]:
    """The rows that no other one beats in both time and error, cheapest first."""
    kept: list[Row] = []
    for row in sorted(filter(is_usable, rows), key=lambda row: row["cpuSeconds"]):
        if not kept or row["errorMax"] < kept[-1]["errorMax"]:
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


@dataclass(frozen=True)
class Comparison:
    """The cheapest native row of a kind against the cheapest inextensible one, at some accuracies.

    kind: names the native rows.   belongs: whether a native row is one of them.
    bounds: largest errorMax of both [m]; a pair has a smaller one for the inextensible row.
    over: formulation of the inextensible rows.
    """

    kind: str
    belongs: Callable[[Row], bool]
    bounds: Sequence[float | tuple[float, float]]
    over: str = INEXTENSIBLE

    def ratios(self, rows: Sequence[Row]) -> list[Ratio]:
        """Best against best, at each bound."""
        inextensible = [row for row in rows if row["formulation"] == self.over]
        native = [row for row in rows if row["formulation"] == CONVENTIONAL and self.belongs(row)]
        over = "" if self.over == INEXTENSIBLE else f", over {self.over} alone"
        found = []
        for bound in self.bounds:
            theirs, ours = bound if isinstance(bound, tuple) else (bound, bound)
            best = cheapest(native, theirs)
            closer = f", inextensible <= {ours:g} m" if ours < theirs else ""
            name = f": {best['label']}" if best else ""
            text = f"cheapest native {self.kind} with error <= {theirs:g} m{closer}{over}{name}"
            found.append(Ratio(text, None, time_ratio(best, cheapest(inextensible, ours))))
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
    verdict = judged(1.0, closest, 1.0, "is always cheaper", "is NOT always cheaper")
    equal = (
        f"At equal accuracy, the inextensible cable {verdict}: the closest of {len(tuned)} comparisons is "
        f"{number(closest)} ({what})."
    )
    return [equal, *sentences]
