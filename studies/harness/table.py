"""Rows and conclusions as Markdown."""

from collections.abc import Iterable, Sequence
from typing import Any

from .study import Row

COLUMNS = ("case", "N", "h [s]", "CPU [s]", "CPU min [s]", "error max [m]", "error rms [m]")


def markdown_table(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A Markdown table: the first column is text, the others numbers."""
    ruler = ["---"] + ["---:"] * (len(header) - 1)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (header, ruler, *lines))


def rows_table(rows: Iterable[Row]) -> str:
    """All rows; a failed one shows its status instead of figures."""
    return markdown_table(COLUMNS, (_cells(row) for row in rows))


def number(value: float | None, digits: int = 3) -> str:
    """A number to that many significant digits; a hyphen where there is none."""
    return "-" if value is None else f"{value:#.{digits}g}".removesuffix(".")


def cell(value: Any) -> str:
    """A text as it is, a number to three digits."""
    if isinstance(value, float):
        return number(value)
    return "-" if value is None else str(value)


def _cells(row: Row) -> list[str]:
    status = "" if row["status"] == "ok" else f" ({row['status']})".replace("|", "/")
    figures = (row[key] for key in ("cpuSeconds", "cpuSecondsMin", "errorMax", "errorRms"))
    return [
        row["label"] + status,
        str(row["elements"]),
        f"{row['stepSize']:.3g}",
        *(number(value) for value in figures),
    ]
