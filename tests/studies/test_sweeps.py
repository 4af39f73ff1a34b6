"""Sweeps: resumed, never mixed, the same on every engine, and not lost with a worker."""

import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from exudyn_inext.errors import InputError
from studies.__main__ import main
from studies.harness import engines, sweep
from studies.harness.engines import Engine, Options, processes
from studies.harness.provenance import present_code
from studies.harness.study import Study
from studies.harness.sweep import CaseFolder, Outcome, Sweep, key_of, run_cases
from studies.harness.table import Table
from tests.studies import sweep_cases
from tests.studies.sweep_cases import runs_of


def nobody():
    raise AssertionError("no case should run")


NOBODY = Engine("nobody", nobody)


@pytest.fixture
def traces(tmp_path):
    path = tmp_path / "traces"
    path.mkdir()
    return path


def sweep_of(run, traces, number=5, **entries):
    """Cases, and what runs one."""
    return [{"x": x, "folder": str(traces), **entries} for x in range(number)], run


def run(asked, output, engine=None, **options):
    return run_cases(*asked, CaseFolder(output, "tiny"), engine or processes(2), **options)


def results(outcomes):
    assert all(outcome.status == "ok" for outcome in outcomes)
    return [outcome.result for outcome in outcomes]


SQUARES = [{"square": x * x, "root": x**0.5} for x in range(5)]


def test_processes_give_what_this_process_gives_in_the_order_of_the_cases(tmp_path, traces):
    assert results(run(sweep_of(sweep_cases.square, traces), tmp_path / "a")) == SQUARES
    alone = sweep_of(sweep_cases.square, traces, timed=True)
    assert results(run(alone, tmp_path / "b", NOBODY)) == SQUARES


def test_a_finished_case_is_not_run_twice(tmp_path, traces):
    run(sweep_of(sweep_cases.square, traces, 3, timed=True), tmp_path, NOBODY)
    grown = sweep_of(sweep_cases.square, traces, 5, timed=True)
    assert results(run(grown, tmp_path, NOBODY)) == SQUARES
    assert [len(runs_of(traces, x)) for x in range(5)] == [1] * 5


def _sweep_slowly(output, traces):
    run(sweep_of(sweep_cases.slow_square, traces, timed=True), output, NOBODY)


def test_a_killed_sweep_continues(tmp_path, traces):
    process = multiprocessing.get_context("spawn").Process(target=_sweep_slowly, args=(tmp_path, traces))
    process.start()
    wait_until(lambda: runs_of(traces, 2))
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    finished = len(list((tmp_path / "sweeps" / "tiny").glob("*.json")))
    assert 2 <= finished < 5
    outcomes = run(sweep_of(sweep_cases.slow_square, traces, timed=True), tmp_path, NOBODY)
    assert results(outcomes) == SQUARES
    assert [len(runs_of(traces, x)) for x in range(5)] == [1, 1, 2 if finished == 2 else 1, 1, 1]


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGTERM on Windows")
@pytest.mark.parametrize("starts", ["pool", "program"])
def test_a_terminated_command_leaves_no_process_behind(tmp_path, starts):
    """Two cases run in processes of a pool, or one program runs by itself; each would take a minute."""
    command = [sys.executable, "-m", "tests.studies.sweep_cases", starts, str(tmp_path)]
    process = subprocess.Popen(command, cwd=engines.ROOT)
    number = {"pool": 2, "program": 1}[starts]
    wait_until(lambda: len(list(tmp_path.glob("pid *"))) == number)
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


