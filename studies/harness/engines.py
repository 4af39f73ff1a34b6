"""Where cases run: one pool, of processes of this machine, of a Dask cluster, or of MPI."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exudyn_inext import InputError

ROOT = Path(__file__).parents[2]
DASK_TIMEOUT = 5.0  # [s] for the scheduler, and for its first worker


@dataclass(frozen=True)
class Engine:
    """Something that runs cases.

    name: for messages.   open: gives an executor, and closes it.
    lost: what a future raises if its worker died and nobody runs its case again.
    has_workers: executor -> whether there is anybody who may run a case.
    """

    name: str
    open: Callable[[], AbstractContextManager[Executor]]
    lost: tuple[type[BaseException], ...] = (BrokenProcessPool, CancelledError)
    has_workers: Callable[[Executor], bool] = lambda executor: True


def processes(workers: int | None = None) -> Engine:
    """That many processes, by default one a core."""
    number = workers or os.cpu_count() or 1

    def start() -> Executor:
        """Not forked from this process and its threads, but, if possible, from one that imports once."""
        can_fork = "forkserver" in multiprocessing.get_all_start_methods()
        context: Any = multiprocessing.get_context("forkserver" if can_fork else "spawn")
        if can_fork:
            context.set_forkserver_preload([__package__ + ".sweep"])
        return ProcessPoolExecutor(number, mp_context=context)

    return Engine(f"{number} processes", lambda: _closing(start, cancel_futures=True))


@contextmanager
def _closing(start: Callable[[], Executor], **leaving: bool) -> Iterator[Executor]:
    """Whoever leaves early waits for no case: processes that run one are ended.

    leaving: how cases that have not begun are called off.
    """
    with leaving_when_terminated():
        others = multiprocessing.active_children()
        executor = start()
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, **leaving)
            for process in set(multiprocessing.active_children()).difference(others):
                process.terminate()
            raise
        executor.shutdown()


@contextmanager
def leaving_when_terminated() -> Iterator[None]:
    """Inside, SIGTERM raises SystemExit, so that processes which this one has started are ended, too.

    Outside, it ends this process at once, also in a solver that does not return to Python.
    """
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


def dask(address: str) -> Engine:
    """The workers of a Dask scheduler, e.g. "tcp://127.0.0.1:8786"; Dask itself replaces workers that die.

    Raises:
        InputError: `distributed` is not installed; on opening: no scheduler, or none with workers.
    """
    try:
        from distributed import Client
        from distributed.cfexecutor import ClientExecutor
    except ImportError as error:
        raise InputError(
            f"--dask {address}: 'distributed' is not installed; pip install 'exudyn_inext[cluster]'."
        ) from error

    @contextmanager
    def connect() -> Iterator[Executor]:
        try:
            client = Client(address, timeout=DASK_TIMEOUT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(
                f"--dask {address}: no scheduler answered within {DASK_TIMEOUT:g} s; start one (dask "
                "scheduler), or correct the address."
            ) from error
        with client:
            try:
                client.wait_for_workers(1, timeout=DASK_TIMEOUT)
            except TimeoutError as error:
                raise InputError(
                    f"--dask {address}: the scheduler has no workers; start some (dask worker {address})."
                ) from error
            with _closing(lambda: ClientExecutor(client, pure=False)) as executor:
                yield executor

    def has_workers(executor: Any) -> bool:
        return bool(executor._client.scheduler_info(n_workers=-1)["workers"])

    return Engine(f"Dask at {address}", connect, has_workers=has_workers)


def mpi() -> Engine:
    """The processes that mpiexec started.

    Raises:
        InputError: mpi4py or MPI is not installed.
    """
    try:
        from mpi4py.futures import MPIPoolExecutor
    except (ImportError, RuntimeError) as error:
        raise InputError(
            f"--mpi: {error}; pip install mpi4py and an MPI (pip install mpich), then: mpiexec -n 3 "
            "python -m mpi4py.futures -m studies run NAME --mpi."
        ) from error
    return Engine("MPI", lambda: _closing(MPIPoolExecutor, cancel_futures=True))


@dataclass(frozen=True)
class Options:
    """How a sweep is run: from the command line.

    workers: processes of this machine; None: one a core.   dask: address of a scheduler.
    mpi: whether MPI runs the cases.
    fresh: discard stored cases.   retry_failed: run failed cases again.
    """

    workers: int | None = None
    dask: str | None = None
    mpi: bool = False
    fresh: bool = False
    retry_failed: bool = False

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise InputError(f"--workers {self.workers}: must be at least 1.")
        if (self.workers is not None) + (self.dask is not None) + self.mpi > 1:
            raise InputError("--workers, --dask and --mpi exclude each other: give one of them.")

    def engine(self) -> Engine:
        """Where the cases run."""
        if self.dask is not None:
            return dask(self.dask)
        return mpi() if self.mpi else processes(self.workers)


def ask(function: Callable[..., Any], *arguments: object, **environment: str) -> Any:
    """What a function of a module returns in a process of its own; both of what JSON knows.

    Raises:
        CalledProcessError: it failed.
    """
    call = f"import json, sys; from {function.__module__} import {function.__name__} as f"
    with leaving_when_terminated():
        process = subprocess.run(
            [sys.executable, "-c", f"{call}; print(json.dumps(f(*json.load(sys.stdin))))"],
            input=json.dumps(arguments),
            env=os.environ | environment,
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
    return json.loads(process.stdout)
