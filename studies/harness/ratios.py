"""Ratios of CPU time over the inextensible cable's: at the paper's settings, and best against best."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .front import cheapest, time_ratio
from .study import Ratio, Row
from .table import TextTable, number
from .verdict import at_most, timing_noise, verdict

INEXTENSIBLE = "inextensible"
HEADER = ("CPU time over that of the inextensible cable", "paper", "here")


@dataclass(frozen=True)
class Comparison:
    """The cheapest native row of a kind against the cheapest inextensible one.

    kind: names the native rows.   belongs: whether a native row is one of them.
    bound: largest errorMax of both [m].   inextensible_bound: a smaller one for the inextensible row.
    over: formulation of the inextensible rows.
    """

    kind: str
    belongs: Callable[[Row], bool]
    bound: float
    inextensible_bound: float | None = None
    over: str = INEXTENSIBLE

    @property
    def text(self) -> str:
        closer = self.inextensible_bound
        ours = "" if closer is None else f", inextensible <= {closer:g} m"
        over = "" if self.over == INEXTENSIBLE else f", over {self.over} alone"
        return f"cheapest native {self.kind} with error <= {self.bound:g} m{ours}{over}"


def ratios(
    rows: Sequence[Row], paper_seconds: Mapping[str, float], proposed: str, comparisons: Sequence[Comparison]
) -> list[Ratio]:
    """All ratios.

    Args:
        rows: what was measured.
        paper_seconds: label -> the paper's CPU time [s] of the row that repeats it.
        proposed: the label among them that the others are divided by.
        comparisons: of the tuned rows.
    """
    at_paper_settings = _paper_ratios(rows, paper_seconds, proposed)
    return at_paper_settings + [_tuned_ratio(rows, comparison) for comparison in comparisons]


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
    sentences = [
        f"{ratio.what}: {number(ratio.here)} times the CPU time of the inextensible cable, "
        f"{number(ratio.paper)} in the paper ({_beside(ratio.here, ratio.paper, timing_noise(quick))})."
        for ratio in found
        if ratio.paper is not None and ratio.here is not None
    ]
    tuned = [ratio for ratio in found if ratio.paper is None and ratio.here is not None]
    return sentences if quick or not tuned else [_equal_accuracy(tuned), *sentences]


def _beside(here: float, paper: float, noise: float) -> str:
    is_less = at_most(here, paper, noise)
    return "equal within noise" if is_less is None else "a smaller gain" if is_less else "a larger gain"


def _equal_accuracy(tuned: Sequence[Ratio]) -> str:
    closest = min(tuned, key=lambda ratio: ratio.here or math.inf)
    found = verdict(at_most(1.0, closest.here or 0.0), "is always cheaper", "is NOT always cheaper")
    return (
        f"At equal accuracy, the inextensible cable {found}: the closest of {len(tuned)} comparisons is "
        f"{number(closest.here)} ({closest.what})."
    )


def _paper_ratios(rows: Sequence[Row], paper_seconds: Mapping[str, float], proposed: str) -> list[Ratio]:
    by_label = {row["label"]: row for row in rows}
    return [
        Ratio(
            label,
            seconds / paper_seconds[proposed],
            time_ratio(by_label.get(label), by_label.get(proposed)),
        )
        for label, seconds in paper_seconds.items()
        if label != proposed
    ]


def _tuned_ratio(rows: Sequence[Row], comparison: Comparison) -> Ratio:
    inextensible = [row for row in rows if row["formulation"] == comparison.over]
    native = [row for row in rows if row["formulation"] == "conventional" and comparison.belongs(row)]
    best = cheapest(native, comparison.bound)
    name = f": {best['label']}" if best else ""
    ratio = time_ratio(best, cheapest(inextensible, comparison.inextensible_bound or comparison.bound))
    return Ratio(comparison.text + name, None, ratio)
