"""Tables and verdicts: which rows and keys a report shows, as text; what was measured against a bar.

There is no verdict where the measurement cannot tell.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from textwrap import dedent
from typing import Any

from .store import Row


@dataclass(frozen=True)
class TextTable:
    """A table that is ready to be shown.   header: one text a column.   lines: cells as texts."""

    title: str
    header: Sequence[str]
    lines: Sequence[Sequence[str]]

    @property
    def markdown(self) -> str:
        """Title, if there is one, and table."""
        table = markdown_table(self.header, self.lines)
        return f"{self.title}\n\n{table}" if self.title else table


@dataclass(frozen=True)
class Table:
    """The rows of one kind in a report.

    columns: "header: key | header: key"; a key alone is its own header.
    rows: computes other rows from the results; None: those that were measured are shown themselves.
    """

    kind: str
    title: str
    columns: str
    rows: Callable[[Any], Sequence[Row]] | None = None

    def text(self, results: Any) -> TextTable:
        """The table of these `Results`."""
        rows = results.of_kind(self.kind) if self.rows is None else self.rows(results)
        columns = [column.rpartition(": ") for column in self.columns.split(" | ")]
        keys = [key for _, _, key in columns]
        lines = [[cell(row.get(key)) for key in keys] for row in rows]
        return TextTable(self.title, [header or key for header, _, key in columns], lines)


def tables(text: str, **rows: Callable[[Any], Sequence[Row]]) -> list[Table]:
    """Tables of lines "kind: title", each followed by indented lines of columns.

    rows: kind -> computes its rows, as in `Table`.
    """
    found = []
    for block in re.split(r"\n(?=\S)", dedent(text).strip()):
        head, *columns = block.split("\n")
        kind, _, title = head.partition(": ")
        found.append(Table(kind, title, " ".join(map(str.strip, columns)), rows.get(kind)))
    return found


def markdown_table(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A Markdown table: the first column is text, the others numbers."""
    ruler = ["---"] + ["---:"] * (len(header) - 1)
    escaped = ([cell.replace("|", "\\|") for cell in cells] for cells in (header, ruler, *lines))
    return "\n".join("| " + " | ".join(cells) + " |" for cells in escaped)


def number(value: float | None, digits: int = 3) -> str:
    """A number to that many significant digits; a hyphen where there is none."""
    return "-" if value is None else f"{value:#.{digits}g}".removesuffix(".")


def percent(share: float) -> str:
    """A share in percent, to two digits, or all before the point: 1 %, 0.1 %, 99.9 %."""
    return f"{100.0 * share:.{3 if share > 0.1 else 2}g} %"


def cell(value: Any) -> str:
    """A text as it is, a number to three digits."""
    return number(value) if value is None or isinstance(value, float) else str(value)


def groups(rows: Iterable[Row], key: str) -> dict[Any, list[Row]]:
    """Value of the key -> its rows, in their order."""
    found: dict[Any, list[Row]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(row)
    return found


def column(rows: Iterable[Row], key: str) -> list[Any]:
    """The key's value in each row."""
    return [row[key] for row in rows]


QUICK_NOISE = 1.5
"""Factor by which a quotient of CPU times from few, short runs may be off either way."""
UNDECIDED = "undecided within noise"


def at_most(value: float, bar: float, noise: float = 1.0) -> bool | None:
    """Whether value <= bar; None if a factor `noise` could turn it.   value, bar: positive."""
    if value <= bar / noise:
        return True
    return False if not value <= bar * noise else None


def verdict(is_kept: bool | None, kept: str = "kept", missed: str = "MISSED") -> str:
    """The words for it."""
    return {None: UNDECIDED, True: kept, False: missed}[is_kept]
