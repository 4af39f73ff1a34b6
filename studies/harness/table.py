"""Tables as text: what a report shows of rows."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

COLUMNS = ("case", "N", "h [s]", "CPU [s]", "CPU min [s]", "error max [m]", "error rms [m]")


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


def markdown_table(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A Markdown table: the first column is text, the others numbers."""
    ruler = ["---"] + ["---:"] * (len(header) - 1)
    escaped = ([cell.replace("|", "\\|") for cell in cells] for cells in (header, ruler, *lines))
    return "\n".join("| " + " | ".join(cells) + " |" for cells in escaped)


def rows_table(rows: Iterable[Mapping[str, Any]]) -> TextTable:
    """All rows; a failed one shows its status instead of figures."""
    return TextTable("", COLUMNS, [_cells(row) for row in rows])


def number(value: float | None, digits: int = 3) -> str:
    """A number to that many significant digits; a hyphen where there is none."""
    return "-" if value is None else f"{value:#.{digits}g}".removesuffix(".")


def cell(value: Any) -> str:
    """A text as it is, a number to three digits."""
    if isinstance(value, float):
        return number(value)
    return "-" if value is None else str(value)


def _cells(row: Mapping[str, Any]) -> list[str]:
    status = "" if row["status"] == "ok" else f" ({row['status']})"
    figures = (row[key] for key in ("cpuSeconds", "cpuSecondsMin", "errorMax", "errorRms"))
    return [
        row["label"] + status,
        str(row["elements"]),
        f"{row['stepSize']:.3g}",
        *(number(value) for value in figures),
    ]
