"""A report in Markdown as one HTML page that holds its pictures and needs nothing from elsewhere."""

import base64
import html
import re
from itertools import pairwise
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

from .text import anchor

STYLE = Path(__file__).parent / "page.css"
LONG = 20
"""Lines from which a table is folded in."""
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>
{style}
</style>
</head>
<body>
{body}
</body>
</html>
"""
_PICTURE = re.compile(r'<p>(<img src="data:[^"]*" alt="([^"]*)" ?/?>)</p>')


def as_html(text: str, folder: Path) -> str:
    """The page.   text: Markdown; HTML within it is shown, not obeyed.   folder: of the pictures."""
    markdown = MarkdownIt("commonmark", {"html": False}).enable("table").disable("autolink")
    tokens = markdown.parse(text)
    for heading, content in pairwise(tokens):
        if heading.type == "heading_open" and heading.tag == "h2":
            heading.attrSet("id", anchor(content.content))
    for token in tokens:
        token.children = [_own(child, folder) for child in token.children or []]
    body = markdown.renderer.render(_folded(tokens), markdown.options, {})
    body = _PICTURE.sub(r"<figure>\1<figcaption>\2</figcaption></figure>", body)
    title = html.escape(text.partition("\n")[0].removeprefix("# "))
    return _PAGE.format(title=title, style=STYLE.read_text(encoding="utf-8"), body=body)


def _own(token: Token, folder: Path) -> Token:
    """A picture with its data; what lies outside of page and folder is not referred to."""
    if token.type == "image":
        path = folder / str(token.attrGet("src"))
        if not path.is_file():
            return Token("text", "", 0, content=token.content)
        token.attrSet("src", "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode())
    elif token.type == "link_open" and not str(token.attrGet("href")).startswith("#"):
        token.attrs = {}
    return token


def _folded(tokens: list[Token]) -> list[Token]:
    """With tables in boxes that scroll; long ones are folded in, below their titles."""
    found: list[Token] = []
    end = ""
    for place, token in enumerate(tokens):
        if token.type == "table_open":
            rows, title = _rows(tokens[place:]), _title(found)
            end = "</div>\n"
            if rows > LONG:
                if title:
                    del found[-3:]
                found.append(_raw(f"<details><summary>{title or 'Table'} ({rows} rows)</summary>\n"))
                end += "</details>\n"
            found.append(_raw('<div class="table" tabindex="0">\n'))
        found.append(token)
        if token.type == "table_close":
            found.append(_raw(end))
    return found


def _rows(tokens: list[Token]) -> int:
    """Of the table that begins here, without its head."""
    end = next(place for place, token in enumerate(tokens) if token.type == "table_close")
    return sum(token.type == "tr_open" for token in tokens[:end]) - 1


def _title(tokens: list[Token]) -> str:
    """Of the table that comes next: a paragraph that ends in a colon; empty if there is none."""
    content = tokens[-2].content if len(tokens) > 2 and tokens[-1].type == "paragraph_close" else ""
    return html.escape(content[:-1]) if content.endswith(":") else ""


def _raw(text: str) -> Token:
    return Token("html_block", "", 0, content=text)
