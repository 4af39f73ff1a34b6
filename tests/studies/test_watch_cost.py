"""The cost of the watch: rows of tiny runs, and what is said of them; no timing is asserted."""

import numpy as np
import pytest

from exudyn_inext.run.coupled_watch import CoupledWatch
from studies import watch_cost
from studies.harness.study import Results


def row(kind, share, number=5):
    return {
        "kind": kind, "label": "2D, steady, Zhai", "elements": number, "share": share, "microseconds": 2.0,
    }  # fmt: skip


def conclude(*shares):
    rows = [row(kind, share, n) for kind in ("alone", "among bodies") for n, share in enumerate(shares)]
    return watch_cost.conclude(Results(False, rows))


def test_shares_below_the_bar_keep_it():
    for sentence, kind in zip(conclude(0.01, 0.02, 0.029), ("alone", "among bodies"), strict=True):
        assert sentence.startswith(f"Cables {kind}: the watch costs 2 % of a step (median), at most 2.9 %")
        assert "N = 2" in sentence and sentence.endswith("the bar of 3 % is kept.")


def test_one_above_the_bar_misses_it():
    alone, _ = conclude(0.01, 0.02, 0.05)
    assert "at most 5 %" in alone and alone.endswith("the bar of 3 % is MISSED by 1 of 3.")


def test_the_interval_of_the_median_holds_what_the_watch_costs():
    noise = np.random.default_rng(1).normal(0.0, 0.1, 400)
    samples = {"watched": list(1.02 + noise), "uninspected": [1.0] * 400}
    r = watch_cost._row((2, "steady", 3), "Zhai", samples, 100)
    assert 0.0 < r["low"] < 0.02 < r["high"] < 0.04 and r["low"] < r["share"] < r["high"]
    late = {**samples, "watched": list(1.1 + noise)}
    assert watch_cost._row((2, "steady", 3), "Zhai", late, 100)["low"] > watch_cost.BAR


@pytest.fixture
def rows_of(monkeypatch):
    """(kind, tasks) -> rows of a few steps."""
    monkeypatch.setattr(watch_cost, "STEPS", 64)
    monkeypatch.setattr(watch_cost, "STEPS_AMONG_BODIES", 16)
    monkeypatch.setattr(watch_cost, "LEAST_SECONDS", 1e-6)

    def rows(kind, tasks):
        return watch_cost._rows((2, kind, 3), tasks, 64, 2)

    return rows


@pytest.mark.parametrize("kind", ["steady", "loaded", "moved"])
def test_cables_alone_are_compared_with_and_without_inspections(rows_of, kind):
    found = rows_of(kind, watch_cost._tasks_alone)
    assert [r["integrator"] for r in found] == list(watch_cost.INTEGRATORS)
    for r in found:
        assert (r["kind"], r["scene"], r["elements"], r["repeats"]) == ("alone", kind, 3, 2)
        assert r["microseconds"] > 0


def test_among_bodies_one_run_is_compared_with_and_without_a_watch(rows_of, monkeypatch):
    judged = []
    is_well_at = CoupledWatch.is_well_at
    monkeypatch.setattr(CoupledWatch, "is_well_at", lambda *args: judged.append(1) or is_well_at(*args))
    tasks = watch_cost._tasks_among_bodies((2, "beside", 3), "Zhai")
    for way, looks in ((watch_cost.WATCHED, True), (watch_cost.UNINSPECTED, False)):
        judged.clear()
        tasks[way](1)
        assert bool(judged) is looks
    found = rows_of("beside", watch_cost._tasks_among_bodies)
    assert {r["kind"] for r in found} == {"among bodies"}
    assert all(r["microseconds"] > 0 for r in found)


def test_few_samples_give_no_verdict():
    rows = [row(kind, 0.05, 5) for kind in ("alone", "among bodies")]
    for sentence in watch_cost.conclude(Results(True, rows)):
        assert sentence.endswith("the bar of 3 % is undecided within noise.")
