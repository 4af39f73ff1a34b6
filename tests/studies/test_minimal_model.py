"""What may be left out: sentences follow from rows, and cases run."""

import json
from dataclasses import replace

import pytest

from studies import minimal_model
from studies.__main__ import main
from studies.harness.benchmark import Benchmark
from studies.harness.study import Results
from studies.minimal_model import SCENES, is_harmless, summary_of

ROW = {
    "kind": "change", "label": "n_bar = 1", "scene": "planar_pendulum", "uncertainty": 5e-5,
    "baseError": 1e-3, "error": 1.05e-3, "errorRatio": 1.05, "costRatio": 0.8, "status": "ok",
    "outcome": "ok",
}  # fmt: skip


def summarised(*rows):
    return summary_of(Results(False, rows))


def test_harmless_and_harmful_changes_are_told_apart():
    (kept,) = summarised(ROW)
    assert kept["harmless"] == "planar_pendulum" and kept["elsewhere"] == "-" and kept["costRatio"] == 0.8
    assert kept["verdict"] == "harmless everywhere, cheaper"
    (harmful,) = summarised(ROW | {"error": 3e-3, "errorRatio": 3.0})
    assert harmful["verdict"] == "harmful everywhere"
    assert harmful["elsewhere"] == "planar_pendulum (3.00 times the error)"
    (lost,) = summarised(ROW | {"error": None, "errorRatio": None, "costRatio": None, "outcome": "diverged"})
    assert lost["elsewhere"] == "planar_pendulum (diverged)" and lost["costRatio"] is None


def test_a_base_that_fails_is_named():
    lost = ROW | {
        "baseError": None,
        "errorRatio": None,
        "costRatio": None,
        "baseOutcome": "diverged: at 1 s. Why",
    }
    (row,) = summarised(lost)
    assert row["elsewhere"] == "planar_pendulum (the base diverged: at 1 s)"


def test_scenes_and_costs_decide_together():
    there = ROW | {"scene": "power_line", "error": 3e-3, "errorRatio": 3.0, "costRatio": 1.4}
    (row,) = summarised(ROW, there)
    assert row["verdict"] == "harmless on some scenes, dearer" and row["costRatio"] == pytest.approx(1.1)


def test_changes_are_listed_by_verdict():
    rows = [ROW, ROW | {"label": "RK4"}, ROW | {"label": "n_bar = 0", "error": 1.0}]
    assert minimal_model.conclude(Results(False, rows)) == [
        "Harmless everywhere, cheaper: n_bar = 1; RK4.",
        "Harmful everywhere: n_bar = 0.",
    ]


def test_what_the_reference_cannot_tell_apart_is_harmless():
    small = {"baseError": 1e-5, "error": 5e-5}
    assert is_harmless(ROW | small)
    assert not is_harmless(ROW | small | {"error": 7e-5})


KEPT = ("n_bar = 1", "RATTLE")


def test_it_runs_in_quick_mode(tmp_path, monkeypatch):
    cases = minimal_model.make_cases(True)
    assert {case["scene"] for case in cases} == {"planar_pendulum"}
    assert {case["scene"] for case in minimal_model.make_cases(False)} == set(SCENES)
    few = [case for case in cases if case["label"] in KEPT]
    (series,) = minimal_model.STUDY.measure.series
    study = replace(minimal_model.STUDY, measure=Benchmark([replace(series, cases=lambda quick: few)]))
    monkeypatch.setattr("studies.__main__.find_study", lambda name: study)
    command = ["run", "minimal_model", "--quick", "--output", str(tmp_path)]
    assert main(command) == 0
    rows = json.loads((tmp_path / "minimal_model.json").read_text())["rows"]
    errors = {row["label"]: row["error"] for row in rows}
    assert len(errors) == 2 and all(row["status"] == "ok" for row in rows)
    assert errors["RATTLE"] < 1e-3 < errors["n_bar = 1"] < 2e-2
    assert all(row["costRatio"] > 0 for row in rows)
    text = (tmp_path / "minimal_model.md").read_text()
    assert "(minimal_model.png)" in text and "| n_bar = 1 | harmful everywhere |" in text
