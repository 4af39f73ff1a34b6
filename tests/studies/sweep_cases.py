"""Cases for the tests of sweeps: functions that worker processes import, with side effects that count."""

import os
import signal
import sys
import time
import uuid
from pathlib import Path


def square(case):
    """x^2; each run leaves a file."""
    leave_trace(case)
    return {"square": case["x"] ** 2, "root": float(case["x"]) ** 0.5}


def slow_square(case):
    time.sleep(0.15)
    return square(case)


def process_of(case):
    return {"process": os.getpid()}


def fails_on_three(case):
    leave_trace(case)
    if case["x"] == 3:
        raise ArithmeticError("three")
    return {"square": case["x"] ** 2}


def kills_its_worker_once(case):
    """The first run of x = 2 takes its process down."""
    leave_trace(case)
    if case["x"] == 2 and len(runs_of(Path(case["folder"]), 2)) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": case["x"] ** 2}


def kills_its_worker(case):
    leave_trace(case)
    if case["x"] == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": case["x"] ** 2}


def leave_trace(case):
    (Path(case["folder"]) / f"ran {case['x']} {uuid.uuid4()}").touch()


def runs_of(folder, x):
    return list(folder.glob(f"ran {x} *"))


def sleeps(case):
    """For a minute; says by which process."""
    (Path(case["folder"]) / f"pid {os.getpid()}").touch()
    time.sleep(60.0)
    return {}


if __name__ == "__main__":  # started as a program, and ended by a test
    from studies.harness.engines import ask, processes
    from studies.harness.sweep import CaseFolder, run_cases
    from tests.studies import sweep_cases

    what, folder = sys.argv[1:]
    match what:
        case "pool":
            cases = [{"x": x, "folder": folder} for x in range(2)]
            run_cases(cases, sweep_cases.sleeps, CaseFolder(Path(folder), "tiny"), processes(2))
        case "program":
            ask(sweep_cases.sleeps, {"folder": folder})
