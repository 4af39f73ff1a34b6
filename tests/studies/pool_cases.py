"""Cases for the tests of the pool: functions that other processes import."""

import os
import signal
import sys
import time
from pathlib import Path


def square(case):
    """x^2, and by which process."""
    if case["x"] == case.get("fails"):
        raise ArithmeticError("three")
    return {"square": case["x"] ** 2, "limit": float("inf"), "process": os.getpid()}


def twice(case):
    """Rows of its own."""
    return [{"kind": "own", "x": case["x"]}] * 2


def kills_its_process(case):
    """That of x = 2; with a folder, the first time only."""
    trace = Path(case["folder"] or "/") / "killed"
    if case["x"] == 2 and not trace.exists():
        if case["folder"]:
            trace.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": case["x"] ** 2}


def sleeps(folder):
    """For a minute; says by which process."""
    (Path(folder) / f"pid {os.getpid()}").touch()
    time.sleep(60.0)


if __name__ == "__main__":  # started as a program, and ended by a test
    from studies.harness.pool import processes
    from tests.studies import pool_cases

    with processes(2) as pool:
        for future in [pool.submit(pool_cases.sleeps, sys.argv[1]) for _ in range(2)]:
            future.result()
