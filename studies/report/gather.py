"""All documents of a report: those that are stored, and those of the studies that are run for it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from exudyn_inext.errors import InputError
from studies.harness.document import Document
from studies.harness.progress import announce
from studies.harness.run import run
from studies.harness.store import prepare_directory
from studies.harness.sweep.folder import require_same_state
from studies.harness.sweep.study import SweepOptions, SweepStudy
from studies.registry import AnyStudy

from .stored import code_of, commit_of, differences, lacks, present_code, read
from .warm_up import warm_up

QUICK_FOLDER = "quick"


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


def gather(studies: Mapping[str, AnyStudy], wish: Wish) -> Gathered:
    """Read what is stored, run what has to be run, one study after another.

    Raises:
        InputError: the folder cannot be written, holds damaged files, or results of another commit.
    """
    prepare_directory(wish.folder)
    found = _stored(studies, wish)
    if not wish.fresh:
        _require_one_code(found, wish)
    waiting = [name for name in studies if _is_run(name, found, wish)]
    if any(isinstance(studies[name], SweepStudy) for name in waiting) and not (wish.fresh or wish.quick):
        require_same_state(wish.folder)
    if wish.quick:
        warm_up({name: studies[name] for name in waiting})
    for number, name in enumerate(waiting, 1):
        announce(name, f"study {number} of {len(waiting)}")
        found.documents.pop(name, None)
        _run(studies[name], found, wish)
    return Gathered(
        {name: found.documents[name] for name in studies if name in found.documents}, found.absent
    )


def _stored(studies: Mapping[str, AnyStudy], wish: Wish) -> Gathered:
    """What the folder holds; what is there for another purpose counts as absent."""
    found = Gathered()
    for name in studies:
        path = wish.folder / f"{name}.json"
        if not path.exists():
            found.absent[name] = "it has not been run"
            continue
        document = read(path)
        wrong_mode = document["quick"] != wish.quick and f"'{path}' is of a {_mode(document['quick'])} run"
        if reason := wrong_mode or lacks(document):
            found.absent[name] = reason
        else:
            found.documents[name] = document
    return found


def _mode(quick: bool) -> str:
    return "quick" if quick else "full"


def _is_run(name: str, found: Gathered, wish: Wish) -> bool:
    if wish.quick or wish.fresh:
        return True
    return name in found.absent and wish.runs_missing and not wish.other_commit


def _require_one_code(found: Gathered, wish: Wish) -> None:
    """All of the present code; or, if that is asked for, all of the same other one."""
    documents = list(found.documents.items())
    if not documents:
        return
    expected = code_of(documents[0][1]) if wish.other_commit else present_code()
    beside = f"'{documents[0][0]}' there" if wish.other_commit else "the present code"
    for name, document in documents:
        code = code_of(document)
        if code != expected:
            raise InputError(
                f"'{wish.folder}' holds results of another state of the code: study '{name}' of "
                f"{commit_of(code)}, {beside} is {commit_of(expected)} (also different: "
                f"{differences(code, expected) or 'nothing'}). {_remedy(wish)}"
            )


def _remedy(wish: Wish) -> str:
    if wish.other_commit:
        return "Give --only with the studies that belong together, or another --output."
    return (
        "Give --fresh to run all studies anew, another --output, or, without --quick, --other-commit to "
        "report what that commit measured."
    )


def _run(study: AnyStudy, found: Gathered, wish: Wish) -> None:
    """A study that fails leaves its reason; the others go on."""
    path = wish.folder / f"{study.name}.json"
    path.unlink(missing_ok=True)
    options = SweepOptions(fresh=wish.quick or wish.fresh) if isinstance(study, SweepStudy) else None
    try:
        run(study, wish.folder, wish.quick, options)
    except InputError:
        raise
    except Exception as error:  # one study that fails must not take the report with it
        found.absent[study.name] = f"FAILED: {type(error).__name__}: {error}"
        announce(study.name, found.absent[study.name])
        return
    found.absent.pop(study.name, None)
    found.documents[study.name] = read(path)


def failed(absent: Mapping[str, str]) -> Sequence[str]:
    """Names of the studies that were run, and failed."""
    return [name for name, reason in absent.items() if reason.startswith("FAILED")]
