"""Equations as pictures within the page (SVG), in the colour of its text: no script, no font is loaded."""

from html import escape
from typing import Any

import ziamath
from docutils.nodes import SkipNode

SIZE = 17.0  # of letters [px]


def drawn(tex: str, inline: bool) -> str:
    """An SVG element that stands on the line of the text; readers' software finds the LaTeX text."""
    equation = ziamath.Latex(tex, size=SIZE, color="currentColor", inline=inline)
    style = f"vertical-align: {equation.getyofst():.1f}px"
    attributes = f'role="img" aria-label="{escape(tex)}" style="{style}"'
    return str(equation.svg()).replace("<svg ", f"<svg {attributes} ", 1)


def visit_math(translator: Any, node: Any) -> None:
    """In a line of text."""
    translator.body.append(drawn(node.astext(), inline=True))
    raise SkipNode


def visit_equation(translator: Any, node: Any) -> None:
    """On a line of its own."""
    translator.body.append(f'<div class="equation">{drawn(node.astext(), inline=False)}</div>\n')
    raise SkipNode


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    ziamath.config.svg2 = False  # no symbols that several equations of a page would share
    app.add_html_math_renderer("equations", (visit_math, None), (visit_equation, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
