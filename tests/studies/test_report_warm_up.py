"""Before quick runs are timed, all that they compile is compiled, whatever fails."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from reference_models.scenes import load_scene
from reference_models.trajectory import Case
from studies.harness.engines import Engine
from studies.harness.on_scene import OnScene
from studies.harness.study import Study
from studies.harness.sweep import Sweep
from studies.harness.timing import each_task_once, seconds_per_time
from studies.report import warm_up
from studies.report.warm_up import BRIEF

SCENE = load_scene("planar_pendulum")


@pytest.fixture
def studies(monkeypatch):
    """One of each kind, and the list of what ran; the cases of numbers 1 fail."""
    ran = []

    def run(what):
        ran.append(what)
        if str(what).endswith("1"):
            raise RuntimeError("as it should")

    def cases(scene, quick):
        assert quick and scene.end_time == BRIEF
        return [Case(f"c{n}", "a", "b", 1, 1.0, 1, lambda n=n: lambda: run(f"case {n}")) for n in range(3)]

    sweep = [{"timed": n != 2, "kind": "k", "n": n} for n in range(4)]
    measures = {
        "study": OnScene(SCENE, cases),
        "sweep": Sweep(
            cases=lambda quick: sweep,
            run=lambda case: run(f"{case['kind']} timed {case['n']}"),
            brief={"kind": "brief"},
        ),
        "benchmark": lambda order: run(f"quick: {order.quick}"),
    }
    found = {name: Study(name, "", measure) for name, measure in measures.items()}
    monkeypatch.setattr(warm_up, "find_study", found.get)
    monkeypatch.setattr(warm_up, "processes", lambda: Engine("threads", lambda: ThreadPoolExecutor(1)))
    return found, ran


def test_all_quick_cases_that_are_timed_run_once(studies):
    found, ran = studies
    tasks = [("study", 0), ("sweep", 0), ("sweep", 1), ("sweep", 2), ("benchmark", 0)]
    assert warm_up._tasks(found) == tasks
    warm_up.warm_up(found)
    timed = [f"brief timed {n}" for n in (0, 1, 3)]
    assert sorted(ran) == [*timed, *(f"case {n}" for n in range(3)), "quick: True"]
    assert ran[:3] == ["case 0", "case 1", "case 2"]


def test_without_studies_no_process_is_started(monkeypatch):
    monkeypatch.setattr(warm_up, "processes", None)
    warm_up.warm_up({})


def test_tasks_of_benchmarks_run_once():
    ran = []
    task = ran.append
    with each_task_once():
        assert seconds_per_time({"a": task, "b": task}, 3, 1e-3) == {"a": [1.0] * 3, "b": [1.0] * 3}
    assert ran == [1, 1]
    assert len(seconds_per_time({"a": task}, 3, 1e-6)["a"]) == 3 and len(ran) > 5
