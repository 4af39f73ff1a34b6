"""What may be left out, where, and what that saves: over all scenes."""

import statistics
from collections.abc import Sequence

from ..harness.benchmark import Figures
from ..harness.study import Row
from ..harness.table import number
from ..harness.timing import OK

HARMLESS = 1.1  # error over that of the base
CHEAPER, DEARER = 0.95, 1.05  # CPU time over that of the base
BASE_OF_DENSE = "as in the package"


def summary_of(figures: Figures) -> list[Row]:
    """One row a change: 'change', 'verdict', 'harmless', 'elsewhere', 'costRatio' (median)."""
    rows = [*figures.of_kind("change"), *_compared(figures.of_kind("dense"))]
    return [_row(label, rows) for label in dict.fromkeys(row["label"] for row in rows)]


def is_harmless(row: Row) -> bool:
    """Whether the error stays that of the base, or what the reference cannot tell from it."""
    if row.get("error") is None or row.get("baseError") is None:
        return False
    bound = max(HARMLESS * row["baseError"], row["baseError"] + row["uncertainty"])
    return bool(row["error"] <= bound)


def sentences_of(summary: Sequence[Row]) -> list[str]:
    """The changes, verdict by verdict."""
    groups: dict[str, list[str]] = {}
    for row in summary:
        groups.setdefault(row["verdict"], []).append(row["change"])
    return [f"{verdict[0].upper()}{verdict[1:]}: {'; '.join(own)}." for verdict, own in groups.items()]


def _compared(rows: Sequence[Row]) -> list[Row]:
    """Dense variants, each beside the one with everything."""
    bases = {row["elements"]: row for row in rows if row["label"] == BASE_OF_DENSE}
    found = []
    for row in rows:
        base = bases.get(row["elements"], {}).get("error")
        if row["label"] != BASE_OF_DENSE:
            ratio = row["error"] / base if base and row.get("error") is not None else None
            place = f"{row['scene']}, N = {row['elements']}"
            found.append(row | {"scene": place, "baseError": base, "errorRatio": ratio})
    return found


def _row(label: str, rows: Sequence[Row]) -> Row:
    own = [row for row in rows if row["label"] == label]
    harmless = [row["scene"] for row in own if is_harmless(row)]
    elsewhere = [f"{row['scene']} ({_error(row)})" for row in own if not is_harmless(row)]
    costs = [row["costRatio"] for row in own if row.get("costRatio") is not None]
    cost = statistics.median(costs) if costs else None
    return {
        "change": label,
        "verdict": _verdict(len(harmless), len(own), cost),
        "harmless": ", ".join(harmless) or "no scene",
        "elsewhere": ", ".join(elsewhere) or "-",
        "costRatio": cost,
    }


def _verdict(harmless: int, scenes: int, cost: float | None) -> str:
    if not harmless:
        return "harmful everywhere"
    where = "harmless everywhere" if harmless == scenes else "harmless on some scenes"
    if cost is None:
        return f"{where}, cost not measured"
    saves = "cheaper" if cost < CHEAPER else "dearer" if cost > DEARER else "saves nothing"
    return f"{where}, {saves}"


def _error(row: Row) -> str:
    if row.get("errorRatio") is not None:
        return f"{number(row['errorRatio'])} times the error"
    base = row.get("baseOutcome", OK)
    said = str(row.get("outcome", row["status"])) if base == OK else f"the base {base}"
    return said.split(". ")[0]
