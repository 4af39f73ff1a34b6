"""Stored documents: read, checked, and which code and machine they belong to."""

import json
from pathlib import Path
from typing import Any

from exudyn_inext.errors import InputError
from studies.harness.document import KEYS, Document
from studies.harness.provenance import code_versions, provenance


def read(path: Path) -> Document:
    """The document of a study.

    Raises:
        InputError: the file cannot be read, is damaged, or is no document of a study.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InputError(
            f"'{path}' cannot be read ({error}): remove it, or run its study again (python -m studies run "
            f"{path.stem})."
        ) from error
    if not is_document(found):
        raise InputError(
            f"'{path}' is not the result of a study (it needs study, quick, machine, versions, rows): remove "
            "it, or choose another folder."
        )
    return dict(found)


def is_document(found: Any) -> bool:
    """Whether it has what the document of any study has, and in the right form."""
    return (
        isinstance(found, dict)
        and isinstance(found.get("study"), str)
        and isinstance(found.get("quick"), bool)
        and isinstance(found.get("machine"), dict)
        and isinstance(found.get("versions"), dict)
        and isinstance(found.get("rows"), list)
        and all(isinstance(row, dict) for row in found["rows"])
    )


def lacks(document: Document) -> str:
    """What keeps a document from being shown; empty if nothing does."""
    missing = [key for key in KEYS if key not in document]
    return f"its run was stopped before it was complete: {', '.join(missing)} missing" if missing else ""


def code_of(document: Document) -> dict[str, Any]:
    """What decides whether two documents belong together."""
    return {"versions": document["versions"], "sources": document.get("sources", "unknown")}


def present_code() -> dict[str, Any]:
    """The same of this process."""
    return {"versions": code_versions(), "sources": provenance()["sources"]}


def commit_of(code: dict[str, Any]) -> str:
    """In short: "commit 1a2b3c4d5e with changes"."""
    commit, _, changes = str(code["versions"].get("commit", "unknown")).partition(" ")
    return " ".join(filter(None, ("commit", commit[:10], changes)))


def differences(code: dict[str, Any], other: dict[str, Any]) -> str:
    """What differs besides the commit: packages, sources."""
    names = sorted(code["versions"].keys() | other["versions"].keys())
    which = [
        f"{name} {code['versions'].get(name, 'none')}, {other['versions'].get(name, 'none')}"
        for name in names
        if name != "commit" and code["versions"].get(name) != other["versions"].get(name)
    ]
    return "; ".join(which + (["sources"] if code["sources"] != other["sources"] else []))
