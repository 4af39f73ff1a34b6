"""What the documentation is built with: docstrings, the look for remote resources, the diagram of imports."""

import ast
import re
from pathlib import Path

import pytest

import exudyn_inext
from docs.extensions.docstrings import to_restructured_text

DOCSTRING = """Largest |c(q)| of lam * C_q_, see `a_*`.

q: (n,) [m].   v, a: (n,)
    rates.

Args:
    system: factorised.   h: step [s];
        halved.

Returns:
    violation [-]

Raises:
    InputError: no

Example:
    f(a_ * b)
"""


def test_a_docstring_becomes_lists_fields_and_code():
    text = "\n".join(to_restructured_text(DOCSTRING.splitlines()))
    assert text.startswith(r"Largest \|c(q)\| of lam \* C_q\_, see `a_*`.")
    for line in (
        "- **q**: (n,) [m].",
        "- **v**: (n,) rates.",
        "- **a**: (n,) rates.",
        ":param system: factorised.",
        ":param h: step [s]; halved.",
        ":returns: violation [-]",
        ":raises InputError: no",
        "Example::",
        "    f(a_ * b)",
    ):
        assert line in text.splitlines()


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ('<script src="https://cdn.org/x.js"></script>', 1),
        ('<link rel="stylesheet" href="//fonts.org/a.css">', 1),
        ('<img alt="" src="http://a.org/b.png"> @import "https://a.org/c.css"; url(https://a.org/d.woff)', 3),
        ('<a href="https://a.org">leads there</a> <script src="_static/x.js"></script>', 0),
        ('<link rel="next" href="b.html"> url(data:image/svg+xml,http://www.w3.org/2000/svg)', 0),
    ],
)
def test_what_a_page_loads_from_the_network_is_found(text, number):
    offline = pytest.importorskip("docs.extensions.offline")
    assert len(offline.remote_resources(text)) == number


def test_the_diagram_has_every_import_between_folders_that_is_in_the_source():
    diagram = pytest.importorskip("docs.extensions.import_diagram")
    found = diagram.direct_imports()
    package = Path(exudyn_inext.__file__).parent
    for folder in ("element", "cable", "integrators", "scene"):
        assert found[folder] == imported_by(package / folder)


def imported_by(folder):
    """Folders and modules of the package that the modules of a folder import, read from the source."""
    names = set()
    for path in folder.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == 2:
                names.add(node.module.split(".")[0])
    return names


def test_arrows_left_out_follow_from_those_that_are_drawn():
    diagram = pytest.importorskip("docs.extensions.import_diagram")
    direct = diagram.direct_imports()
    drawn = diagram.without_implied(direct)

    def reached(part):
        return set().union(*({other} | reached(other) for other in drawn[part]))

    assert all(direct[part] <= reached(part) for part in direct)
    assert sum(map(len, drawn.values())) < sum(map(len, direct.values()))
    heights = diagram.levels(drawn)
    assert all(heights[part] > heights[other] for part in drawn for other in drawn[part])


def test_the_picture_names_every_folder(tmp_path):
    diagram = pytest.importorskip("docs.extensions.import_diagram")
    diagram.draw(tmp_path / "imports.svg")
    text = (tmp_path / "imports.svg").read_text()
    assert all(f"<!-- {part} -->" in text for part in diagram.direct_imports())


def test_equations_are_drawn_in_the_color_of_the_text_and_keep_their_source():
    drawn = pytest.importorskip("docs.extensions.equations").drawn
    short, tall = (drawn(tex, inline=True) for tex in (r"r_x < 1", r"\frac{r_x}{1}"))
    assert 'aria-label="r_x &lt; 1"' in short and "currentColor" in short
    height = re.compile(r'height="([\d.]+)"')
    assert float(height.search(tall)[1]) > 1.3 * float(height.search(short)[1])
