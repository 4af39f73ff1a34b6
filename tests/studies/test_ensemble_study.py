"""The ensemble study: it measures what it says, and its sentences follow from its rows."""

import json
from dataclasses import replace

import pytest

from studies.__main__ import main
from studies.harness.benchmark import Benchmark
from studies.harness.study import Results
from studies.registry import find_study
from studies.speed import ensemble

ROW = {
    "kind": "ensemble", "label": "all alike", "elements": 5, "endTime": 5.0, "cores": 2, "costRatio": 0.9,
    "gain": 1e3, "isEqual": True,
}  # fmt: skip


def sentences(**changes):
    return find_study("ensemble").conclusions(Results(False, [ROW, ROW | changes]))


def test_bars_that_are_kept_and_missed_are_called_so():
    assert all("kept" in sentence for sentence in sentences())
    assert (
        "at most 1.10" in sentences(costRatio=1.1)[0] and "bar of 1 is MISSED" in sentences(costRatio=1.1)[0]
    )
    assert "MISSED" in sentences(gain=0.5)[1] and "MISSED" in sentences(isEqual=False)[2]


def test_it_runs_in_quick_mode(monkeypatch, tmp_path):
    monkeypatch.setattr(ensemble, "HASHED_BYTES", 2**20)
    study = find_study("ensemble")
    (series,) = study.measure.series
    fewer = replace(series, cases=lambda quick: [case | {"members": 8} for case in ensemble.cases(quick)])
    study = replace(study, measure=Benchmark([fewer]))
    monkeypatch.setattr("studies.__main__.find_study", lambda name: study)
    assert main(["run", "ensemble", "--quick", "--output", str(tmp_path)]) == 0
    for row in json.loads((tmp_path / "ensemble.json").read_text())["rows"]:
        assert row["isEqual"] and row["members"] == 8 and row["rounds"] == 2
        assert row["stepSize"] == pytest.approx({5: 2.5e-3, 10: 2e-3}[row["elements"]])
    assert "Milliseconds a cable" in (tmp_path / "ensemble.md").read_text()
