"""Committed results: what each study measured last, reduced to what pages show."""

import json
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from exudyn_inext import InputError
from studies.harness import Row
from studies.harness.provenance import ROOT, commit_of
from studies.harness.store import plain, write_text
from studies.harness.study import KEYS, Document
from studies.report.documents import read

FOLDER = ROOT / "docs" / "figures"
FORMAT = 1
MOST_LINES = 64  # of a table; longer ones are in what the study itself writes
COMPARISONS = ("table1", "table2", "ring", "table3")
KINDS = {name: ("",) for name in COMPARISONS} | {
    "coupled": ("reference", "best", "large"),
    "scene_cost": ("cost",),
    "work_precision": ("speedUp",),
}
"""Study -> kinds of rows that pages are made of."""
ROW_KEYS = {
    "kind", "label", "formulation", "integrator", "elements", "stepSize", "steps", "cpuSeconds", "errorMax",
    "errorHalved", "choice", "quadrature", "forceSeconds", "status", "scene", "bound", "error", "settings",
    "startSeconds", "cables", "springs", "points", "bodies", "joints", "microseconds", "startMilliseconds",
    "stepMilliseconds", "megabytes", "opponent", "ratio",
}  # fmt: skip
TIMES = ("cpuSeconds", "microseconds")


def reduced(documents: Sequence[Document], provisional: str = "") -> Document:
    """What is committed of the runs of one study: the last one, and the spread of their times.

    Args:
        documents: of the runs.   provisional: why the figures are to be measured again; empty: they are not.
    """
    last = documents[-1]
    kept = {key: last[key] for key in (*KEYS, "paper") if key in last}
    tables = [table for table in last["tables"] if len(table["lines"]) <= MOST_LINES]
    more = {"rows": _rows(last), "tables": tables, "provisional": provisional}
    return {"format": FORMAT, **kept, **more, "repeated": spread([_rows(one) for one in documents])}


def _rows(document: Document) -> list[Row]:
    kinds = KINDS.get(document["study"], ())
    chosen = [row for row in document["rows"] if row.get("kind", "") in kinds]
    kept = [{key: value for key, value in row.items() if key in ROW_KEYS} for row in chosen]
    return [{key: float(f"{x:.4g}") if isinstance(x, float) else x for key, x in row.items()} for row in kept]


def spread(runs: Sequence[Sequence[Row]]) -> Row | None:
    """How far the times of repeated runs differ, over their median: in the median row, and at most."""
    if len(runs) < 2 or len({len(rows) for rows in runs}) > 1:
        return None
    found = [[row.get(key) for row in rows] for key in TIMES for rows in zip(*runs, strict=True)]
    shares = [(max(times) - min(times)) / statistics.median(times) for times in found if None not in times]
    spread = {"median": statistics.median(shares), "largest": max(shares)} if shares else None
    return spread and {"runs": len(runs), **spread}


def store(document: Document, folder: Path = FOLDER) -> Path:
    """Write a reduced document, one row a line."""
    path = folder / f"{document['study']}.json"
    entries = (f" {json.dumps(key)}: {_lines(value)}" for key, value in plain(document).items())
    write_text(path, "{\n" + ",\n".join(entries) + "\n}\n")
    return path


def _lines(value: Any) -> str:
    """One line an item of a list."""
    if not (isinstance(value, list) and value):
        return json.dumps(value)
    return "[\n" + ",\n".join(f"  {json.dumps(item)}" for item in value) + "\n ]"


@dataclass(frozen=True)
class Figures:
    """The committed results.   folder: of the files."""

    folder: Path = FOLDER

    @cached_property
    def all(self) -> Mapping[str, Document]:
        """Study -> document."""
        return {path.stem: self._read(path) for path in sorted(self.folder.glob("*.json"))}

    def __getitem__(self, name: str) -> Document:
        """The document of a study.

        Raises:
            InputError: the file is missing, or of another format.
        """
        if name not in self.all:
            raise InputError(
                f"'{self.folder / name}.json' is missing, and pages are made of it: "
                f"python -m studies remake {name}"
            )
        return self.all[name]

    @staticmethod
    def _read(path: Path) -> Document:
        found = read(path)
        if found.get("format") != FORMAT:
            raise InputError(
                f"'{path}' has format {found.get('format')}, these pages need {FORMAT}: "
                f"python -m studies remake {path.stem}"
            )
        return found

    def rows(self, name: str) -> list[Row]:
        return list(self[name]["rows"])

    def note(self, name: str) -> str:
        """Whether the figures of a study are older than the newest ones, or provisional."""
        newest, why = (
            commit_of(max(self.all.values(), key=lambda one: str(one["date"]))),
            self[name]["provisional"],
        )
        age = f" Older than the newest results ({newest})." if commit_of(self[name]) != newest else ""
        return age + (f" Provisional: {why}." if why else "")

    def origin(self, *names: str) -> str:
        """Where figures come from: date, commit, machine; which of them are older, or provisional."""
        newest = commit_of(max(self.all.values(), key=lambda one: str(one["date"])))
        by_code: dict[str, list[str]] = {}
        for name in names:
            by_code.setdefault(f"{self[name]['date'][:10]}, {commit_of(self[name])}", []).append(name)
        parts = [f"{', '.join(f'`{name}`' for name in own)}: {code}" for code, own in by_code.items()]
        said = f"Measured: {'; '.join(parts)}. {_machines([self[name] for name in names])}."
        if older := [name for name in names if commit_of(self[name]) != newest]:
            said += f" Older than the newest results ({newest}): {', '.join(older)}."
        notes = dict.fromkeys(f"{self[name]['provisional']}" for name in names if self[name]["provisional"])
        return said + "".join(f" Provisional: {note}." for note in notes)


def _machines(documents: Sequence[Document]) -> str:
    return "; ".join(
        dict.fromkeys(
            f"{one['machine']['cpu']}, {one['machine']['cores']} cores, Python {one['versions']['python']}, "
            f"Exudyn {one['versions']['exudyn']}"
            for one in documents
        )
    )


Block = Callable[[Figures], str]
