"""Figures of two reports beside each other: rows matched, times divided by the machines' common factor."""

import statistics
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from studies.harness.document import Document
from studies.harness.study import Row

from .quantities import LESS, SLOWER, SPEED, TIME, Quantity, identity, noise, quantity


@dataclass(frozen=True)
class Change:
    """A figure, then and now.   factor: by how much worse (below 1: better), the machines' part aside.

    noise: factor within which it counts as equal.
    """

    study: str
    row: str
    key: str
    kind: str
    old: float
    new: float
    factor: float
    noise: float

    @property
    def is_worse(self) -> bool:
        return self.factor > self.noise

    @property
    def is_better(self) -> bool:
        return self.factor < 1.0 / self.noise


@dataclass(frozen=True)
class MatchedRow:
    """The same row, then and now."""

    study: str
    quick: bool
    old: Row
    new: Row

    @property
    def label(self) -> str:
        """What it is called in a report."""
        names = ("label", "scene", "elements", "value", "curvatureMeasure")[
            : None if "kind" in self.new else 1
        ]
        parts = [self.new.get(name) for name in names]
        return ", ".join(dict.fromkeys(f"{part:g}" if isinstance(part, float) else str(part)
                                       for part in parts if part is not None))  # fmt: skip


@dataclass(frozen=True)
class Matched:
    """rows: on both sides.   added, vanished: how many on one side only."""

    rows: list[MatchedRow]
    added: int
    vanished: int


def match_rows(old: Mapping[str, Document], new: Mapping[str, Document]) -> Matched:
    """Of the studies that both have; rows that occur repeatedly are matched in their order."""
    rows, added, vanished = [], 0, 0
    for study in [name for name in new if name in old]:
        before, now = (_by_identity(study, side[study]["rows"]) for side in (old, new))
        quick = new[study]["quick"]
        rows += [MatchedRow(study, quick, before[key], now[key]) for key in now if key in before]
        added += len(now.keys() - before.keys())
        vanished += len(before.keys() - now.keys())
    return Matched(rows, added, vanished)


def _by_identity(study: str, rows: Sequence[Row]) -> dict[tuple[Any, ...], Row]:
    seen: Counter[tuple[Any, ...]] = Counter()
    found = {}
    for row in rows:
        key = identity(study, row)
        found[(*key, seen[key])] = row
        seen[key] += 1
    return found


def machine_factor(rows: Sequence[MatchedRow], native_only: bool = False) -> tuple[float, int]:
    """Median over all times of new over old, and over how many; 1 without any.

    native_only: of rows that run none of this project's code, so that a change of it does not matter.
    """
    factors = [
        new / old
        for row in rows
        for key, meaning, old, new in _figures(row)
        if meaning.kind == TIME and (not native_only or _is_native(row.new, key))
    ]
    return (statistics.median(factors), len(factors)) if factors else (1.0, 0)


def _is_native(row: Row, key: str) -> bool:
    return key.startswith("native") or row.get("formulation") == "conventional"


def changes(rows: Sequence[MatchedRow], factor: float) -> list[Change]:
    """Of all figures that both sides have.   factor: of the machines."""
    return [_change(row, key, meaning, old, new, factor) for row in rows
            for key, meaning, old, new in _figures(row)]  # fmt: skip


def _figures(row: MatchedRow) -> Iterator[tuple[str, Quantity, float, float]]:
    for key in row.new:
        meaning = quantity(row.new, key)
        if meaning is None:
            continue
        old, new = (max(side[key], meaning.floor) if _is_number(side.get(key)) else 0.0
                    for side in (row.old, row.new))  # fmt: skip
        if old > 0.0 and new > 0.0:
            yield key, meaning, old, new


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _change(row: MatchedRow, key: str, meaning: Quantity, old: float, new: float, machines: float) -> Change:
    worse = new / old if meaning.better == LESS else old / new
    if meaning.kind in (TIME, SPEED):
        worse /= machines
    allowed = max(
        noise(meaning, side, key, row.quick)
        for side in (row.old, row.new)
    )  # fmt: skip
    return Change(row.study, row.label, key, meaning.kind, old, new, worse, 1.0 + allowed)


def is_time(change: Change) -> bool:
    """Whether it is about speed, not accuracy."""
    return change.kind in SLOWER


def statuses(rows: Sequence[MatchedRow]) -> list[tuple[MatchedRow, str, str]]:
    """Rows whose status is another one: (row, old, new)."""
    found = []
    for row in rows:
        for key in ("status", "outcome"):
            old, new = (str(side.get(key, "ok")).partition(":")[0] for side in (row.old, row.new))
            if old != new:
                found.append((row, old, new))
    return found
