"""One function over many cases, on a pool; what is finished is kept at once, and not run again.

Outcomes are kept in one file a case, written whole or not at all, all of one state of the code.
"""

import hashlib
import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, wait
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from tqdm import tqdm

from exudyn_inext import InputError

from .engines import Engine
from .provenance import commit_of, differences, present_code
from .store import Row, plain, prepare_directory, read_json, write_json
from .study import Order, announce
from .timing import OK

FOLDER = "sweeps"
ROUNDS = 3  # in which all unfinished cases run side by side, if workers die
PATIENCE = 20.0  # [s] without any worker
_STAMP = "provenance.json"

RunCase = Callable[[Row], Row]
"""case -> result, both of what JSON knows; a function of a module, so that workers find it."""


@dataclass(frozen=True)
class Outcome:
    """status: "ok", or "failed: " and why.   result: empty if it failed.   provenance: code of the worker."""

    status: str
    result: Row
    provenance: dict[str, Any]


def one_row(case: Row, outcome: Outcome) -> list[Row]:
    """The case, what was found, and its status."""
    return [{**case, **outcome.result, "status": outcome.status}]


@dataclass(frozen=True)
class Sweep:
    """How rows are measured.

    cases: quick -> cases, all different, each with its "kind"; {"timed": True} has a case run alone.
    run: case -> what was found.   rows: of a case and its outcome; default: one.
    """

    cases: Callable[[bool], Sequence[Row]]
    run: RunCase
    rows: Callable[[Row, Outcome], list[Row]] = one_row

    def __call__(self, order: Order) -> list[Row]:
        cases, options = self.cases(order.quick), order.options
        folder = CaseFolder(order.output, order.study, options.fresh)
        outcomes = run_cases(cases, self.run, folder, options.engine(), options.retry_failed)
        return [row for pair in zip(cases, outcomes, strict=True) for row in self.rows(*pair)]


def is_timed(case: Row) -> bool:
    """Whether a case needs a core of its own."""
    return bool(case.get("timed", False))


