"""Table 2 compares what it says it compares, and runs."""

import json
from dataclasses import replace

import pytest

from studies.__main__ import main
from studies.harness.study import Results
from studies.table2 import PAPER_EXPLICIT, PAPER_IMPLICIT, PAPER_PROPOSED, STUDY
from tests.studies.rows import row

ROWS = [
    row(PAPER_IMPLICIT, "conventional", "generalizedAlpha", 0.8, 2.7e-3),
    row(PAPER_EXPLICIT, "conventional", "zhai", 4.0, 3.5e-3),
    row(PAPER_PROPOSED, "inextensible", "Zhai", 0.02, 3e-3),
    row("quick", "inextensible", "Zhai", 0.01, 4e-3),
    row("quicker but coarse", "inextensible", "Zhai", 0.001, 6e-3),
    row("finer", "inextensible", "RATTLE", 0.025, 5e-4),
    row("coarse", "conventional", "generalizedAlpha", 0.05, 6.5e-3, "lobatto"),
    row("coarse, default", "conventional", "generalizedAlpha", 0.2, 6.5e-3),
    row("fine", "conventional", "generalizedAlpha", 0.4, 6e-4, "lobatto"),
    row("explicit", "conventional", "velocityVerlet", 0.6, 4e-3, "lobatto"),
]


def conclusion_line(text):
    table = STUDY.tables[-1].text(Results(False, ROWS))
    (line,) = [
        line
        for line in table.markdown.splitlines()
        if line.removeprefix("| cheapest run, ").removeprefix("| ").startswith((f"{text}:", f"{text} |"))
    ]
    return line


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        (PAPER_IMPLICIT, "| 1.95 | 40.0 |"),
        (PAPER_EXPLICIT, "| 163 | 200 |"),
        ("native, implicit, with error <= 0.007 m", ": coarse | - | 50.0 |"),
        ("native, implicit, with error <= 0.0045 m", ": fine | - | 40.0 |"),
        ("native, implicit, with error <= 0.0007 m", ": fine | - | 16.0 |"),
        ("native, explicit, with error <= 0.0045 m", ": explicit | - | 60.0 |"),
        (
            "native, explicit, default quadrature, with error <= 0.0045 m",
            f": {PAPER_EXPLICIT} | - | 400 |",
        ),
        ("native, implicit, default quadrature, with error <= 0.007 m", "default | - | 200 |"),
        ("native, explicit, with error <= 0.0007 m", " | - | - |"),
    ],
)
def test_ratios_compare_the_cheapest_rows_within_their_bounds(text, rest):
    assert conclusion_line(text).endswith(rest)


@pytest.fixture(scope="module")
def quick_run(tmp_path_factory):
    """Directory of a quick run, over half of its motion."""
    directory = tmp_path_factory.mktemp("table2")
    study = replace(STUDY, measure=replace(STUDY.measure, quick_end_time=0.15))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("studies.__main__.find_study", lambda name: study)
        assert main(["run", "table2", "--quick", "--output", str(directory)]) == 0
    return directory


def test_every_row_of_a_quick_run_is_close_to_the_reference(quick_run):
    rows = json.loads((quick_run / "table2.json").read_text())["rows"]
    assert {PAPER_IMPLICIT, PAPER_EXPLICIT, PAPER_PROPOSED} <= {row["label"] for row in rows}
    assert [row["zeta"] for row in rows if row.get("zeta") and row["elements"] == 10] == [1000.0]
    assert all(row["status"] == "ok" and row["errorMax"] < 2e-3 for row in rows)


def test_the_report_of_a_quick_run_shows_all_pictures_and_the_ratios_of_the_paper(quick_run):
    report = (quick_run / "table2.md").read_text()
    assert "| 1.95 |" in report and "| 163 |" in report
    names = {picture.name for picture in quick_run.glob("*.png")}
    assert names == {"table2_cost.png", "table2_motion.png"}
    assert all(f"({name})" in report for name in names)
