"""Code blocks of the documents, and what they print."""

import re
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?")
PATH = re.compile(r"# (\S+\.py)\n")


class Block(NamedTuple):
    """Python of a page.   path: of the module that it is, or None.   printed: expected output, or None."""

    code: str
    path: str | None
    printed: str | None


def python_blocks(page):
    """All Python blocks of a page; a text block that follows one is what it prints."""
    fences = [*FENCE.findall(page.read_text(encoding="utf-8")), ("", "")]
    blocks = []
    for (language, code), (following, printed) in pairwise(fences):
        if language == "python":
            path = PATH.match(code)
            blocks.append(Block(code, path and path[1], printed if following == "text" else None))
    return blocks


def require_printed(output, expected, relative=2e-3):
    """Words as printed; numbers within a relative tolerance, or half a unit of their last digit."""
    assert NUMBER.sub("#", output).split() == NUMBER.sub("#", expected).split(), output
    for found, text in zip(NUMBER.findall(output), NUMBER.findall(expected), strict=True):
        assert float(found) == pytest.approx(float(text), rel=relative, abs=last_digit(text)), output


def last_digit(text):
    """Value of one unit of the last digit of a number."""
    mantissa, _, exponent = text.lower().partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])) if "." in text or exponent else 0.0
