"""Table 1 compares what it says it compares."""

import pytest

from studies.harness.study import Results
from studies.table1 import PAPER_EXPLICIT, PAPER_IMPLICIT, PAPER_PROPOSED, STUDY
from tests.studies.rows import row

ROWS = [
    row(PAPER_IMPLICIT, "conventional", "generalizedAlpha", 0.16, 5.8e-3),
    row(PAPER_EXPLICIT, "conventional", "zhai", 8.0, 9e-3),
    row(PAPER_PROPOSED, "inextensible", "zhai", 0.004, 4.6e-3),
    row("quick but wrong", "inextensible", "zhai", 0.001, 1.0),
    row("finer", "inextensible", "zhai", 0.02, 6.5e-4),
    row("tuned", "conventional", "generalizedAlpha", 0.014, 5.1e-3),
    row("tuned, finer", "conventional", "generalizedAlpha", 0.12, 6.1e-4),
    row("tuned, explicit", "conventional", "velocityVerlet", 0.24, 5.8e-3),
]


def conclusion_lines(rows):
    return STUDY.tables[-1].text(Results(False, rows)).markdown.splitlines()[2:]


@pytest.mark.parametrize(
    ("line", "texts"),
    [
        (0, (PAPER_IMPLICIT, "2.42", "40.0")),
        (1, (PAPER_EXPLICIT, "178", "2.00e+03")),
        (2, ("implicit, with error <= 0.006", "tuned", "3.50")),
        (4, ("explicit, with error <= 0.006", "tuned, explicit", "60.0")),
        (6, ("implicit, with error <= 0.0007", "tuned, finer", "6.00")),
    ],
)
def test_ratios_compare_rows_of_the_same_accuracy(line, texts):
    assert all(text in conclusion_lines(ROWS)[line] for text in texts)


def test_ratios_without_an_inextensible_row_are_left_open():
    native = [row for row in ROWS if row["formulation"] == "conventional"]
    assert all(line.endswith("| - |") for line in conclusion_lines(native))


def sentences(quick, **seconds):
    """Of ROWS, some of which took other times [s]."""
    rows = [row | {"cpuSeconds": seconds.get(row["label"], row["cpuSeconds"])} for row in ROWS]
    return STUDY.conclusions(Results(quick, rows))


def test_sentences_say_the_closest_comparison_of_equal_accuracy_and_stand_beside_the_paper():
    equal, implicit, explicit = sentences(False)
    assert "At equal accuracy" in equal and "3.50" in equal and equal.endswith("the bar of 1 is kept.")
    assert implicit.endswith("the bar of 2.425 is kept.") and "the bar of 177.8" in explicit
    assert "the bar of 1 is MISSED" in sentences(False, tuned=0.003)[0]


def test_the_few_rows_of_a_quick_run_decide_nothing_on_equal_accuracy():
    assert not any("equal accuracy" in sentence for sentence in sentences(True, tuned=0.003))


@pytest.mark.parametrize(
    ("seconds", "found"), [(0.6, "undecided within noise"), (1.5, "kept"), (0.1, "MISSED")]
)
def test_a_quick_ratio_near_that_of_the_paper_is_neither_larger_nor_smaller(seconds, found):
    assert sentences(True, **{PAPER_EXPLICIT: seconds})[1].endswith(f"is {found}.")
