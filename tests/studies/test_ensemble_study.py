"""The ensemble study: it measures what it says, and its sentences follow from its rows."""

import json

import pytest

from studies import ensemble
from studies.__main__ import main
from studies.harness.study import Results

ROW = {
    "kind": "ensemble", "label": "all alike", "elements": 5, "endTime": 5.0, "cores": 2, "costRatio": 0.9,
    "gain": 1.85, "isEqual": True,
}  # fmt: skip


def sentences(**changes):
    return " ".join(ensemble.conclude(Results(False, [ROW, ROW | changes])))


def test_bars_that_are_kept_and_missed_are_called_so():
    assert sentences().count("kept") == 2
    assert "costs at most 1.10 of a cable alone" in sentences(costRatio=1.1)
    assert "bar of 1 is MISSED" in sentences(costRatio=1.1)
    assert "bar of 1.8 is MISSED" in sentences(gain=1.5)
    assert "NOT EQUAL" in sentences(isEqual=False)


def test_a_gain_that_was_not_measured_is_not_claimed():
    rows = [ROW | {"gain": None}]
    assert "no gain measured" in " ".join(ensemble.conclude(Results(False, rows)))


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(ensemble, "QUICK_CASES", ensemble.QUICK_CASES[:1])
    monkeypatch.setattr(ensemble, "HASHED_BYTES", 2**20)


def test_it_runs_in_quick_mode(small, tmp_path):
    assert main(["run", "ensemble", "--quick", "--output", str(tmp_path)]) == 0
    (row,) = json.loads((tmp_path / "ensemble.json").read_text())["rows"]
    assert row["isEqual"] and row["members"] == 50
    assert row["stepSize"] == pytest.approx(2.5e-3)
    assert "Milliseconds a cable" in (tmp_path / "ensemble.md").read_text()
