"""What a study is, and a run of it: measure, conclude, draw, store. Every study stores the same document."""

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from tqdm import tqdm

from .provenance import commit_of, machine, present_code
from .store import Row, prepare_directory, write_json, write_text
from .table import Table, TextTable

Document = dict[str, Any]

KEYS = (
    "study", "question", "quick", "mode", "date", "machine", "versions", "sources", "rows",
    "tables", "notes", "conclusions", "ratios", "pictures",
)  # fmt: skip


@dataclass(frozen=True)
class Results:
    """What was measured.   rows: one a case; most studies give each a "kind".

    entries: what else the document keeps.   notes: what tables are to be read with.
    """

    quick: bool
    rows: Sequence[Row]
    mode: str = "quick: few, short measurements"
    entries: Mapping[str, Any] = field(default_factory=dict)
    notes: Sequence[str] = ()

    def of_kind(self, kind: str) -> list[Row]:
        return [row for row in self.rows if row.get("kind", "") == kind]


def nothing(*given: Any) -> list[Any]:
    """For studies without pictures, conclusions or ratios."""
    return []


@dataclass(frozen=True)
class Study:
    """A question that one command answers.

    measure: quick -> rows; a function, `OnScene` (cases on a scene), or `Benchmark` (series of cases).
    tables: how the rows are shown.   conclusions: sentences that are computed from them.
    pictures: draws into a directory and returns the files.
    ratios: of CPU times, rows with "what", "paper", "here", for the headline of a report.
    not_in_quick_report: why a quick report on all studies leaves it out; empty if it does not.
    minutes: what a full run took on two cores, with its kernels compiled; 0: not known.
    """

    name: str
    question: str
    measure: Callable[[bool], Any]
    conclusions: Callable[[Any], list[str]] = nothing
    tables: Sequence[Table] = ()
    pictures: Callable[[Any, Path], list[Path]] = nothing
    ratios: Callable[[Any], list[Row]] = nothing
    not_in_quick_report: str = ""
    minutes: float = 0.0


def announce(study: str, activity: str) -> None:
    """One line on the error stream, so that the report stays clean; above a progress bar."""
    tqdm.write(f"{study}: {activity}", file=sys.stderr)


def run(study: Study, output: Path, quick: bool = False) -> str:
    """Measure, write NAME.json, NAME.md and pictures into `output`; return the report."""
    prepare_directory(output)
    announce(study.name, "measuring")
    results = study.measure(quick)
    results = results if isinstance(results, Results) else Results(quick, results)
    document = measured(study.name, study.question, results)
    write_json(output / f"{study.name}.json", document)
    document |= concluded(study, results)
    document["pictures"] = [picture.name for picture in study.pictures(results, output)]
    write_json(output / f"{study.name}.json", document)
    report = "\n\n".join([f"# {study.name}", *section(document, output)]) + "\n"
    write_text(output / f"{study.name}.md", report)
    return report


def measured(name: str, question: str, results: Results) -> Document:
    """What is known when the measurement ends; a document is complete when it has all KEYS."""
    return {
        "study": name,
        "question": question,
        "quick": results.quick,
        "mode": results.mode if results.quick else "",
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "machine": machine(),
        **present_code(),
        "rows": results.rows,
        **results.entries,
    }


def concluded(study: Study, results: Results) -> Document:
    """What follows from the rows; tables without rows are left out."""
    tables = [table.text(results) for table in study.tables]
    return {
        "tables": [asdict(table) for table in tables if table.lines],
        "notes": list(results.notes),
        "conclusions": study.conclusions(results),
        "ratios": study.ratios(results),
    }


def bullets(texts: Iterable[str]) -> str:
    """A list, as Markdown."""
    return "\n".join(f"- {text}" for text in texts)


def section(document: Document, folder: Path) -> list[str]:
    """A study as Markdown: question, conclusions, pictures, tables, notes.   folder: of the pictures."""
    pictures = [
        f"![{Path(name).stem.replace('_', ' ')}]({name})"
        if (folder / name).is_file()
        else f"The picture {name} is not there."
        for name in document["pictures"]
    ]
    tables = [TextTable(**stored).markdown for stored in document["tables"]]
    mode = f", {document['mode']}" if document["mode"] else ""
    blocks = [document["question"], bullets(document["conclusions"]), *pictures, *tables, *document["notes"]]
    measured = f"Measured on {document['date']}, {commit_of(document)}{mode}."
    return [*filter(None, blocks), measured + document.get("note", "")]
