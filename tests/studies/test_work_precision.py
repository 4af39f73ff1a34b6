"""Fronts are read where they are and nowhere else; failures stay; sentences follow from rows."""

import json
import math
import sys
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from reference_models.scenes import load_scene
from reference_models.trajectory import Case, Trajectory
from studies import table3, work_precision
from studies.__main__ import main
from studies.harness.benchmark import Benchmark, rows_of
from studies.harness.cases import explicit_case, failing_case
from studies.harness.ratios import (
    BY_NATIVE_SOLVERS,
    EMPTY,
    IMPLICIT,
    INEXTENSIBLE,
    NOT_REACHED,
    PEER,
    READ,
    TOO_LOOSE,
    family_of,
    front_of,
    read,
    speed_up,
)
from studies.harness.reference import from_data
from studies.harness.study import Results
from studies.harness.table import column
from studies.harness.timing import measure
from studies.precision import cases
from studies.work_precision import STUDY, conclude, make_cases

PLANAR = load_scene("planar_pendulum")
U = 1e-4  # uncertainty of the reference [m]


def run(error, seconds, formulation="inextensible", integrator="RATTLE", status="ok", **more):
    row = {
        "kind": "run", "scene": "planar_pendulum", "formulation": formulation, "integrator": integrator,
        "cpuSeconds": seconds, "errorMax": error, "status": status, **more,
    }  # fmt: skip
    return row | {"family": family_of(row)}


def runs(*points, **options):
    return [run(error, seconds, **options) for error, seconds in points]


OWN = runs((1e-2, 1e-3), (1e-3, 1e-2), (2e-3, 5e-2))  # on the front: seconds = 1e-5 / error


def test_between_neighbours_a_power_law_is_found_again():
    found = front_of(OWN, U)
    assert len(found) == 2
    for bound in (1e-2, 3e-3, 1e-3):
        assert read(found, bound) == (pytest.approx(1e-5 / bound), READ)


def test_a_steeper_opponent_has_the_known_ratio():
    theirs = front_of(runs((1e-2, 1e-2), (1e-3, 1.0), (1e-3, 2.0)), U)  # 1e-6 / error^2
    for bound in (1e-2, 5e-3, 1e-3):
        assert speed_up(theirs, front_of(OWN, U), bound) == pytest.approx(0.1 / bound)


def test_only_neighbours_count():
    bent = front_of(runs((1e-2, 1e-3), (5e-3, 1e-3 * 2), (1e-3, 1.0)), U)
    assert read(bent, math.sqrt(1e-2 * 5e-3))[0] == pytest.approx(1e-3 * math.sqrt(2.0))


@pytest.mark.parametrize(
    ("points", "bound", "what"),
    [([(1e-2, 1.0), (1e-3, 2.0)], 1.1e-2, TOO_LOOSE), ([(1e-2, 1.0)], 9e-3, NOT_REACHED), ([], 1e-2, EMPTY)],
)
def test_nothing_is_read_beyond_the_ends(points, bound, what):
    found = read(front_of(runs(*points), U), bound)
    assert found == (None, what)
    assert speed_up(front_of(runs(*points), U), front_of(OWN, U), bound) is None


def test_errors_below_the_uncertainty_count_as_large_as_it():
    found = front_of(runs((1e-3, 1.0), (1e-6, 3.0), (1e-7, 9.0)), U)
    assert column(found, "errorMax") == [1e-3, U] and read(found, U)[0] == pytest.approx(3.0)


def test_a_gain_of_nothing_for_twice_the_time_does_not_make_the_rest_dear():
    found = front_of(runs((1e-2, 1e-3), (0.99e-2, 2e-3), (1e-3, 1e-2)), U)
    assert [row["errorMax"] for row in found] == [1e-2, 1e-3]
    assert read(found, 3e-3)[0] == pytest.approx(1e-5 / 3e-3)


def test_runs_that_failed_are_on_no_front():
    lost = [run(None, None, status="diverged: too fast")]
    assert front_of(lost, U) == [] and len(front_of([*OWN, *lost], U)) == 2


# ------------------------------------------------------------------------------------- measuring


