"""The studies of ring and power line run, and conclude from what they measured."""

import json

import numpy as np
import pytest

from exudyn_inext import ExplicitSettings
from reference_models.inextensible import Inextensible, solved
from reference_models.model import sensor_trajectory
from reference_models.scenes import load_scene
from reference_models.trajectory import Trajectory
from studies.__main__ import main
from studies.harness.error import distance
from studies.harness.reference import self_convergence
from studies.registry import find_study
from studies.ring import PROPOSED, SIMPLER
from studies.table3 import PAPER_PROPOSED, PAPER_ZHAI, REFINED


@pytest.fixture(scope="module")
def quick_ring(tmp_path_factory):
    directory = tmp_path_factory.mktemp("ring")
    assert main(["run", "ring", "--quick", "--output", str(directory)]) == 0
    return directory


@pytest.fixture(scope="module")
def quick_table3(tmp_path_factory):
    directory = tmp_path_factory.mktemp("table3")
    assert main(["run", "table3", "--quick", "--output", str(directory)]) == 0
    return directory


def rows_of(directory, name):
    document = json.loads((directory / f"{name}.json").read_text())
    return {row["label"]: row for row in document["rows"]}, document


def test_ring_with_second_derivatives_is_closer_to_the_limit_than_the_papers_measure(quick_ring):
    rows, _ = rows_of(quick_ring, "ring")
    assert rows[SIMPLER]["errorMax"] < 2e-4
    assert rows[SIMPLER]["errorMax"] < 0.5 * rows[PROPOSED]["errorMax"]


def test_ring_report_says_where_the_step_limit_is_and_what_happens_beyond(quick_ring):
    report = (quick_ring / "ring.md").read_text()
    assert "At 0.98 of it, Zhai stays stable" in report
    assert "At 1.03 of it, Zhai diverges before t = " in report
    names = {picture.name for picture in quick_ring.glob("*.png")}
    assert names == {"ring_radial.png", "ring_snapshots.png", "ring_cost.png"}


def test_power_line_states_the_uncertainty_of_its_own_reference(quick_table3):
    rows, document = rows_of(quick_table3, "table3")
    assert document["reference"]["file"] is None
    assert 0.0 < document["reference"]["uncertainty"] < 1e-3
    assert rows[PAPER_PROPOSED]["errorMax"] < 2e-3
    assert all(row["status"] == "ok" for row in rows.values())
    report = (quick_table3 / "table3.md").read_text()
    assert "| with ice |" in report and "| 208 |" in report
    assert len(list(quick_table3.glob("*.png"))) == 4


def test_power_line_with_twenty_elements_stays_within_two_millimetres_over_five_seconds():
    scene = load_scene("power_line")
    fine = solved(scene, Inextensible(60, ExplicitSettings(stepSize=5e-4, **REFINED)))
    model = solved(scene, Inextensible(20, PAPER_ZHAI))
    for point in ("P1", "P2"):
        runs = [sensor_trajectory(m, point).positions for m in (fine, model)]
        assert distance(*runs).maximum < 2e-3


def test_uncertainty_of_a_refined_solution_is_what_half_the_refinement_changes():
    times = np.linspace(0.0, 1.0, 5)
    runs = [Trajectory(times, np.full((5, 3), x)) for x in (0.0, 1.0, 3.0)]
    found = self_convergence(*runs, source="made up")
    assert found.trajectory is runs[0]
    assert found.uncertainty == pytest.approx(np.sqrt(3.0) * 4.0)


def test_full_studies_repeat_five_times_at_least():
    assert find_study("ring").repeats >= 5
    assert find_study("table3").repeats >= 5
