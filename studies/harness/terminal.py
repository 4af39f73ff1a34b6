"""Documents as plain text of a terminal's width: cells and sentences wrap, wide tables continue below."""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from textwrap import fill, wrap
from typing import Any

GAP = "  "
UNBROKEN = 10  # characters of a cell that does not wrap


def terminal_width() -> int:
    """Characters in a line; 80 where nobody tells, as in a pipe."""
    return shutil.get_terminal_size((80, 24)).columns


def as_text(document: Mapping[str, Any], width: int) -> str:
    """Heading, tables, notes and conclusions of a study, in lines of at most `width` characters."""
    mode = f" ({document['mode']})" if document["mode"] else ""
    parts = [fill(f"{document['study']}{mode}: {document['question']}", width)]
    for table in document["tables"]:
        if table["title"]:
            parts.append(fill(table["title"], width))
        parts.append(text_table(table["header"], table["lines"], width))
    parts += [fill(note, width) for note in document["notes"]]
    sentences = [fill(f"- {text}", width, subsequent_indent="  ") for text in document["conclusions"]]
    return "\n\n".join([*parts, "\n".join(sentences)])


def text_table(header: Sequence[str], lines: Sequence[Sequence[str]], width: int) -> str:
    """Columns beside each other; those that find no place follow below, beside the first column again."""
    columns = [list(column) for column in zip(header, *lines, strict=True)]
    least = [max(map(_least_width, column)) for column in columns]
    parts = [[0]]
    for k in range(1, len(columns)):
        if len(parts[-1]) > 1 and sum(least[j] + len(GAP) for j in (*parts[-1], k)) - len(GAP) > width:
            parts.append([0])
        parts[-1].append(k)
    drawn = (_drawn([columns[k] for k in part], [least[k] for k in part], width) for part in parts)
    return "\n\n".join(map("\n".join, drawn))


def _least_width(cell: str) -> int:
    return len(cell) if len(cell) <= UNBROKEN else max(map(len, cell.split()))


def _widened(columns: Sequence[list[str]], widths: list[int], width: int) -> list[int]:
    """What is left of the line goes, character by character, to the column that wraps most."""
    longest = [max(map(len, column)) for column in columns]
    for _ in range(width - sum(widths) - len(GAP) * (len(widths) - 1)):
        k = max(range(len(widths)), key=lambda k: longest[k] / max(widths[k], 1))
        if longest[k] <= widths[k]:
            break
        widths[k] += 1
    return widths


def _drawn(columns: Sequence[list[str]], least: list[int], width: int) -> Iterator[str]:
    """Lines of text; columns with a number, but for the first one, to the right."""
    widths = _widened(columns, least, width)
    sides = [str.rjust if k and any(map(_is_number, cells)) else str.ljust for k, cells in enumerate(columns)]
    for number, row in enumerate(zip(*columns, strict=True)):
        cells = [wrap(cell, w, break_on_hyphens=False) or [""] for cell, w in zip(row, widths, strict=True)]
        for texts in zip_longest(*cells, fillvalue=""):
            placed = (side(text, w) for side, text, w in zip(sides, texts, widths, strict=True))
            yield GAP.join(placed).rstrip()
        if number == 0:
            yield GAP.join("-" * most for most in widths)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
