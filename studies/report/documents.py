"""All documents of a report: stored ones, those of studies that are run for it, earlier ones."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from exudyn_inext import InputError
from studies.harness.store import prepare_directory
from studies.harness.study import KEYS, Document, Study, announce, run

_FAILED = "FAILED"


@dataclass
class Gathered:
    """documents: name -> what its study stored.   absent: name -> why there is none."""

    documents: dict[str, Document] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)

    @property
    def has_failed(self) -> bool:
        """Whether a study was run, and failed."""
        return any(reason.startswith(_FAILED) for reason in self.absent.values())


def gather(studies: Mapping[str, Study], folder: Path, quick: bool = False, fresh: bool = False) -> Gathered:
    """Read what is stored, whatever commit it is of, and run what is missing, one study after another.

    quick: run all studies, in quick mode.   fresh: run all anew.

    Raises:
        InputError: the folder cannot be written, or holds damaged files.
    """
    prepare_directory(folder)
    found = Gathered()
    for number, (name, study) in enumerate(studies.items(), 1):
        path = folder / f"{name}.json"
        document = read(path) if path.exists() and not (quick or fresh) else None
        if document and not document["quick"] and all(key in document for key in KEYS):
            found.documents[name] = document
            continue
        announce(name, f"study {number} of {len(studies)}")
        path.unlink(missing_ok=True)
        try:
            run(study, folder, quick)
            found.documents[name] = read(path)
        except InputError:
            raise
        except Exception as error:  # one study that fails must not take the report with it
            found.absent[name] = f"{_FAILED}: {type(error).__name__}: {error}"
            announce(name, found.absent[name])
    return found


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
    forms = {"study": str, "quick": bool, "machine": dict, "versions": dict, "rows": list}
    has_form = isinstance(found, dict) and all(isinstance(found.get(key), one) for key, one in forms.items())
    if not (has_form and all(isinstance(row, dict) for row in found["rows"])):
        raise InputError(
            f"'{path}' is not the result of a study (it needs study, quick, machine, versions, rows): remove "
            "it, or choose another folder."
        )
    return dict(found)


def read_earlier(given: Sequence[Path], quick: bool) -> dict[str, Document]:
    """Name of the study -> document.

    Args:
        given: folders of an earlier report, or NAME.json files of it.
        quick: whether the present report is a quick one; only quick and quick, or full and full compare.

    Raises:
        InputError: one does not exist, is damaged, or holds no results of that mode.
    """
    found: dict[str, Document] = {}
    for path in given:
        files = sorted(path.glob("*.json")) if path.is_dir() else [path]
        own = {one["study"]: one for one in map(read, files) if one["quick"] == quick}
        if not own:
            mode = "quick" if quick else "full"
            raise InputError(
                f"--compare '{path}' holds no results of {mode} runs, and only equal modes compare: give the "
                "folder of an earlier report of the same mode, or its NAME.json files."
            )
        found |= own
    return found
