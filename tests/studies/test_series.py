"""Series of cases: none is lost with another one; functions that need a process of their own have one."""

import os
import re
import signal

import pytest

from studies.__main__ import main
from studies.harness.benchmark import Benchmark, Series, rows_of
from studies.harness.process import ask
from studies.harness.study import Study
from studies.harness.table import Table


def square(case):
    if case["x"] == 3:
        raise ArithmeticError("three")
    return {"square": case["x"] ** 2, "limit": float("inf")}


def test_a_case_that_fails_keeps_its_place_with_the_reason():
    (four,), (lost,) = (rows_of(square, {"x": x}) for x in (2, 3))
    assert four == {"x": 2, "square": 4, "limit": None, "status": "ok"}  # as JSON stores it
    assert lost == {"x": 3, "status": "failed: ArithmeticError: three"}


def test_a_case_may_give_rows_of_its_own():
    assert rows_of(lambda case: [{"kind": "own", **case}] * 2, {"x": 1}) == [{"kind": "own", "x": 1}] * 2


def test_a_series_runs_from_the_command_line(monkeypatch, tmp_path, capsys):
    tiny = Study(
        name="tiny",
        question="Which squares are there?",
        measure=Benchmark([Series("number", lambda quick: [{"x": x} for x in range(4)], square)]),
        tables=(Table("number", "Squares:", "x | square | status"),),
        conclusions=lambda results: [f"{len(results.rows)} numbers"],
    )
    monkeypatch.setattr("studies.__main__.find_study", lambda name: tiny)
    assert main(["run", "tiny", "--output", str(tmp_path)]) == 0
    report = capsys.readouterr().out
    assert re.search(r"^2 +4  ok$", report, re.MULTILINE) and "4 numbers" in report
    assert "failed: ArithmeticError: three" in report


def test_a_function_asked_in_a_process_of_its_own_has_one_thread_for_linear_algebra(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    asked = "(os := __import__('os')).getpid(), os.environ['OPENBLAS_NUM_THREADS']"
    process, threads = ask(eval, asked)
    assert process != os.getpid() and threads == "1"


def test_a_process_that_dies_is_named():
    with pytest.raises(RuntimeError, match=r"process of abort.* without a result"):
        ask(os.abort)
    with pytest.raises(RuntimeError, match="process of kill"):
        ask(os.kill, 0, signal.SIGUSR2 + 1000)  # no signal has that number
