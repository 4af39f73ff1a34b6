"""Conclusions: the worst figure of some rows, and whether it keeps a bar."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from .store import Row
from .study import Results
from .table import QUICK_NOISE, at_most, groups, number, verdict

CONTROL = "control"
"""How the labels of rows with a fault begin, which has to be found."""
CONTROL_WORDS = ("NOT exceeded, as it should be", "exceeded, as it should be")


@dataclass(frozen=True)
class Bar:
    """A sentence on the worst figure, and whether it keeps a bar.

    rows: their kind, or computes them from the results.   figure: key, or row -> number; None: not measured.
    what: the figure in words; {}: the value of `per`.   bar: number, or key; None: nothing is judged.
    per: rows that agree in this key are judged together; empty: all are.
    over_least: whether figures are over the least one.   is_least: whether the bar is a lower one.
    noise: factor by which the figure of a quick run may be off.   share: of the rows that has to keep it.
    """

    rows: str | Callable[[Results], Sequence[Row]]
    figure: str | Callable[[Row], float | None]
    what: str
    bar: float | str | None = None
    per: str = ""
    over_least: bool = False
    is_least: bool = False
    noise: float = QUICK_NOISE
    share: float = 1.0

    def sentences(self, results: Results) -> Iterator[str]:
        """One for each value of `per`."""
        figure = self.figure if callable(self.figure) else lambda row: row.get(self.figure)
        rows = results.of_kind(self.rows) if isinstance(self.rows, str) else self.rows(results)
        for name, own in (groups(rows, self.per) if self.per else {"": rows}).items():
            known = [(value, row) for row in own if (value := figure(row)) is not None]
            noise = self.noise if results.quick else 1.0
            yield f"{self.what.format(name)}: {self._found(known, noise, name)}."

    def _found(self, known: Sequence[tuple[float, Row]], noise: float, name: str) -> str:
        """The worst figure, where it is if the `name` of the rows does not say it, and the verdict."""
        if not known:
            return "not measured"
        unit = min(value for value, _ in known) if self.over_least else 1.0
        value, row = (min if self.is_least else max)(known, key=lambda one: one[0])
        where = name_of(row)
        found = f"at {'least' if self.is_least else 'most'} {number(value / unit)}"
        found += f" ({where})" if where != name else ""
        if self.bar is None:
            return found
        kept = [self._keeps(one / unit, other, noise) for one, other in known]
        missed, open_ = kept.count(False), kept.count(None)
        allowed = math.floor((1.0 - self.share) * len(kept) + 1e-9)
        is_kept = False if missed > allowed else None if missed + open_ > allowed else True
        words = CONTROL_WORDS if where.startswith(CONTROL) else ("kept", "MISSED")
        said = f"{found}; the bar of {self._bar(row):.4g} is {verdict(is_kept, *words)}"
        by = f" by {missed} of {len(kept)}" if missed and len(kept) > 1 else ""
        return said + (", missed" if is_kept and by else "") + by

    def _bar(self, row: Row) -> float:
        return float(row[self.bar] if isinstance(self.bar, str) else self.bar or 0.0)

    def _keeps(self, value: float, row: Row, noise: float) -> bool | None:
        pair = value, self._bar(row)
        return at_most(*(pair[::-1] if self.is_least else pair), noise)


def conclusions(*bars: Bar) -> Callable[[Results], list[str]]:
    """Of a study: cases that failed, then the sentences of all bars."""

    def conclude(results: Results) -> list[str]:
        lost = [row for row in results.rows if str(row.get("status", "")).startswith("failed")]
        failed = [f"FAILED: {name_of(row)}: {row['status']}" for row in lost]
        return failed + [sentence for bar in bars for sentence in bar.sentences(results)]

    return conclude


def name_of(row: Row) -> str:
    """Which row it is; what its label says is not repeated."""
    keys = ("label", "scene", "elements", "value", "bound")
    known = {key: row[key] for key in keys if row.get(key) is not None}
    if "elements" in known:
        known["elements"] = f"N = {known['elements']}" * ("N = " not in known.get("label", ""))
    texts = [f"{one:g}" if isinstance(one, float) else str(one) for one in known.values()]
    said = [text for i, text in enumerate(texts) if not i or text not in texts[0]]
    return ", ".join(filter(None, [*said, row.get("curvatureMeasure")]))
