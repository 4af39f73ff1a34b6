"""What needs a process of its own: memory, and what one thread for linear algebra is to compute."""

import multiprocessing
import os
from collections.abc import Callable
from typing import Any


def ask(function: Callable[..., Any], *arguments: object) -> Any:
    """What a function of a module returns in a process of its own, which ends with this one.

    Raises:
        RuntimeError: the process died, or the function failed; its own message is on the error stream.
    """
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # of what starts now: this process has its threads
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_tell, args=(there, function, arguments), daemon=True)
    process.start()
    there.close()
    try:
        return here.recv()
    except EOFError:
        raise RuntimeError(f"the process of {function.__name__}{arguments} ended without a result") from None
    finally:
        process.join()


def _tell(end: Any, function: Callable[..., Any], arguments: tuple[object, ...]) -> None:
    end.send(function(*arguments))
