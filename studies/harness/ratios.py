"""Ratios of CPU time over the inextensible cable's: at the paper's settings, and best against best."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .front import cheapest, time_ratio
from .study import Row
from .table import markdown_table, number

HEADER = ("CPU time over that of the inextensible cable", "paper", "here")

Line = tuple[str, str, str]


@dataclass(frozen=True)
class Comparison:
    """The cheapest native row of a kind against the cheapest inextensible one.

    kind: names the native rows.   belongs: whether a native row is one of them.
    bound: largest errorMax of both [m].   inextensible_bound: a smaller one for the inextensible row.
    """

    kind: str
    belongs: Callable[[Row], bool]
    bound: float
    inextensible_bound: float | None = None

    @property
    def text(self) -> str:
        closer = self.inextensible_bound
        ours = "" if closer is None else f", inextensible <= {closer:g} m"
        return f"cheapest native {self.kind} with error <= {self.bound:g} m{ours}"


def ratio_table(
    rows: Sequence[Row], paper_seconds: Mapping[str, float], proposed: str, comparisons: Sequence[Comparison]
) -> str:
    """All ratios as Markdown.

    Args:
        rows: what was measured.
        paper_seconds: label -> the paper's CPU time [s] of the row that repeats it.
        proposed: the label among them that the others are divided by.
        comparisons: of the tuned rows.
    """
    lines = _paper_ratios(rows, paper_seconds, proposed)
    return markdown_table(HEADER, lines + [_tuned_ratio(rows, comparison) for comparison in comparisons])


def _paper_ratios(rows: Sequence[Row], paper_seconds: Mapping[str, float], proposed: str) -> list[Line]:
    by_label = {row["label"]: row for row in rows}
    return [
        (
            label,
            number(seconds / paper_seconds[proposed]),
            number(time_ratio(by_label.get(label), by_label.get(proposed))),
        )
        for label, seconds in paper_seconds.items()
        if label != proposed
    ]


def _tuned_ratio(rows: Sequence[Row], comparison: Comparison) -> Line:
    inextensible = [row for row in rows if row["formulation"] == "inextensible"]
    native = [row for row in rows if row["formulation"] == "conventional" and comparison.belongs(row)]
    best = cheapest(native, comparison.bound)
    name = f": {best['label']}" if best else ""
    ratio = time_ratio(best, cheapest(inextensible, comparison.inextensible_bound or comparison.bound))
    return (comparison.text + name, "", number(ratio))
