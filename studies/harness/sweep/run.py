"""Running a sweep: what is finished is not run again, and every outcome is kept at once."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, wait
from functools import partial

from tqdm import tqdm

from exudyn_inext.errors import InputError

from ..progress import announce
from ..provenance import provenance
from ..study import Row
from .case import OK, Outcome, Sweep, execute, failed, is_timed, key_of
from .engines import Engine
from .folder import CaseFolder

ROUNDS = 3  # in which all unfinished cases run side by side, if workers die
PATIENCE = 20.0  # [s] without any worker

Finished = Iterator[tuple[Row, Outcome]]


def run_sweep(sweep: Sweep, folder: CaseFolder, engine: Engine, retry_failed: bool = False) -> list[Outcome]:
    """Run the cases that are not finished; outcomes of all, in the order of the cases.

    Timed cases run one after another in this process, after all others: nothing else of the sweep runs
    meanwhile, and all of them on the same machine.

    Args:
        sweep: what to run.   folder: of its finished cases.   engine: where to run it.
        retry_failed: whether cases that failed earlier are run again.

    Raises:
        InputError: cases that are equal; workers that cannot run the cases, or run other code.
    """
    _require_distinct(sweep.cases)
    waiting = [case for case in sweep.cases if not _is_finished(folder.load(case), retry_failed)]
    untimed = [case for case in waiting if not is_timed(case)]
    timed = [case for case in waiting if is_timed(case)]
    if waiting:
        _announce(sweep, len(waiting), len(timed), engine)
    with tqdm(total=len(sweep.cases), desc=sweep.name, unit="case") as progress:
        progress.update(len(sweep.cases) - len(waiting))
        for part in (_side_by_side(engine, sweep.run, untimed), _one_by_one(sweep.run, timed)):
            for case, outcome in part:
                _require_same_code(outcome, engine)
                folder.save(case, outcome)
                progress.update()
    return [_stored(folder, case) for case in sweep.cases]


def _announce(sweep: Sweep, waiting: int, timed: int, engine: Engine) -> None:
    finished = len(sweep.cases) - waiting
    announce(sweep.name, f"{waiting} cases on {engine.name}, {timed} timed alone; {finished} finished before")


def _is_finished(outcome: Outcome | None, retry_failed: bool) -> bool:
    return outcome is not None and (outcome.status == OK or not retry_failed)


def _stored(folder: CaseFolder, case: Row) -> Outcome:
    """What a later run would read: results do not depend on who computed them."""
    outcome = folder.load(case)
    assert outcome is not None
    return outcome


def _require_distinct(cases: Sequence[Row]) -> None:
    keys = [key_of(case) for case in cases]
    repeated = [case for case, key in zip(cases, keys, strict=True) if keys.count(key) > 1]
    if repeated:
        raise InputError(f"case {repeated[0]} occurs more than once; make the cases distinct.")


def _require_same_code(outcome: Outcome, engine: Engine) -> None:
    own = provenance()
    for key in ("sources", "versions"):
        if outcome.provenance[key] != own[key]:
            raise InputError(
                f"a worker of {engine.name} runs other code: {key} {outcome.provenance[key]}, here "
                f"{own[key]}; install the same there, and restart the workers."
            )


def _one_by_one(run: Callable[[Row], Row], cases: Sequence[Row]) -> Finished:
    for case in cases:
        yield case, execute(run, case)


def _side_by_side(engine: Engine, run: Callable[[Row], Row], cases: Sequence[Row]) -> Finished:
    """All cases; those whose worker died are run again, at last each alone, so that the culprit is known."""
    waiting = list(cases)
    for _ in range(ROUNDS):
        if not waiting:
            return
        lost: list[Row] = []
        with engine.open() as executor:
            yield from _round(engine, executor, run, waiting, lost)
        waiting = lost
    for case in waiting:
        lost = []
        with engine.open() as executor:
            yield from _round(engine, executor, run, [case], lost)
        if lost:
            yield case, failed(f"its worker died, {ROUNDS + 1} times")


def _round(
    engine: Engine, executor: Executor, run: Callable[[Row], Row], cases: Sequence[Row], lost: list[Row]
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
            return failed(f"KilledWorker: {error}")
        raise InputError(
            f"the workers of {engine.name} cannot run the cases ({type(error).__name__}: {error}): start "
            "them where this project can be imported."
        ) from error