def shifted(label, offset):
    """The reference, moved by `offset` [m]."""

    def prepare():
        reference = from_data(PLANAR).trajectory
        return lambda: Trajectory(reference.times, reference.positions + np.array([0.0, 0.0, offset]))

    return Case(label, "inextensible", "Zhai", 5, 0.01, 500, prepare)


def test_a_failing_case_keeps_its_row_and_status():
    three = [shifted("good", 1e-3), failing_case("bad", "RK4", 7, ArithmeticError("too fast"), 0.5)]
    three.append(shifted("lost", math.nan))
    good, bad, lost = work_precision.measured(PLANAR, three, from_data(PLANAR), repeats=1)
    assert (good["status"], good["kind"], good["repeats"]) == ("ok", "run", 1)
    assert good["errorMax"] == pytest.approx(1e-3) and good["family"] == INEXTENSIBLE
    assert (bad["status"], bad["errorMax"], bad["stepSize"]) == (
        "failed: ArithmeticError: too fast",
        None,
        0.5,
    )
    assert (lost["status"], lost["cpuSeconds"]) == ("diverged", None)


def test_steps_that_are_refused_or_diverge_become_rows(monkeypatch):
    monkeypatch.setattr(cases, "FRACTIONS", (1.2,))
    brief = replace(PLANAR, end_time=0.05)
    (case,) = cases.limited_cases(brief, 5, "RATTLE")
    (row,) = work_precision.measured(brief, [case], from_data(PLANAR), repeats=1)
    assert row["status"].startswith("failed: StepSizeError") and row["cpuSeconds"] is None


def test_slow_cases_are_repeated_less_often():
    assert [work_precision.repeats_of(seconds) for seconds in (0.1, 1.0, 5.0)] == [5, 3, 1]
    pair = [shifted("a", 0.0), shifted("b", 0.0)]
    found = measure(pair, 3, from_data(PLANAR).trajectory, rounds_of=lambda seconds: 1)
    assert [row["repeats"] for row, _ in found] == [1, 1]


def test_equal_labels_are_run_once():
    found = cases.unique([shifted("a", 0.0), shifted("b", 0.0), shifted("a", 1.0)])
    assert [case.label for case in found] == ["a", "b"]


def test_a_scene_without_a_reference_is_compared_with_itself_and_that_is_said(monkeypatch):
    monkeypatch.setattr(table3, "refined", lambda scene: from_data(PLANAR))
    line = load_scene("power_line")
    row = work_precision.reference_row(line, work_precision.reference_of(line))
    assert row["selfConvergence"]
    other = work_precision.reference_row(PLANAR, work_precision.reference_of(PLANAR))
    assert not other["selfConvergence"]


# ------------------------------------------------------------------------------------- sentences


def sentences(*rows, uncertainty=5e-5):
    reference = {
        "kind": "reference", "scene": "planar_pendulum", "source": "MBDyn", "uncertainty": uncertainty,
        "selfConvergence": False, "motion": 5.0,
    }  # fmt: skip
    ratios = work_precision.ratio_rows("planar_pendulum", rows, uncertainty)
    return "\n".join(conclude(Results(False, [reference, *rows, *ratios])))


NATIVE = {"formulation": "conventional", "integrator": "generalizedAlpha"}
OURS = runs((1e-2, 1e-3), (3e-4, 1e-2))


def test_the_bar_is_kept_or_missed_and_where_the_cable_loses_is_said():
    text = sentences(*OURS, *runs((1e-2, 1e-1), (3e-4, 1.0), **NATIVE))
    assert text.count("the bar of 50 is kept") == 2 and "at any error: at least 100" in text
    text = sentences(*OURS, *runs((1e-2, 1e-2), (3e-4, 1.0), **NATIVE))
    assert "native, implicit, at 0.005 m: CPU time" in text and "the bar of 50 is MISSED" in text
    text = sentences(*OURS, *runs((8e-3, 1e-4), (1e-3, 1.0), **NATIVE))
    assert "the bar of 1 is MISSED" in text


def test_readings_that_are_none_say_why():
    rows = work_precision.ratio_rows(
        "planar_pendulum", [*OURS, *runs((8e-3, 1e-4), (1e-3, 1.0), **NATIVE)], 5e-4
    )
    outcomes = {row["bound"]: row["opponentOutcome"] for row in rows if row["opponent"] == IMPLICIT}
    assert outcomes[1e-2] == TOO_LOOSE and outcomes[7e-4] == NOT_REACHED
    assert outcomes[3e-4] == work_precision.BELOW and outcomes[5e-3] == READ


