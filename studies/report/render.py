"""The two forms of a report: Markdown beside its pictures, and one HTML page that holds everything."""

import base64
import re
from functools import partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markdown_it import MarkdownIt
from markupsafe import Markup

from studies.harness.store import write_text
from studies.harness.table import TextTable

from .content import LONG, Report

TEMPLATES = Path(__file__).parent / "templates"
NAME = "report"
_NUMBER = re.compile(r"-|[-+]?\d[\d.,]*(?:e[-+]?\d+)?")
_TABLE = '<div class="table" tabindex="0">\n<table>'


def write(report: Report, folder: Path) -> tuple[Path, Path]:
    """Write report.md and report.html into the folder of the pictures; return both."""
    markdown, html = folder / f"{NAME}.md", folder / f"{NAME}.html"
    write_text(markdown, as_markdown(report))
    write_text(html, as_html(report, folder))
    return markdown, html


def as_markdown(report: Report) -> str:
    """With pictures by their names."""
    environment = _environment(autoescape=False)
    text = environment.get_template("report.md.j2").render(report=report)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def as_html(report: Report, folder: Path) -> str:
    """Self-contained.   folder: of the pictures."""
    environment = _environment(autoescape=True)
    environment.filters["markdown"] = _to_html
    environment.filters["embedded"] = partial(_embedded, folder)
    style = Markup((TEMPLATES / "report.css").read_text(encoding="utf-8"))
    return environment.get_template("report.html.j2").render(report=report, style=style, long=LONG)


def _environment(autoescape: bool) -> Environment:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=autoescape,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["words"] = _words
    environment.filters["as_table"] = lambda stored: TextTable(**stored).markdown
    environment.tests["number_text"] = lambda text: _NUMBER.fullmatch(str(text)) is not None
    return environment


def _to_html(text: str) -> Markup:
    """Sentences as studies write them, which may hold tables; HTML within them is shown, not obeyed."""
    markdown = (
        MarkdownIt("commonmark", {"html": False}).enable("table").disable(["image", "link", "autolink"])
    )
    html: str = markdown.render(text).strip()
    if html.count("<p>") == 1 and html.startswith("<p>") and html.endswith("</p>"):
        html = html.removeprefix("<p>").removesuffix("</p>")
    return Markup(html.replace("<table>", _TABLE).replace("</table>", "</table></div>"))


def _embedded(folder: Path, name: str) -> Markup:
    """A PNG file as data URI."""
    return Markup("data:image/png;base64," + base64.b64encode((folder / name).read_bytes()).decode())


def _words(value: Any) -> str:
    """A file name as text: table1_cost.png -> table1 cost."""
    return Path(str(value)).stem.replace("_", " ")
