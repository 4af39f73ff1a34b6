"""The package's docstrings, plain text with Args, Returns, Raises and Example, as reStructuredText.

An item is `name: text`, or several in one line with three spaces between them.
"""

import re
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import Any

SECTION = re.compile(r"(Args|Attributes|Returns|Raises|Example):$")
ITEM = re.compile(r"([A-Za-z_]\w*(?:, [A-Za-z_]\w*)*): +(\S.*)")
NEXT_ITEM = re.compile(r"(?<=\S) {3,}(?=[A-Za-z_]\w*(?:, [A-Za-z_]\w*)*: )")
CODE = re.compile(r"(`[^`]*`)")
SPECIAL = re.compile(r"([*|\\])|(?<=\w)_(?!\w)")


def escaped(text: str) -> str:
    """Text whose stars, bars and trailing underscores mean themselves, but for code in backticks."""
    parts = CODE.split(text)
    return "".join(part if CODE.fullmatch(part) else SPECIAL.sub(r"\\\g<0>", part) for part in parts)


def sections(lines: Iterable[str]) -> Iterator[tuple[str, list[str]]]:
    """(header or "", its lines without their common indentation)."""
    header, body = "", []
    for line in lines:
        found = SECTION.match(line)
        if found or (header and line and not line.startswith(" ")):
            yield header, body
            header, body = (found[1], []) if found else ("", [line])
        else:
            body.append(line[4:] if header else line)
    yield header, body


def items(lines: Iterable[str]) -> Iterator[tuple[str, str]]:
    """(name, text) of each item; names that share a text come one by one. Other text has no name."""
    joined: list[tuple[str, str]] = []
    for line in (part for given in lines if given.strip() for part in NEXT_ITEM.split(given)):
        found = ITEM.match(line)
        if found:
            joined.append((found[1], found[2]))
        elif joined:
            joined[-1] = (joined[-1][0], f"{joined[-1][1]} {line.strip()}")
        else:
            joined.append(("", line.strip()))
    for names, text in joined:
        yield from ((name, text) for name in names.split(", "))


def bullets(lines: Iterable[str]) -> list[str]:
    """A list of items."""
    return ["", *(f"- **{name}**: {escaped(text)}" for name, text in items(lines)), ""]


def prose(lines: list[str]) -> list[str]:
    """Paragraphs; those that are items, such as the fields of a class, become lists."""
    result: list[str] = []
    for is_blank, group in groupby(lines, key=lambda line: not line.strip()):
        paragraph = list(group)
        if not is_blank and ITEM.match(paragraph[0]):
            result += bullets(paragraph)
        else:
            result += map(escaped, paragraph)
    return result


def fields(kind: str, lines: list[str]) -> list[str]:
    """A field list: parameters, exceptions."""
    return ["", *(f":{kind} {name}: {escaped(text)}" for name, text in items(lines)), ""]


def returned(lines: list[str]) -> list[str]:
    """What a function returns: a text, or a list of items."""
    if ITEM.match(lines[0]):
        return ["", ":returns:", *(f"    {line}" for line in bullets(lines)), ""]
    return ["", f":returns: {escaped(' '.join(line.strip() for line in lines if line.strip()))}", ""]


def example(lines: list[str]) -> list[str]:
    """Code as it is."""
    return ["", "Example::", "", *(f"    {line}" for line in lines), ""]


CONVERTERS = {
    "": prose,
    "Args": lambda lines: fields("param", lines),
    "Attributes": bullets,
    "Returns": returned,
    "Raises": lambda lines: fields("raises", lines),
    "Example": example,
}


def to_restructured_text(lines: list[str]) -> list[str]:
    """A docstring, line by line."""
    return [line for header, body in sections(lines) for line in CONVERTERS[header](body)]


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect(
        "autodoc-process-docstring",
        lambda app, what, name, object, options, lines: lines.__setitem__(
            slice(None), to_restructured_text(lines)
        ),
    )
    return {"parallel_read_safe": True}