def key_of(case: Row) -> str:
    """The same for equal cases, in whichever order their entries are."""
    text = json.dumps(case, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


# -------------------------------------------------------------------------------- finished cases


class CaseFolder:
    """The finished cases of one sweep below an output directory.

    Args:
        output: the directory.   name: of the sweep.
        fresh: discard what is there: the cases of this sweep, or all if they belong to another state.

    Raises:
        InputError: results of another commit, of changed sources or of other versions are there.
    """

    def __init__(self, output: Path, name: str, fresh: bool = False) -> None:
        self.name = name
        self._folder = output / FOLDER / name
        if fresh:
            is_foreign = bool(_foreign(output))
            shutil.rmtree(output / FOLDER if is_foreign else self._folder, ignore_errors=True)
        else:
            require_same_state(output)
        prepare_directory(self._folder)
        write_json(output / FOLDER / _STAMP, present_code())

    def load(self, case: Row) -> Outcome | None:
        """What became of the case earlier, or None."""
        stored = read_json(self._path(case))
        return Outcome(stored["status"], stored["result"], stored["provenance"]) if stored else None

    def save(self, case: Row, outcome: Outcome) -> None:
        """Keep an outcome, at once."""
        write_json(self._path(case), {"case": case, **asdict(outcome)})

    def _path(self, case: Row) -> Path:
        return self._folder / f"{key_of(case)}.json"


def require_same_state(output: Path) -> None:
    """Refuse (InputError) a directory with cases of another commit, changed sources or other versions."""
    difference = _foreign(output)
    if difference:
        raise InputError(
            f"'{output}' holds cases that belong to another state of the code ({difference}): "
            "choose another --output, go back to that state, or give --fresh to discard them."
        )


def _foreign(output: Path) -> str:
    """What separates the state of stored cases from the present one; empty if nothing does."""
    stamp, present = output / FOLDER / _STAMP, present_code()
    found = read_json(stamp)
    if found is None and stamp.parent.exists() and any(stamp.parent.iterdir()):
        found = {"versions": {}, "sources": ""}
    if not found or found == present:
        return ""
    which = differences(found, present)
    return f"{commit_of(found)}, now {commit_of(present)}; also different: {which or 'nothing'}"


# ----------------------------------------------------------------------------------------- running


Finished = Iterator[tuple[Row, Outcome]]


def run_cases(
    cases: Sequence[Row], run: RunCase, folder: CaseFolder, engine: Engine, retry_failed: bool = False
) -> list[Outcome]:
    """Run the cases that are not finished; outcomes of all, in the order of the cases.

    Timed cases run one after another in this process, after all others: nothing else of the sweep runs
    meanwhile, and all of them on the same machine.

    Args:
        cases: all different.   run: of one.   folder: of the finished ones.   engine: where to run them.
        retry_failed: whether cases that failed earlier are run again.

    Raises:
        InputError: cases that are equal; workers that cannot run the cases, or run other code.
    """
    keys = [key_of(case) for case in cases]
    repeated = [case for case, key in zip(cases, keys, strict=True) if keys.count(key) > 1]
    if repeated:
        raise InputError(f"case {repeated[0]} occurs more than once; make the cases distinct.")
    stored = [(case, folder.load(case)) for case in cases]
    waiting = [case for case, one in stored if one is None or (retry_failed and one.status != OK)]
    untimed, timed = ([case for case in waiting if is_timed(case) is kind] for kind in (False, True))
    done = len(cases) - len(waiting)
    if waiting:
        where = f"{len(waiting)} cases on {engine.name}, {len(timed)} timed alone"
        announce(folder.name, f"{where}; {done} finished before")
    alone = ((case, execute(run, case)) for case in timed)
    with tqdm(total=len(cases), initial=done, desc=folder.name, unit="case") as progress:
        for case, outcome in chain(_side_by_side(engine, run, untimed), alone):
            _require_same_code(outcome, engine)
            folder.save(case, outcome)
            progress.update()
    return [outcome for case in cases if (outcome := folder.load(case))]  # as a later run would read it


def execute(run: RunCase, case: Row) -> Outcome:
    """Run one case, wherever that is; an exception is kept as the outcome."""
    present_code()  # found before anything runs: sources may be edited meanwhile
    try:
        return Outcome(OK, plain(run(case)), present_code())
    except Exception as error:  # a failing case must not take the others with it
        return _failed(f"{type(error).__name__}: {error}")


def _failed(why: str) -> Outcome:
    """The outcome of a case that gave no result."""
    return Outcome(f"failed: {why}", {}, present_code())


def _require_same_code(outcome: Outcome, engine: Engine) -> None:
    if which := differences(outcome.provenance, present_code()):
        raise InputError(
            f"a worker of {engine.name} runs other code: {which}; install the same there, and restart the "
            "workers."
        )


def _side_by_side(engine: Engine, run: RunCase, cases: Sequence[Row]) -> Finished:
    """All cases; those whose worker died are run again, at last each alone, so that the culprit is known."""
    waiting = list(cases)
    for attempt in range(ROUNDS + 1):
        parts = [waiting] if attempt < ROUNDS else [[case] for case in waiting]
        lost: list[Row] = []
        for part in filter(None, parts):
            with engine.open() as executor:
                yield from _round(engine, executor, run, part, lost)
        waiting = lost
    for case in waiting:
        yield case, _failed(f"its worker died, {ROUNDS + 1} times")


def _round(
    engine: Engine, executor: Executor, run: RunCase, cases: Sequence[Row], lost: list[Row]
) -> Finished:
    """Submit all cases; append those to `lost` whose worker died."""
    work = partial(execute, run)
    pending: dict[Future[Outcome], Row] = {}
    for case in cases:
        try:
            pending[executor.submit(work, case)] = case
        except engine.lost:
            lost.append(case)
    while pending:
        done, _ = wait(pending, timeout=PATIENCE, return_when="FIRST_COMPLETED")
        if not done and not engine.has_workers(executor):
            raise InputError(
                f"{engine.name} has had no worker for a while, {len(pending)} cases are unfinished: start "
                "workers, and run the same command again; finished cases are kept."
            )
        for future in done:
            case = pending.pop(future)
            outcome = _outcome(engine, future)
            if outcome is None:
                lost.append(case)
            else:
                yield case, outcome


def _outcome(engine: Engine, future: "Future[Outcome]") -> Outcome | None:
    """None if the worker died."""
    try:
        return future.result()
    except engine.lost:
        return None
    except Exception as error:
        if type(error).__name__ == "KilledWorker":  # Dask gave the case to several workers, all of them died
            return _failed(f"KilledWorker: {error}")
        raise InputError(
            f"the workers of {engine.name} cannot run the cases ({type(error).__name__}: {error}): start "
            "them where this project can be imported."
        ) from error
