"""An earlier report: its documents."""

from collections.abc import Sequence
from pathlib import Path

from exudyn_inext.errors import InputError
from studies.harness.document import Document
from studies.report.gather import QUICK_FOLDER
from studies.report.stored import read


def read_earlier(given: Sequence[Path], quick: bool) -> dict[str, Document]:
    """Name of the study -> document.

    Args:
        given: folders of an earlier report, or NAME.json files of it.
        quick: whether the present report is a quick one; only quick and quick, or full and full compare.

    Raises:
        InputError: one does not exist, holds no results, damaged ones, or only those of the other mode.
    """
    found: dict[str, Document] = {}
    for path in given:
        found |= _of_folder(path, quick) if path.is_dir() else _of_file(path, quick)
    return found


def _of_file(path: Path, quick: bool) -> dict[str, Document]:
    if not path.exists():
        raise InputError(f"--compare '{path}': there is no such folder or file.")
    if path.suffix != ".json":
        raise InputError(
            f"--compare '{path}' is not a report's data: give the folder of an earlier report, or its "
            "NAME.json files."
        )
    document = read(path)
    if document["quick"] != quick:
        raise InputError(
            f"--compare '{path}' is of a {_mode(document['quick'])} run, this report of {_mode(quick)} ones; "
            "only equal modes compare: " + ("leave out --quick." if quick else "give --quick.")
        )
    return {document["study"]: document}


def _of_folder(folder: Path, quick: bool) -> dict[str, Document]:
    """From the folder itself, or from its folder of quick results."""
    inner = folder / QUICK_FOLDER
    for place in (inner, folder) if quick and inner.is_dir() else (folder,):
        documents = [document for path in sorted(place.glob("*.json")) if (document := _document(path))]
        found = {document["study"]: document for document in documents if document["quick"] == quick}
        if found:
            return found
    raise InputError(
        f"--compare '{folder}' holds no results of {_mode(quick)} runs (NAME.json): give the folder of an "
        "earlier report of the same mode."
    )


def _document(path: Path) -> Document | None:
    """None for files of another kind that lie in the same folder."""
    try:
        return read(path)
    except InputError as error:
        if isinstance(error.__cause__, Exception):
            raise
        return None


def _mode(quick: bool) -> str:
    return "quick" if quick else "full"