def test_a_missing_opponent_is_told():
    text = sentences(*OURS, *runs((1e-2, 1.0), **NATIVE))
    assert "MuJoCo is not installed" in text
    peers = runs((1e-2, 1.0), formulation="rigid links", integrator="RK4")
    assert "MuJoCo is not installed" not in sentences(*OURS, *peers)


def test_families_tell_formulations_and_solvers_apart():
    assert family_of(run(1.0, 1.0, enforcement="algebraic")) == BY_NATIVE_SOLVERS
    assert family_of(run(1.0, 1.0, **NATIVE)) == IMPLICIT
    assert family_of(run(1.0, 1.0, formulation="rigid links", integrator="RK4")) == PEER


def test_a_scene_that_failed_as_a_whole_is_told():
    def fail(case):
        raise OSError("disk")

    rows = rows_of(fail, make_cases(True)[0])
    assert "FAILED: planar_pendulum: failed: OSError: disk" in conclude(Results(True, rows))


# -------------------------------------------------------------------------------- the whole study


def test_every_scene_has_cases_of_every_formulation():
    assert {case["scene"] for case in make_cases(False)} == set(cases.PLANS)
    for name in ("planar_pendulum", "spatial_pendulum"):
        labels = [case.label for case in cases.enforced_cases(load_scene(name))]
        assert len(labels) == len(set(labels)) and {label.split()[1] for label in labels} == {
            "penaltyMass,",
            "algebraic,",
        }


def test_rigid_links_are_left_out_where_mujoco_is_not_installed(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert list(cases.links_cases(PLANAR)) == []


def test_rigid_links_belong_to_the_pendulums_only(monkeypatch):
    pytest.importorskip("mujoco", reason="pip install 'exudyn_inext[peers]'")
    assert list(cases.links_cases(load_scene("vibrating_ring"))) == []
    monkeypatch.setattr(cases, "LINKS", (6,))
    linked = cases.links_cases(load_scene("spatial_pendulum"))
    assert {case.integrator for case in linked} >= {"RK4", "Euler", "implicitfast"}


def few_cases(scene, quick):
    scaled = [explicit_case(scene, "RATTLE", n, h, 0.3) for n, h in ((3, 1e-2), (5, 5e-3), (8, 2.5e-3))]
    return [
        *scaled,
        *islice(cases.native_cases(scene), 2),
        *(case for case in cases.enforced_cases(scene) if case.elements == 4),
        *cases.unique(islice(cases.links_cases(scene), 8))[:2],
    ]


def test_it_runs_in_quick_mode_with_rows_tables_and_pictures(tmp_path, monkeypatch):
    monkeypatch.setattr(work_precision, "cases_of", few_cases)
    series = replace(STUDY.measure.series[0], cases=lambda quick: make_cases(quick)[:1])
    study = replace(STUDY, measure=Benchmark([series]))
    monkeypatch.setattr("studies.__main__.find_study", lambda name: study)
    assert main(["run", "work_precision", "--quick", "--output", str(tmp_path)]) == 0
    document = json.loads((tmp_path / "work_precision.json").read_text())
    kinds = {kind: [row for row in document["rows"] if row["kind"] == kind] for kind in
             ("reference", "run", "speedUp")}  # fmt: skip
    assert kinds["reference"][0]["uncertainty"] == 5e-5 and not kinds["reference"][0]["selfConvergence"]
    assert all(row["status"] == "ok" and 0.0 < row["errorMax"] < 1e-2 for row in kinds["run"])
    assert {row["family"] for row in kinds["run"]} >= {INEXTENSIBLE, IMPLICIT, BY_NATIVE_SOLVERS}
    assert {row["bound"] for row in kinds["speedUp"]} == {1e-2, 5e-3, 3e-3, 1e-3, 7e-4, 3e-4}
    report = (tmp_path / "work_precision.md").read_text()
    for name in ("planar_pendulum", "ratios"):
        assert f"(work_precision_{name}.png)" in report
