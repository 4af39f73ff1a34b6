"""All documents of a report: stored ones, those of studies that are run for it, earlier ones."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from exudyn_inext import InputError
from studies.harness.provenance import code_of, commit_of, differences, present_code
from studies.harness.store import prepare_directory
from studies.harness.study import KEYS, Document, Study, announce, run

QUICK_FOLDER = "quick"
_FAILED = "FAILED"
MODES = ("full", "quick")


@dataclass(frozen=True)
class Wish:
    """What is to be gathered.

    folder: of the documents.   quick: all studies are run, in quick mode.
    runs_missing: whether studies without a result are run.   fresh: run all anew, whatever is stored.
    other_commit: take what one other commit has stored, and run nothing.
    """

    folder: Path
    quick: bool = False
    runs_missing: bool = True
    fresh: bool = False
    other_commit: bool = False

    def __post_init__(self) -> None:
        if self.other_commit and (self.quick or self.fresh):
            raise InputError(
                "--other-commit takes what is stored, --quick and --fresh run studies anew: leave one out."
            )


@dataclass
class Gathered:
    """documents: name -> what its study stored.   absent: name -> why there is none."""

    documents: dict[str, Document] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)

    @property
    def has_failed(self) -> bool:
        """Whether a study was run, and failed."""
        return any(reason.startswith(_FAILED) for reason in self.absent.values())


def gather(studies: Mapping[str, Study], wish: Wish) -> Gathered:
    """Read what is stored, run what has to be run, one study after another.

    Raises:
        InputError: the folder cannot be written, holds damaged files, or results of another commit.
    """
    prepare_directory(wish.folder)
    found = _stored(studies, wish)
    runs_all = wish.quick or wish.fresh
    if not wish.fresh:
        _require_one_code(found, wish)
    runs_missing = wish.runs_missing and not wish.other_commit
    waiting = [name for name in studies if runs_all or (name in found.absent and runs_missing)]
    for number, name in enumerate(waiting, 1):
        announce(name, f"study {number} of {len(waiting)}")
        found.documents.pop(name, None)
        _run(studies[name], found, wish)
    in_order = {name: found.documents[name] for name in studies if name in found.documents}
    return Gathered(in_order, found.absent)


def _stored(studies: Mapping[str, Study], wish: Wish) -> Gathered:
    """What the folder holds; what is there for another purpose counts as absent."""
    found = Gathered()
    for name in studies:
        path = wish.folder / f"{name}.json"
        document = read(path) if path.exists() else None
        if reason := _unusable(path, document, wish.quick):
            found.absent[name] = reason
        elif document is not None:
            found.documents[name] = document
    return found


def _unusable(path: Path, document: Document | None, quick: bool) -> str:
    """What keeps a document from being shown; empty if nothing does."""
    if document is None:
        return "it has not been run"
    if document["quick"] != quick:
        return f"'{path}' is of a {MODES[document['quick']]} run"
    missing = [key for key in KEYS if key not in document]
    return f"its run was stopped before it was complete: {', '.join(missing)} missing" if missing else ""


def _require_one_code(found: Gathered, wish: Wish) -> None:
    """All of the present code; or, if that is asked for, all of the same other one."""
    documents = list(found.documents.items())
    if not documents:
        return
    expected, beside = present_code(), "the present code"
    remedy = (
        "Give --fresh to run all studies anew, another --output, or, without --quick, --other-commit to "
        "report what that commit measured."
    )
    if wish.other_commit:
        expected, beside = code_of(documents[0][1]), f"'{documents[0][0]}' there"
        remedy = "Give --only with the studies that belong together, or another --output."
    for name, document in documents:
        code = code_of(document)
        if code != expected:
            raise InputError(
                f"'{wish.folder}' holds results of another state of the code: study '{name}' of "
                f"{commit_of(code)}, {beside} is {commit_of(expected)} (also different: "
                f"{differences(code, expected) or 'nothing'}). {remedy}"
            )


def _run(study: Study, found: Gathered, wish: Wish) -> None:
    """A study that fails leaves its reason; the others go on."""
    path = wish.folder / f"{study.name}.json"
    path.unlink(missing_ok=True)
    try:
        run(study, wish.folder, wish.quick)
    except InputError:
        raise
    except Exception as error:  # one study that fails must not take the report with it
        found.absent[study.name] = f"{_FAILED}: {type(error).__name__}: {error}"
        announce(study.name, found.absent[study.name])
        return
    found.absent.pop(study.name, None)
    found.documents[study.name] = read(path)


# ------------------------------------------------------------------------------- stored documents


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


# ------------------------------------------------------------------------------ an earlier report


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
        if not path.exists():
            raise InputError(f"--compare '{path}': there is no such folder or file.")
        folders = [path, path / QUICK_FOLDER] if quick else [path]
        files = [file for folder in folders for file in sorted(folder.glob("*.json"))]
        own = {}
        for file in files if path.is_dir() else [path]:
            try:
                document = read(file)
            except InputError as error:
                if error.__cause__ and file.suffix == ".json":
                    raise
                continue  # of another kind, in the same folder
            if document["quick"] == quick:
                own[document["study"]] = document
        if not own:
            raise InputError(
                f"--compare '{path}' holds no results of {MODES[quick]} runs, and only equal modes compare: "
                "give the folder of an earlier report of the same mode, or its NAME.json files; or "
                + ("leave out --quick." if quick else "give --quick.")
            )
        found |= own
    return found