def wait_until(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def test_a_failed_case_keeps_its_place_and_is_retried_on_request_only(tmp_path, traces):
    asked = sweep_of(sweep_cases.fails_on_three, traces, timed=True)
    for retry, runs in ((False, 1), (False, 1), (True, 2)):
        outcomes = run(asked, tmp_path, NOBODY, retry_failed=retry)
        assert outcomes[3].status == "failed: ArithmeticError: three"
        assert [outcome.status for outcome in outcomes].count("ok") == 4
        assert len(runs_of(traces, 3)) == runs and len(runs_of(traces, 0)) == 1


def test_cases_of_a_dead_process_are_run_again(tmp_path, traces):
    outcomes = run(sweep_of(sweep_cases.kills_its_worker_once, traces), tmp_path)
    assert [result["square"] for result in results(outcomes)] == [0, 1, 4, 9, 16]
    assert len(runs_of(traces, 2)) == 2


def test_a_case_that_always_kills_its_process_is_given_up_alone(tmp_path, traces):
    outcomes = run(sweep_of(sweep_cases.kills_its_worker, traces, 4), tmp_path)
    assert [outcome.status == "ok" for outcome in outcomes] == [True, True, False, True]
    assert "worker died, 4 times" in outcomes[2].status
    assert len(runs_of(traces, 2)) == 4


def test_timed_cases_run_in_this_process_and_others_do_not(tmp_path):
    cases = [{"x": x, "timed": x == 1} for x in range(3)]
    outcomes = run((cases, sweep_cases.process_of), tmp_path)
    assert [result["process"] == os.getpid() for result in results(outcomes)] == [False, True, False]


def other_code(key, value):
    return lambda: present_code() | {key: value}


@pytest.mark.parametrize(
    ("key", "value"),
    [("versions", {"commit": "f" * 40}), ("sources", "other"), ("versions", {"numpy": "0.1"})],
)
def test_results_of_other_code_are_refused_with_a_remedy(tmp_path, traces, monkeypatch, key, value):
    asked = sweep_of(sweep_cases.square, traces, timed=True)
    run(asked, tmp_path, NOBODY)
    with monkeypatch.context() as patch:
        patch.setattr(sweep, "present_code", other_code(key, value))
        with pytest.raises(InputError, match=r"another state of the code .*--output.*--fresh"):
            run(asked, tmp_path, NOBODY)
        CaseFolder(tmp_path, "another", fresh=True)
        assert not list((tmp_path / "sweeps" / "tiny").glob("*.json"))
    with pytest.raises(InputError, match="another state"):
        run(asked, tmp_path, NOBODY)


def test_fresh_discards_one_sweep_of_the_same_code_only(tmp_path, traces):
    asked = sweep_of(sweep_cases.square, traces, timed=True)
    run(asked, tmp_path, NOBODY)
    CaseFolder(tmp_path, "another", fresh=True)
    run(asked, tmp_path, NOBODY)
    assert len(runs_of(traces, 0)) == 1
    CaseFolder(tmp_path, "tiny", fresh=True)
    run(asked, tmp_path, NOBODY)
    assert len(runs_of(traces, 0)) == 2


def test_a_worker_with_other_code_is_refused(tmp_path, traces, monkeypatch):
    outcome = Outcome("ok", {}, other_code("sources", "other")())
    monkeypatch.setattr(sweep, "execute", lambda run, case: outcome)
    with pytest.raises(InputError, match=r"a worker of nobody runs other code.*restart the workers"):
        run(sweep_of(sweep_cases.square, traces, timed=True), tmp_path, NOBODY)


def test_equal_cases_are_refused_and_keys_do_not_depend_on_the_order_of_entries(tmp_path):
    assert key_of({"a": 1, "b": 2.5}) == key_of({"b": 2.5, "a": 1}) != key_of({"a": 1, "b": 2})
    with pytest.raises(InputError, match="occurs more than once"):
        run(([{"x": 1}, {"x": 1}], sweep_cases.process_of), tmp_path, NOBODY)


# ----------------------------------------------------------------------------------- other engines


@pytest.fixture
def cluster():
    """Two worker processes of Dask, and the way to them."""
    distributed = pytest.importorskip("distributed", reason="pip install 'exudyn_inext[cluster]'")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
    ) as started:
        yield started


def test_dask_goes_on_when_a_worker_is_killed_and_gives_the_same(cluster, tmp_path, traces):
    engine = engines.dask(cluster.scheduler_address)
    asked = sweep_of(sweep_cases.slow_square, traces, 16)
    expected = [{"square": x * x, "root": x**0.5} for x in range(16)]
    victim = cluster.workers[0].pid
    survivors = multiprocessing.get_context("spawn").Process(target=_kill_in_mid_run, args=(traces, victim))
    survivors.start()
    outcomes = run(asked, tmp_path, engine)
    survivors.join()
    assert results(outcomes) == expected
    assert survivors.exitcode == 0 and cluster.workers[0].pid != victim
    assert results(run(asked, tmp_path, NOBODY)) == expected


