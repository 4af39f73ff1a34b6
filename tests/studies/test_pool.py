"""Many cases: the same wherever they run, timed ones alone, and none lost with a process."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest

from studies.__main__ import main
from studies.harness.pool import Sweep, ask
from studies.harness.provenance import ROOT
from studies.harness.study import Order, Study
from studies.harness.table import Table
from tests.studies import pool_cases


def rows_of(run, path, number=4, **entries):
    cases = [{"kind": "number", "x": x, **entries} for x in range(number)]
    for case in cases:
        case |= {"timed": True} if case["x"] == entries.get("timed") else {"timed": False}
    return Sweep(lambda quick: cases, run)(Order("tiny", path, workers=2))


def test_timed_cases_run_in_this_process_others_do_not_and_all_keep_their_place(tmp_path):
    rows = rows_of(pool_cases.square, tmp_path, timed=1, fails=3)
    assert [row.get("square") for row in rows] == [0, 1, 4, None]
    assert [row.get("process") == os.getpid() for row in rows] == [False, True, False, False]
    assert [row["status"] for row in rows] == ["ok", "ok", "ok", "failed: ArithmeticError: three"]
    assert rows[0]["limit"] is None  # as JSON stores it


def test_a_case_may_give_rows_of_its_own(tmp_path):
    assert rows_of(pool_cases.twice, tmp_path, 1, timed=0) == [{"kind": "own", "x": 0}] * 2


@pytest.mark.parametrize("always", [False, True])
def test_cases_of_a_dead_process_run_again_alone(tmp_path, always):
    rows = rows_of(pool_cases.kills_its_process, tmp_path, folder="" if always else str(tmp_path))
    assert [row.get("square") for row in rows] == [0, 1, None if always else 4, 9]
    assert rows[2]["status"] == ("failed: its process died" if always else "ok")


def test_a_function_asked_in_a_process_of_its_own_has_one_thread_for_linear_algebra():
    assert ask(os.getpid) != os.getpid() and ask(os.getenv, "OPENBLAS_NUM_THREADS") == "1"


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGTERM on Windows")
def test_a_terminated_command_leaves_no_process_behind(tmp_path):
    """Two processes, which would take a minute."""
    command = [sys.executable, "-m", "tests.studies.pool_cases", str(tmp_path)]
    process = subprocess.Popen(command, cwd=ROOT)
    wait_until(lambda: len(list(tmp_path.glob("pid *"))) == 2)
    started = [int(path.name.split()[1]) for path in tmp_path.glob("pid *")]
    assert all(map(is_running, started)) and process.pid not in started
    process.terminate()
    assert process.wait(timeout=20) == 128 + signal.SIGTERM
    wait_until(lambda: not any(map(is_running, started)))


def is_running(process):
    """Whether there is a process of that number that has not ended."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def wait_until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


# ------------------------------------------------------------------------------ the command line


@pytest.fixture
def study(monkeypatch):
    def cases(quick):
        return [{"kind": "number", "x": x, "fails": 3, "timed": True} for x in range(2 if quick else 4)]

    tiny = Study(
        name="tiny",
        question="Which squares are there?",
        measure=Sweep(cases, pool_cases.square),
        tables=(Table("number", "Squares:", "x | square | status"),),
        conclusions=lambda results: [f"{len(results.rows)} numbers"],
    )
    monkeypatch.setattr("studies.__main__.find_study", lambda name: tiny)
    return tiny


def test_a_sweep_runs_from_the_command_line(study, tmp_path, capsys):
    assert main(["run", "tiny", "--output", str(tmp_path), "--workers", "1"]) == 0
    report = capsys.readouterr().out
    assert re.search(r"^2 +4  ok$", report, re.MULTILINE) and "4 numbers" in report
    assert "failed: ArithmeticError: three" in report


def test_no_workers_are_refused(study, tmp_path, capsys):
    assert main(["run", "tiny", "--output", str(tmp_path), "--workers", "0"]) == 2
    assert "at least 1" in capsys.readouterr().err
