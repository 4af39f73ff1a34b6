"""Tutorial, recipes, migration, answers: every block runs, in order, and prints what is printed below it."""

import pytest

from tests.documents import DOCS, last_digit, python_blocks, require_printed
from tests.gym_stub import import_environments

SERIES = [page for name in ("tutorial", "recipes") for page in sorted((DOCS / name).glob("[!i]*.md"))]
PAGES = [*SERIES, DOCS / "migration.md", DOCS / "faq.md"]
RUN_BY_TESTS = {"howto", "tutorial", "recipes", "migration.md", "faq.md"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_blocks_of_a_page_run_and_print_what_is_printed_below(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)  # Exudyn writes its solution file here
    import_environments(monkeypatch)
    blocks, variables = python_blocks(page), {"__name__": "__main__"}
    assert any(block.printed for block in blocks)
    for block in blocks:
        exec(block.code, variables)
        printed = capsys.readouterr().out
        require_printed(without_exudyn(printed), block.printed or "")


def without_exudyn(text):
    """What the script itself printed, without the notes that Exudyn prints on its own."""
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith(("+++", "EXUDYN ")))


def test_no_other_page_shows_code_that_nobody_runs():
    pages = {page.relative_to(DOCS).parts[0] for page in DOCS.rglob("*.md") if python_blocks(page)}
    assert pages == RUN_BY_TESTS


@pytest.mark.parametrize("printed", ["h = 1.02 s\n", "h = 1.00 m\n", "h = 1.00 s, 5\n", ""])
def test_another_number_or_word_is_noticed(printed):
    with pytest.raises(AssertionError):
        require_printed(printed, "h = 1.00 s\n")


def test_numbers_agree_within_a_unit_of_the_last_digit():
    require_printed("h = 1.004e-3 s\n", "h = 1.0e-03 s\n")
    assert last_digit("2.50e-3") == pytest.approx(1e-5)
    assert last_digit("12") == 0.0
