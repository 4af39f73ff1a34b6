"""The study of the power line runs, and concludes from what it measured."""

import pytest

from exudyn_inext import ExplicitSettings
from reference_models.inextensible import Inextensible, solved
from reference_models.model import sensor_trajectory
from reference_models.scenes import load_scene
from studies.__main__ import main
from studies.harness.reference import distance
from studies.table3 import PAPER_PROPOSED, PAPER_ZHAI, REFINED
from tests.studies.rows import rows_of


@pytest.fixture(scope="module")
def quick_table3(tmp_path_factory):
    directory = tmp_path_factory.mktemp("table3")
    assert main(["run", "table3", "--quick", "--output", str(directory)]) == 0
    return directory


def test_power_line_states_the_uncertainty_of_its_own_reference(quick_table3):
    rows, document = rows_of(quick_table3, "table3")
    assert document["reference"]["file"] is None
    assert 0.0 < document["reference"]["uncertainty"] < 1e-3
    assert rows[PAPER_PROPOSED]["errorMax"] < 2e-3
    assert all(row["status"] == "ok" for row in rows.values())
    report = (quick_table3 / "table3.md").read_text()
    assert "| with ice |" in report and "| 208 |" in report
    names = {picture.name for picture in quick_table3.glob("*.png")}
    assert names == {"table3_cost.png", "table3_motion.png"}


def test_power_line_with_twenty_elements_stays_within_two_millimetres_over_five_seconds():
    scene = load_scene("power_line")
    fine = solved(scene, Inextensible(60, ExplicitSettings(stepSize=5e-4, **REFINED)))
    model = solved(scene, Inextensible(20, PAPER_ZHAI))
    for point in ("P1", "P2"):
        runs = [sensor_trajectory(m, point).positions for m in (fine, model)]
        assert distance(*runs).maximum < 2e-3
