"""Prose is English: names of the code stand in code spans, so that renaming them leaves prose alone."""

import re

import pytest

from tests.documents import DOCS, ROOT

NOT_WRITTEN = {"api", "report"}  # headings that are names of modules; generated
WRITTEN = [page for page in DOCS.rglob("*.md") if page.relative_to(DOCS).parts[0] not in NOT_WRITTEN]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "examples" / "README.md", *sorted(WRITTEN)]
NO_PROSE = [
    re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE),  # blocks of code, and directives
    re.compile(r"^<!-- figures.*?^<!-- end -->$", re.DOTALL | re.MULTILINE),  # generated
    re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.DOTALL),  # equations
    re.compile(r"^ {4}.*$", re.MULTILINE),  # commands
    re.compile(r"`(?:[^`\n]|\n(?!\n))*`"),
    re.compile(r"\]\([^)]*\)|<?https?://[^\s)>]+"),  # where links lead
]
IDENTIFIER = re.compile(r"\b[A-Za-z]{2,}\d*(?:_[A-Za-z]{2,}\d*)+\b")
SAID = {"exudyn_inext"}  # the name of the project is a word of its own


def identifiers(text):
    """Words of the prose with an underscore; symbols with an index, such as w_max and r_xx, are none."""
    for pattern in NO_PROSE:
        text = pattern.sub(" ", text)
    return sorted(set(IDENTIFIER.findall(text)) - SAID)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_prose_holds_no_names_of_the_code(page):
    assert identifiers(page.read_text(encoding="utf-8")) == []


def test_a_name_in_a_heading_a_sentence_or_a_table_is_noticed():
    for line in ("## At a check_velocities", "Take native_items\nfor it.", "| a | report_energy2 |"):
        assert len(identifiers(line)) == 1
    assert (
        identifiers("`a_name`, [here](a_page.md), w_max\n\n    python -m a_module\n\n$a_{bc} = bc_de$") == []
    )
