"""From the command line to files, with a study of milliseconds, and table1 in quick mode."""

import json

import numpy as np
import pytest

from reference_models.data import reference_trajectory
from reference_models.scenes import load_scene
from reference_models.trajectory import Case, Trajectory
from studies.__main__ import main
from studies.harness.on_scene import OnScene
from studies.harness.study import KEYS, Study
from studies.registry import find_studies, find_study
from studies.table1 import PAPER_IMPLICIT

SCENE = load_scene("planar_pendulum")
ROW_KEYS = {
    "label", "formulation", "integrator", "elements", "stepSize", "steps", "cpuSeconds",
    "cpuSecondsMin", "repeats", "errorMax", "errorRms", "status",
}  # fmt: skip
DOCUMENT_KEYS = {*KEYS, "paper", "reference"}


def offset_case(label, offset):
    """The reference itself, moved by `offset` [m]."""

    def prepare():
        reference = reference_trajectory(SCENE)
        return lambda: Trajectory(reference.times, reference.positions + np.array([0.0, 0.0, offset]))

    return Case(label, "inextensible", "zhai", 5, 0.01, 500, prepare, {"note": "moved"})


@pytest.fixture
def tiny(monkeypatch):
    def cases(scene, quick):
        return [offset_case("shifted", 2e-3), offset_case("lost", np.nan)]

    study = Study(
        name="tiny",
        question="Is a shift seen?",
        measure=OnScene(SCENE, cases, {"source": "none"}),
        conclusions=lambda results: [f"{len(results.rows)} rows, quick: {results.quick}"],
    )
    monkeypatch.setattr("studies.__main__.find_study", lambda name: study)
    return study


def test_a_run_writes_everything_that_the_format_asks_for(tiny, tmp_path, capsys):
    assert main(["run", "tiny", "--quick", "--output", str(tmp_path / "out")]) == 0
    document = json.loads((tmp_path / "out" / "tiny.json").read_text())
    assert set(document) >= DOCUMENT_KEYS
    assert all(set(row) >= ROW_KEYS for row in document["rows"])
    assert document["rows"][0]["note"] == "moved"
    assert document["reference"]["uncertainty"] == 5e-5
    assert "2 rows, quick: True" in capsys.readouterr().out
    assert "Is a shift seen?" in (tmp_path / "out" / "tiny.md").read_text()


def test_errors_and_statuses_arrive_in_the_rows(tiny, tmp_path):
    main(["run", "tiny", "--quick", "--output", str(tmp_path)])
    shifted, lost = json.loads((tmp_path / "tiny.json").read_text())["rows"]
    assert shifted["errorMax"] == pytest.approx(2e-3, rel=1e-6)
    assert shifted["errorRms"] == pytest.approx(2e-3, rel=1e-6)
    assert shifted["status"] == "ok"
    assert (lost["status"], lost["errorMax"], lost["cpuSeconds"]) == ("diverged", None, None)


def test_a_full_run_repeats_each_case_five_times(tiny, tmp_path):
    main(["run", "tiny", "--output", str(tmp_path)])
    rows = json.loads((tmp_path / "tiny.json").read_text())["rows"]
    assert [row["repeats"] for row in rows] == [5, 0]


def test_list_shows_every_study_with_its_question_and_how_long_it_takes(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    assert main(["list"]) == 0
    _, _, *lines = capsys.readouterr().out.splitlines()
    for line, (name, study) in zip(lines, find_studies().items(), strict=True):
        assert line.startswith(f"{name} ") and study.question in line
        number, unit = line.split()[-2:]
        assert float(number) * {"s": 1 / 60, "min": 1}[unit] == pytest.approx(study.minutes)


def test_what_the_commands_print_fits_80_columns(tiny, capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(tmp_path)
    assert main(["list"]) == 0 and main(["run", "tiny", "--quick", "--output", "results"]) == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


def test_table1_is_the_main_study(tiny, monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr("studies.__main__.find_study", lambda name: asked.append(name) or tiny)
    monkeypatch.chdir(tmp_path)
    assert main([]) == 0
    assert asked == ["table1"]
    assert (tmp_path / "results" / "tiny.json").exists()


def test_an_unknown_study_names_those_that_exist(capsys, tmp_path):
    assert main(["run", "no_such", "--output", str(tmp_path)]) == 2
    message = capsys.readouterr().err
    assert "'no_such' is unknown" in message and "table1" in message


def test_an_unwritable_output_is_refused_before_anything_runs(tiny, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["run", "tiny", "--output", str(tmp_path / "file")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_repeated_labels_are_refused(tiny, tmp_path, monkeypatch):
    object.__setattr__(tiny.measure, "cases", lambda scene, quick: [offset_case("a", 0.0)] * 2)
    with pytest.raises(ValueError, match=r"\['a'\] occur more than once"):
        main(["run", "tiny", "--output", str(tmp_path)])


@pytest.mark.parametrize("name", ["table1", "table2", "table3", "ring"])
def test_the_full_comparisons_repeat_five_times_at_least(name):
    assert find_study(name).measure.repeats >= 5


def test_table1_runs_in_quick_mode(tmp_path):
    assert main(["run", "table1", "--quick", "--output", str(tmp_path)]) == 0
    document = json.loads((tmp_path / "table1.json").read_text())
    row = next(row for row in document["rows"] if row["label"] == PAPER_IMPLICIT)
    assert row["status"] == "ok" and row["errorMax"] < 1e-3
    report = (tmp_path / "table1.md").read_text()
    assert "2.42" in report and "178" in report
    for picture in tmp_path.glob("*.png"):
        assert f"({picture.name})" in report
    assert len(list(tmp_path.glob("*.png"))) == 2
