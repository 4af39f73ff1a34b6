"""Tables and sentences in a terminal: nothing is lost, and no line is too long."""

import pytest

from studies.harness.table import TextTable
from studies.harness.terminal import as_text, text_table

LABEL = "native generalizedAlpha, N = 4, h = 0.006 s, modifiedEachStep Newton 1e-04, rho_inf = 0.8"
HEADER = ("case", *(f"largest error {k} [m]" for k in range(12)))
LINES = [(LABEL, *(f"{0.001 * row + k:.6f}" for k in range(12))) for row in range(2)]


@pytest.mark.parametrize("width", [60, 80, 300])
def test_a_wide_table_wraps_and_continues_below(width):
    shown = text_table(HEADER, LINES, width)
    assert max(map(len, shown.splitlines())) <= width
    words = shown.split()
    assert all(words.count(cell) == 1 for line in LINES for cell in line[1:])
    parts = shown.split("\n\n")
    assert (len(parts) == 1) is (width == 300)
    assert all(part.count("generalizedAlpha") == len(LINES) for part in parts)


def test_numbers_stand_below_each_other():
    head, _, *lines = text_table(
        ("case", "x", "note"), [("a", "1.5", "b"), ("c", "-", "much longer")], 40
    ).splitlines()
    assert head.index("x") == lines[0].index("5") == lines[1].index("-")
    assert head.index("note") == lines[0].index("b") == lines[1].index("much")


def test_all_of_a_document_is_shown():
    table = TextTable("Some cases:", ("case", "x"), [("a", "1")])
    document = {"study": "tiny", "question": "Is it?", "mode": "", "tables": [vars(table)]}
    text = as_text({**document, "notes": ["A note."], "conclusions": ["It is. " * 20]}, 60)
    assert text.startswith("tiny: Is it?\n\nSome cases:\n\ncase  x\n")
    assert "A note." in text and "- It is." in text
    assert max(map(len, text.splitlines())) <= 60