def _kill_in_mid_run(traces, process):
    wait_until(lambda: len(list(traces.glob("ran *"))) >= 3)
    os.kill(process, signal.SIGKILL)


def test_a_dead_address_is_told_when_the_wait_is_over(tmp_path, traces, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(engines, "DASK_TIMEOUT", 0.5)
    with pytest.raises(InputError, match=r"tcp://127.0.0.1:1: no scheduler answered within 0.5 s; start one"):
        run(sweep_of(sweep_cases.square, traces), tmp_path, engines.dask("tcp://127.0.0.1:1"))


def test_an_engine_that_is_not_installed_is_named_with_a_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'exudyn_inext\[cluster\]'"):
        engines.dask("tcp://127.0.0.1:1")
    monkeypatch.setitem(sys.modules, "mpi4py.futures", None)
    with pytest.raises(InputError, match="pip install mpi4py"):
        engines.mpi()


def test_mpi_gives_the_same(tmp_path, traces):
    pytest.importorskip("mpi4py.futures", reason="pip install mpi4py mpich", exc_type=ImportError)
    code = (
        "import sys; from pathlib import Path; from tests.studies.test_sweeps import *\n"
        "traces, output = map(Path, sys.argv[1:])\n"
        "outcomes = run(sweep_of(sweep_cases.square, traces), output, engines.mpi())\n"
        "assert results(outcomes) == SQUARES\n"
        "assert len({outcome.result['square'] for outcome in outcomes}) == 5\n"
    )
    script = tmp_path / "sweep.py"
    script.write_text(f"if __name__ == '__main__':\n    exec({code!r})\n")
    command = ["mpiexec", "-n", "3", sys.executable, "-m", "mpi4py.futures", str(script)]
    environment = os.environ | {"PYTHONPATH": os.getcwd()}
    subprocess.run([*command, str(traces), str(tmp_path / "out")], env=environment, check=True, timeout=60)
    assert [len(runs_of(traces, x)) for x in range(5)] == [1] * 5


# ------------------------------------------------------------------------------ the command line


@pytest.fixture
def study(monkeypatch, traces):
    def cases(quick):
        return [{"kind": "number", "x": x, "folder": str(traces)} for x in range(2 if quick else 4)]

    tiny = Study(
        name="tiny",
        question="Which squares are there?",
        measure=Sweep(cases, sweep_cases.fails_on_three),
        tables=(Table("number", "Squares:", "x | square | status"),),
        conclusions=lambda figures: [f"{len(figures.rows)} numbers"],
    )
    monkeypatch.setattr("studies.__main__.find_study", lambda name: tiny)
    return tiny


def test_a_sweep_study_runs_and_resumes_from_the_command_line(study, tmp_path, traces, capsys):
    command = ["run", "tiny", "--output", str(tmp_path), "--workers", "1"]
    assert main([*command, "--quick"]) == 0
    assert main(command) == 0
    report = capsys.readouterr().out
    assert (
        re.search(r"^2 +4  ok$", report, re.MULTILINE)
        and "failed: ArithmeticError: three" in report
        and "4 numbers" in report
    )
    assert [len(runs_of(traces, x)) for x in range(4)] == [1] * 4
    document = json.loads((tmp_path / "tiny.json").read_text())
    assert len(document["versions"]["commit"]) >= 7 and len(document["rows"]) == 4
    assert main([*command, "--fresh"]) == 0
    assert len(runs_of(traces, 0)) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [(["--workers", "0"], "at least 1"), (["--mpi", "--dask", "tcp://a:1"], "exclude each other")],
)
def test_options_that_make_no_sense_are_refused(study, tmp_path, capsys, options, message):
    assert main(["run", "tiny", "--output", str(tmp_path), *options]) == 2
    assert message in capsys.readouterr().err


def test_a_study_without_a_sweep_takes_no_engine(tmp_path, capsys):
    assert main(["run", "ring", "--mpi", "--output", str(tmp_path)]) == 2
    assert "leave out --workers" in capsys.readouterr().err


def test_default_options_run_on_the_cores_of_this_machine():
    assert Options().engine().name == f"{os.cpu_count()} processes"
