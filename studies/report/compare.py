"""What became slower, less accurate, or another conclusion than in an earlier report.

Rows are matched, and times divided by the machines' common factor.
"""

import statistics
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from studies.harness import Row
from studies.harness.provenance import code_of, commit_of, differences
from studies.harness.ratios import CONVENTIONAL
from studies.harness.study import Document
from studies.harness.timing import OK

from .quantities import LESS, SLOWER, SPEED, TIME, Quantity, identity, noise, quantity
from .sentences import Pair, Sentences, compare_sentences


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
        names = ("label", "scene", "elements", "value", "curvatureMeasure")
        parts = [self.new.get(name) for name in names[: None if "kind" in self.new else 1]]
        texts = [f"{part:g}" if isinstance(part, float) else str(part) for part in parts if part is not None]
        return ", ".join(dict.fromkeys(texts))

    def figures(self) -> Iterator[tuple[str, Quantity, float, float]]:
        """Key, meaning, then, now: of all that are numbers on both sides."""
        for key in self.new:
            values = self.old.get(key), self.new[key]
            meaning = quantity(self.new, key)
            if meaning and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in values):
                old, new = (max(value, meaning.floor) for value in values)
                if old > 0.0 and new > 0.0:
                    yield key, meaning, old, new

    def changes(self, machines: float) -> Iterator[Change]:
        """machines: the factor of their times."""
        for key, meaning, old, new in self.figures():
            worse = new / old if meaning.better == LESS else old / new
            if meaning.kind in (TIME, SPEED):
                worse /= machines
            allowed = 1.0 + max(noise(meaning, side, key, self.quick) for side in (self.old, self.new))
            yield Change(self.study, self.label, key, meaning.kind, old, new, worse, allowed)

    def statuses(self) -> Iterator[tuple["MatchedRow", str, str]]:
        """(row, old, new) where the status is another one."""
        for key in ("status", "outcome"):
            old, new = (str(side.get(key, OK)).partition(":")[0] for side in (self.old, self.new))
            if old != new:
                yield self, old, new


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
        for key, meaning, old, new in row.figures()
        if meaning.kind == TIME
        and (not native_only or key.startswith("native") or row.new.get("formulation") == CONVENTIONAL)
    ]
    return (statistics.median(factors), len(factors)) if factors else (1.0, 0)


@dataclass(frozen=True)
class Comparison:
    """Two reports beside each other.

    origins: sentences on commits, versions, machines.   matched: their rows.   studies: how many both have.
    factor, times: common factor of all times, and over how many.   natives: the same of native rows.
    changes: of all figures.   sentences: conclusions, study by study.
    """

    origins: list[str]
    matched: Matched
    studies: int
    factor: float
    times: int
    natives: tuple[float, int]
    changes: list[Change]
    sentences: list[Sentences]

    @property
    def slower(self) -> list[Change]:
        """Beyond noise, the worst first."""
        return self._worse(True)

    @property
    def less_accurate(self) -> list[Change]:
        """Beyond noise, the worst first."""
        return self._worse(False)

    def _worse(self, in_speed: bool) -> list[Change]:
        worse = [one for one in self.changes if one.is_worse and (one.kind in SLOWER) is in_speed]
        return sorted(worse, key=lambda change: -change.factor / change.noise)

    @property
    def better(self) -> list[Change]:
        """Beyond noise, the best first."""
        return sorted((change for change in self.changes if change.is_better), key=lambda c: c.factor)

    @property
    def statuses(self) -> list[tuple[MatchedRow, str, str]]:
        """(row, old, new) of rows that fail now, or no longer."""
        return [one for row in self.matched.rows for one in row.statuses()]

    @property
    def flipped(self) -> list[Pair]:
        """Conclusions that have turned from good to adverse or back."""
        return [pair for one in self.sentences for pair in one.flipped]

    @property
    def undecided(self) -> list[Pair]:
        """Conclusions with a verdict on one side only."""
        return [pair for one in self.sentences for pair in one.undecided]

    @property
    def is_worse(self) -> bool:
        """Whether anything is slower, less accurate, failing now, or adverse now."""
        failing = any(old == OK for _, old, _ in self.statuses)
        return failing or any(one.is_worse for one in (*self.changes, *self.flipped))

    @property
    def summary(self) -> list[str]:
        """In sentences."""
        factor, times = self.natives
        native = f" ({factor:.2f} over {times} times of native cables, which run none of this project's code)"
        counted = ("kept", "reworded", "added", "vanished")
        total = {key: sum(getattr(one, key) for one in self.sentences) for key in counted}
        return [
            *self.origins,
            f"{len(self.matched.rows)} rows of {self.studies} studies are in both, {self.matched.added} are "
            f"new, {self.matched.vanished} are gone; {len(self.changes)} figures are compared.",
            f"Times are divided by the factor that all have in common: {self.factor:.2f}, the median over "
            f"{self.times} times{native if times else ''}.",
            f"Beyond noise: {len(self.slower)} figures slower, {len(self.less_accurate)} less accurate or "
            f"limited more, {len(self.better)} better; {len(self.statuses)} rows with another status.",
            f"Conclusions: {len(self.flipped)} FLIPPED, {len(self.undecided)} are undecided on one side; "
            + "{kept} say the same but for their numbers, {reworded} say it of another row, {added} are new, "
            "{vanished} are gone.".format_map(total),
        ]


def compare(old: Mapping[str, Document], new: Mapping[str, Document]) -> Comparison:
    """Two sets of documents, by name of the study."""
    common = [name for name in new if name in old]
    matched = match_rows(old, new)
    factor, times = machine_factor(matched.rows)
    return Comparison(
        origins=_origins([old[name] for name in common], [new[name] for name in common]),
        matched=matched,
        studies=len(common),
        factor=factor,
        times=times,
        natives=machine_factor(matched.rows, native_only=True),
        changes=[change for row in matched.rows for change in row.changes(factor)],
        sentences=[
            compare_sentences(n, old[n].get("conclusions", []), new[n]["conclusions"]) for n in common
        ],
    )


def _origins(old: Sequence[Document], new: Sequence[Document]) -> list[str]:
    """Commits, versions and machines, where they differ."""
    then, now = (_unique(commit_of(code_of(document)) for document in side) for side in (old, new))
    sentences = [f"Both of {then}." if then == now else f"Then {then}, now {now}."]
    pairs = list(zip(old, new, strict=True))
    found = (differences(*map(code_of, pair)) for pair in pairs)
    other = _unique(text.removesuffix("sources").rstrip("; ") for text in found)
    if other:
        sentences.append(f"Versions then and now: {other}.")
    if any(before["machine"] != after["machine"] for before, after in pairs):
        machines = [[document["machine"].items() for document in side] for side in (old, new)]
        then, now = (_unique(", ".join(f"{k} {v}" for k, v in one) for one in side) for side in machines)
        sentences.append(f"Another MACHINE: then {then}, now {now}.")
    return sentences


def _unique(texts: Iterable[str]) -> str:
    return "; ".join(dict.fromkeys(text for text in texts if text))
