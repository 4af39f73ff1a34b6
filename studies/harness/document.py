"""What every study stores, whatever its kind: one document, from which all reports are made."""

from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from .machine import machine
from .provenance import code_versions, provenance
from .store import write_json, write_text
from .table import TextTable

Document = dict[str, Any]

KEYS = (
    "study", "question", "quick", "mode", "date", "machine", "versions", "sources", "rows",
    "tables", "notes", "conclusions", "ratios", "pictures",
)  # fmt: skip


def measured(study: str, question: str, quick: bool, rows: Sequence[Any], mode: str = "") -> Document:
    """What is known when the measurement ends.

    Args:
        study, question: of which study.   quick: whether few, cheap cases ran.
        rows: what was measured.   mode: what a quick run is, in words; empty for a full one.
    """
    return {
        "study": study,
        "question": question,
        "quick": quick,
        "mode": mode,
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": code_versions(),
        "sources": provenance()["sources"],
        "rows": rows,
    }


def concluded(
    document: Document,
    tables: Sequence[TextTable],
    conclusions: Sequence[str],
    notes: Sequence[str] = (),
    ratios: Sequence[Mapping[str, Any]] = (),
) -> Document:
    """With what follows from the rows.   notes: what tables are to be read with."""
    return document | {
        "tables": [vars(table) for table in tables],
        "notes": list(notes),
        "conclusions": list(conclusions),
        "ratios": list(ratios),
    }


def store(output: Path, document: Document, pictures: Sequence[Path] | None = None) -> str:
    """Write NAME.json, and, once the pictures are drawn, NAME.md; return that report without its pictures.

    A document is complete when it has all KEYS: that of a study that was stopped is not.
    """
    if pictures is not None:
        document = document | {"pictures": [picture.name for picture in pictures]}
    write_json(output / f"{document['study']}.json", document)
    if pictures is None:
        return ""
    report = _report(document)
    gallery = "".join(f"\n![{Path(name).stem}]({name})\n" for name in document["pictures"])
    write_text(output / f"{document['study']}.md", report + gallery)
    return report


def _report(document: Document) -> str:
    """Question, tables, notes, conclusions as Markdown."""
    mode = f" ({document['mode']})" if document["mode"] else ""
    tables = [TextTable(**table).markdown for table in document["tables"]]
    paragraphs = [f"# {document['study']}{mode}", document["question"], *tables, *document["notes"]]
    sentences = "\n".join(f"- {sentence}" for sentence in document["conclusions"])
    return "\n\n".join([*paragraphs, sentences]) + "\n"
