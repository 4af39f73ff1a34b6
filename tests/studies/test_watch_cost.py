"""The cost of the watch: rows of tiny runs, and what is said of them; no timing is asserted."""

from types import SimpleNamespace

import numpy as np
import pytest

from exudyn_inext.run.coupled_watch import CoupledWatch
from studies.harness.study import Results
from studies.harness.timing import sampled
from studies.registry import find_study
from studies.speed import watch_cost


def case_of(scene, integrator="Zhai"):
    return {"dimension": 2, "scene": scene, "elements": 3, "integrator": integrator}


def test_a_share_above_the_bar_misses_it_and_few_samples_give_no_verdict():
    rows = [
        {
            "kind": "alone",
            "label": "2D, steady, Zhai",
            "scene": "steady",
            "elements": n,
            "share": share,
            "bar": 0.03,
        }
        for n, share in enumerate((0.01, 0.05))
    ]
    sentence, _ = find_study("watch_cost").conclusions(Results(False, rows))
    assert "(2D, steady, Zhai, N = 1)" in sentence and sentence.endswith("0.03 is MISSED by 1 of 2.")
    assert "undecided" in find_study("watch_cost").conclusions(Results(True, rows))[0]


def test_the_interval_of_the_median_holds_what_the_watch_costs():
    noise = np.random.default_rng(1).normal(0.0, 0.1, 400)

    def row(mean):
        times = {"watched": mean + noise, "uninspected": np.ones(400)}
        found = {("Zhai", way): SimpleNamespace(cpu_seconds=list(some)) for way, some in times.items()}
        return watch_cost.row(case_of("steady"), found)

    r = row(1.02)
    assert 0.0 < r["low"] < 0.02 < r["high"] < 0.04 and r["low"] < r["share"] < r["high"]
    assert row(1.1)["low"] > watch_cost.BAR


@pytest.fixture
def few_steps(monkeypatch):
    monkeypatch.setattr(watch_cost, "STEPS", 64)
    monkeypatch.setattr(watch_cost, "STEPS_AMONG_BODIES", 16)


@pytest.mark.parametrize(
    ("scene", "integrator"), [("steady", "Zhai"), ("loaded", "RATTLE"), ("moved", "RATTLE")]
)
def test_cables_alone_are_compared_with_and_without_inspections(few_steps, scene, integrator):
    case = case_of(scene, integrator)
    r = watch_cost.row(case, sampled(watch_cost.alone(case), 2, 1e-6))
    assert (r["label"], r["repeats"]) == (f"2D, {scene}, {integrator}", 2) and r["microseconds"] > 0


def test_among_bodies_one_run_is_compared_with_and_without_a_watch(few_steps, monkeypatch):
    judged = []
    is_well_at = CoupledWatch.is_well_at
    monkeypatch.setattr(CoupledWatch, "is_well_at", lambda *args: judged.append(1) or is_well_at(*args))
    case = case_of("beside")
    tasks = watch_cost.among_bodies(case)
    for way, looks in ((watch_cost.WATCHED, True), (watch_cost.UNINSPECTED, False)):
        judged.clear()
        tasks["Zhai", way](1)
        assert bool(judged) is looks
    assert watch_cost.row(case, sampled(tasks, 2, 1e-6))["microseconds"] > 0
