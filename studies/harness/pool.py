"""The one pool of processes: cases side by side, and what needs a process of its own."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from tqdm import tqdm

from .store import Row, plain
from .study import Order, announce
from .timing import OK

RunCase = Callable[[Row], Row | list[Row]]
"""case -> what was found, or rows of its own; a function of a module, so that processes find it."""


@dataclass(frozen=True)
class Sweep:
    """How rows are measured: one function over many cases.

    cases: quick -> cases, each with its "kind"; those with {"timed": True} are run one after another in this
    process, after all others: nothing else of the sweep runs meanwhile.
    run: of one.   A row is the case, what was found, and its status.
    """

    cases: Callable[[bool], Sequence[Row]]
    run: RunCase

    def __call__(self, order: Order) -> list[Row]:
        cases, found = self.cases(order.quick), {}
        timed = [k for k, case in enumerate(cases) if case.get("timed")]
        untimed = [k for k in range(len(cases)) if k not in timed]
        number = order.workers or os.cpu_count() or 1
        announce(order.study, f"{len(untimed)} cases on {number} processes, {len(timed)} timed alone")
        with tqdm(total=len(cases), desc=order.study, unit="case") as progress, processes(number) as pool:
            futures = {k: pool.submit(rows_of, self.run, cases[k]) for k in untimed}
            for k, future in futures.items():
                try:
                    found[k] = future.result()
                except BrokenProcessPool:  # by this case or by another one that ran beside it
                    found[k] = _alone(self.run, cases[k])
                progress.update()
            for k in timed:
                found[k] = rows_of(self.run, cases[k])
                progress.update()
        return [row for k in range(len(cases)) for row in found[k]]


def rows_of(run: RunCase, case: Row) -> list[Row]:
    """Rows of a case, wherever that is run; a failing one must not take the others with it."""
    try:
        found = plain(run(case))
    except Exception as error:
        return [{**case, "status": f"failed: {type(error).__name__}: {error}"}]
    return found if isinstance(found, list) else [{**case, **found, "status": OK}]


def _alone(run: RunCase, case: Row) -> list[Row]:
    try:
        return list(ask(rows_of, run, case))
    except BrokenProcessPool:
        return [{**case, "status": "failed: its process died"}]


def ask(function: Callable[..., Any], *arguments: object) -> Any:
    """What a function of a module returns in a process of its own."""
    with processes(1) as pool:
        return pool.submit(function, *arguments).result()


@contextmanager
def processes(number: int) -> Iterator[Executor]:
    """So many processes, with one thread for linear algebra each, as many run side by side.

    Whoever leaves early, also by SIGTERM, waits for no case: the processes are ended.
    """
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # of what starts now: this process has its threads
    others = multiprocessing.active_children()
    with _leaving_when_terminated():
        executor = ProcessPoolExecutor(number, multiprocessing.get_context("spawn"))
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()).difference(others):
                process.terminate()
            raise
        executor.shutdown()


@contextmanager
def _leaving_when_terminated() -> Iterator[None]:
    """Inside, SIGTERM raises SystemExit; outside, it ends this process at once, also in a solver."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def leave(number: int, frame: object) -> None:
        sys.exit(128 + number)

    before = signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
