"""Files appear whole or not at all, and hold what JSON allows; tables and fronts read the rows."""

import json
import math
import os

import numpy as np
import pytest

from exudyn_inext.errors import InputError
from studies.harness.on_scene import ROWS as ROWS_TABLE
from studies.harness.provenance import machine, versions
from studies.harness.ratios import cheapest, front, time_ratio
from studies.harness.store import prepare_directory, write_json, write_text
from studies.harness.study import Results


def row(label, cpu, error, status="ok", integrator="zhai"):
    return {
        "label": label, "formulation": "inextensible", "integrator": integrator, "elements": 5,
        "stepSize": 1e-3, "steps": 5000, "cpuSeconds": cpu, "cpuSecondsMin": cpu, "repeats": 5,
        "errorMax": error, "errorRms": error, "status": status,
    }  # fmt: skip


ROWS = [row("a", 1.0, 1e-2), row("b", 2.0, 1e-3), row("c", 3.0, 5e-3), row("d", None, None, "x")]


def test_not_a_number_is_stored_as_null(tmp_path):
    write_json(tmp_path / "a.json", {"x": math.nan, "y": [np.float64(2.5), np.inf], "n": np.int64(3)})
    assert json.loads((tmp_path / "a.json").read_text()) == {"x": None, "y": [2.5, None], "n": 3}


def test_an_interrupted_write_leaves_the_old_file_and_no_litter(tmp_path, monkeypatch):
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def fail(source, target):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_text(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_directory_that_cannot_be_written_is_refused_with_a_remedy(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be written.*--output"):
        prepare_directory(tmp_path / "file" / "results")


def test_cheapest_keeps_to_the_bound():
    assert cheapest(ROWS, 6e-3)["label"] == "b"
    assert cheapest(ROWS, 2e-2)["label"] == "a"
    assert cheapest(ROWS, 1e-6) is None


def test_front_holds_only_rows_that_nothing_beats():
    assert [member["label"] for member in front(ROWS)] == ["a", "b"]


def test_ratio_needs_both_times():
    assert time_ratio(ROWS[1], ROWS[0]) == 2.0
    assert time_ratio(ROWS[3], ROWS[0]) is None
    assert time_ratio(None, ROWS[0]) is None


def test_a_failed_row_shows_its_status_in_the_table():
    rows = [*ROWS, row("e", None, None, "diverged: |r| > 1")]
    lines = ROWS_TABLE.text(Results(False, rows)).markdown.splitlines()
    assert "d (x)" in lines[-2]
    assert r"diverged: \|r\| > 1" in lines[-1]
    assert len({line.replace(r"\|", "").count("|") for line in lines}) == 1


def test_machine_and_versions_name_no_host_and_no_path():
    import platform

    text = json.dumps([machine(), versions()])
    assert platform.node() not in text
    assert "/home" not in text and "/tmp" not in text
    assert versions()["exudyn"] != "not installed"
