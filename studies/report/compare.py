"""What became slower, less accurate or adverse since an earlier report."""

import re
import statistics
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from studies.harness import Row
from studies.harness.bars import name_of
from studies.harness.study import Document
from studies.harness.timing import OK


class Quantity(NamedTuple):
    """Figures that are compared.

    keys: of rows.   noise: relative, of full runs; in quick runs QUICK times as large, but where exact.
    is_time: other machines are slower by a common factor.   is_more: whether more is better.
    """

    keys: Sequence[str]
    noise: float
    is_time: bool = False
    is_more: bool = False


QUICK = 2.0
TIME = Quantity(
    ("cpuSeconds", "microseconds", "nativeMicroseconds", "startMilliseconds", "startSeconds", "alone",
     "together", "wallOfAllCores", "median", "cpuMedian", "seconds", "baseSeconds", "achievedSeconds"),
    0.25, is_time=True,
)  # fmt: skip
QUANTITIES = (
    TIME,
    Quantity(("costRatio", "ratioLobatto"), 0.2),
    Quantity(("peakMegabytes", "lastMegabytes"), 0.05),
    Quantity(("errorMax", "errorHalved", "errorRms", "error", "baseError", "referenceUncertainty"), 0.01),
    Quantity(("gain", "realTime"), 0.25, is_more=True),
    Quantity(("found", "hours"), 0.01, is_more=True),
)
IDENTITY = (
    "kind", "label", "what", "scene", "scheme", "cable", "formulation", "integrator", "curvatureMeasure",
    "enforcement", "elements", "dimension", "value", "theta", "zeta", "motion", "endTime",
    "members", "garbageCollection", "cables", "springs", "points", "bodies", "joints",
)  # fmt: skip
"""What a row is about: rows with the same of these are the same row."""
ADVERSE = re.compile(r"\b(?:MISSED|NOT(?: EQUAL)?|DIVERGES|DRIFTS|ABOVE|FAILED|LOSES)\b")
"""How studies say that something is not as it should be: in capitals."""
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?")


@dataclass(frozen=True)
class Change:
    """A figure, then and now.   factor: by how much worse (below 1: better), the machines' part aside.

    noise: factor within which it counts as equal.
    """

    study: str
    row: str
    key: str
    old: float
    new: float
    factor: float
    noise: float


@dataclass(frozen=True)
class Comparison:
    """Two reports beside each other.

    matched, added, vanished: how many rows are in both, and on one side only.
    factor: what all times have in common.   worse, better: figures beyond noise, the farthest first.
    statuses: (row, study, then, now) where these differ.   adverse: (study, conclusion), where it was not.
    """

    matched: int
    added: int
    vanished: int
    factor: float
    worse: list[Change]
    better: list[Change]
    statuses: list[tuple[str, str, str, str]]
    adverse: list[tuple[str, str]]

    @property
    def is_worse(self) -> bool:
        """Whether anything is slower, less accurate, failing now, or adverse now."""
        return bool(self.worse or self.adverse or any(old == OK for _, _, old, _ in self.statuses))

    @property
    def summary(self) -> list[str]:
        """In sentences."""
        return [
            f"{self.matched} rows are in both reports, {self.added} are new, {self.vanished} are gone.",
            f"Times are divided by the factor that all have in common, their median: {self.factor:.2f}.",
            f"Beyond noise: {len(self.worse)} figures worse, {len(self.better)} better; {len(self.statuses)} "
            f"rows with another status; {len(self.adverse)} conclusions that are adverse now.",
        ]


def compare(old: Mapping[str, Document], new: Mapping[str, Document]) -> Comparison:
    """Two sets of documents, by name of the study."""
    before, now = (_rows({name: side[name] for name in old if name in new}) for side in (old, new))
    pairs = [(key[0], before[key], now[key]) for key in now if key in before]
    quick = any(document["quick"] for document in new.values())
    times = [new / old for _, *pair in pairs for _, _, old, new in _figures(*pair, (TIME,))]
    factor = statistics.median(times) if times else 1.0
    changes = sorted((c for pair in pairs for c in _changes(*pair, factor, quick)), key=lambda c: -c.factor)
    return Comparison(
        len(pairs),
        len(now.keys() - before.keys()),
        len(before.keys() - now.keys()),
        factor,
        [c for c in changes if c.factor > c.noise],
        [c for c in reversed(changes) if c.factor < 1.0 / c.noise],
        [status for pair in pairs for status in _statuses(*pair)],
        [one for name in new if name in old for one in _adverse(name, old[name], new[name])],
    )


def _rows(documents: Mapping[str, Document]) -> dict[tuple[Any, ...], Row]:
    """By study and identity; equal ones in their order."""
    seen: Counter[tuple[Any, ...]] = Counter()
    found = {}
    for study, document in documents.items():
        for row in document["rows"]:
            key = (study, *((key, repr(row[key])) for key in IDENTITY if row.get(key) is not None))
            found[(*key, seen[key])] = row
            seen[key] += 1
    return found


def _figures(
    old: Row, new: Row, asked: Sequence[Quantity] = QUANTITIES
) -> Iterator[tuple[str, Quantity, float, float]]:
    """Key, meaning, then, now: of all that are positive numbers on both sides."""
    for quantity in asked:
        for key in quantity.keys:
            values = old.get(key), new.get(key)
            if all(isinstance(x, (int, float)) and x > 0.0 for x in values):
                yield key, quantity, *map(float, values)  # type: ignore[misc]


def _changes(study: str, old: Row, new: Row, machines: float, quick: bool) -> Iterator[Change]:
    for key, quantity, then, now in _figures(old, new):
        worse = then / now if quantity.is_more else now / then / (machines if quantity.is_time else 1.0)
        noise = quantity.noise * (QUICK if quick and quantity.noise > 0.01 else 1.0)
        yield Change(study, name_of(new), key, then, now, worse, 1.0 + noise)


def _statuses(study: str, old: Row, new: Row) -> Iterator[tuple[str, str, str, str]]:
    for key in ("status", "outcome"):
        then, now = (str(side.get(key, OK)).partition(":")[0] for side in (old, new))
        if then != now:
            yield name_of(new), study, then, now


def _adverse(study: str, old: Document, new: Document) -> Iterator[tuple[str, str]]:
    known = {_NUMBER.sub("#", sentence) for sentence in old.get("conclusions", [])}
    for sentence in new["conclusions"]:
        if ADVERSE.search(sentence) and _NUMBER.sub("#", sentence) not in known:
            yield study, sentence
