"""The study of the ring runs, and concludes from what it measured."""

import pytest

from studies.__main__ import main
from studies.ring import PROPOSED, SIMPLER
from tests.studies.rows import rows_of


@pytest.fixture(scope="module")
def quick_ring(tmp_path_factory):
    directory = tmp_path_factory.mktemp("ring")
    assert main(["run", "ring", "--quick", "--output", str(directory)]) == 0
    return directory


def test_ring_with_second_derivatives_is_closer_to_the_limit_than_the_papers_measure(quick_ring):
    rows, _ = rows_of(quick_ring, "ring")
    assert rows[SIMPLER]["errorMax"] < 2e-4
    assert rows[SIMPLER]["errorMax"] < 0.5 * rows[PROPOSED]["errorMax"]


def test_ring_report_says_where_the_step_limit_is_and_what_happens_beyond(quick_ring):
    report = (quick_ring / "ring.md").read_text()
    assert "At 0.98 of it, Zhai stays stable" in report
    assert "At 1.03 of it, Zhai diverges before t = " in report
    names = {picture.name for picture in quick_ring.glob("*.png")}
    assert names == {"ring_motion.png", "ring_cost.png"}
