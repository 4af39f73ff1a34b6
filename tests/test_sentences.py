"""The README and the tutorial are read by people who do not think in English: sentences are short."""

import re

import pytest

from tests.documents import DOCS, ROOT

SERIES = [page for name in ("tutorial", "recipes") for page in sorted((DOCS / name).glob("*.md"))]
PAGES = [ROOT / "README.md", DOCS / "faq.md", *SERIES]
LONGEST = 25  # words
FENCE = re.compile(
    r"^```.*?^```$|^<!-- figures.*?^<!-- end -->$", re.DOTALL | re.MULTILINE
)  # and generated text
NO_PROSE = re.compile(r"^(?: {4}|\||#).*$", re.MULTILINE)
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
BULLET = re.compile(r"^[-*] ")
END = re.compile(r"(?<=[.!?])[*)]*\s+|\n\s*\n|\n\s*[-*] |\n\s*\d+\. ")


def sentences(text):
    """Of the prose: without code blocks, tables and headings; a term of code or a link is a word."""
    prose = LINK.sub(r"\1", NO_PROSE.sub("\n\n", FENCE.sub("\n\n", text)))
    prose = re.sub(r"`[^`]*`", "code", prose)
    found = (BULLET.sub("", " ".join(sentence.split())) for sentence in END.split(prose))
    return [sentence for sentence in found if sentence]


def words(sentence):
    return len(re.findall(r"[A-Za-z][\w'/-]*|\d[\w.]*", sentence))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_no_sentence_is_long(page):
    long = [
        f"{words(one)}: {one}" for one in sentences(page.read_text(encoding="utf-8")) if words(one) > LONGEST
    ]
    assert not long, "\n".join(long)


def test_sentences_are_found_between_code_and_tables():
    text = "# Title\n\nOne two\nthree. Four `a b c`!\n\n```python\nx = 1\n```\n\n| a | b |\n"
    text += "\n- five\n- [six x](y.z)\n"
    assert sentences(text) == ["One two three.", "Four code!", "five", "six x"]
    assert [words(one) for one in sentences(text)] == [3, 2, 1, 2]
