"""All pictures have one style, and one module sets it."""

import ast
from itertools import pairwise

import pytest
from matplotlib.colors import to_rgb

from examples.style import COLORS, REFERENCE_COLOR, styled_figure
from studies.harness.plot import Curve, Panel
from tests.documents import ROOT

STYLE = ROOT / "examples" / "style.py"
SOURCES = [
    path
    for folder in ("exudyn_inext", "reference_models", "studies", "examples", "docs/extensions")
    for path in sorted((ROOT / folder).rglob("*.py"))
    if path != STYLE
]
TYPES_AND_FILMS = {"matplotlib.axes", "matplotlib.figure", "matplotlib.animation", "matplotlib.ticker"}


def imports(path):
    """Modules of matplotlib that a file imports; one that does not name it is not parsed."""
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text if "matplotlib" in text else "")):
        names = [node.module] if isinstance(node, ast.ImportFrom) and node.level == 0 else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        yield from (name for name in names if name.startswith("matplotlib"))


def test_nothing_but_the_style_module_makes_figures_or_sets_styles():
    found = {str(path.relative_to(ROOT)): set(imports(path)) for path in SOURCES}
    assert {path: names for path, names in found.items() if names - TYPES_AND_FILMS} == {}
    assert any(found.values())


def machado_deuteranope(color):
    """How a color looks without green receptors (Machado, Oliveira, Fernandes, IEEE TVCG 15 (2009) 1291)."""
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(color))
    return (
        0.367322 * r + 0.860646 * g - 0.227968 * b,
        0.280085 * r + 0.672501 * g + 0.047413 * b,
        -0.011820 * r + 0.042940 * g + 0.968881 * b,
    )


@pytest.mark.parametrize("first", range(4))
def test_the_first_colors_differ_for_a_deuteranope(first):
    seen = [machado_deuteranope(color) for color in (*COLORS[:4], REFERENCE_COLOR)]
    for second in range(first):
        assert sum((a - b) ** 2 for a, b in zip(seen[first], seen[second], strict=True)) > 0.01


def test_no_color_comes_twice():
    assert len({to_rgb(color) for color in (*COLORS, REFERENCE_COLOR)}) == len(COLORS) + 1 > 8


def test_labels_of_curves_that_end_together_stand_below_each_other():
    curves = [Curve([1, 2], [1, 2 + 0.001 * k], f"curve {k}", COLORS[k]) for k in range(3)]
    with styled_figure(6, 4) as figure:
        axes = figure.subplots()
        Panel("x [-]", "y [-]", curves, legend="direct").draw(axes)
        figure.canvas.draw()
        places = [text.get_window_extent() for text in axes.texts]
        assert [text.get_text() for text in axes.texts] == ["curve 2", "curve 1", "curve 0"]
        assert [to_rgb(text.get_color()) for text in axes.texts] == [to_rgb(COLORS[k]) for k in (2, 1, 0)]
        assert all(lower.y1 <= upper.y0 for upper, lower in pairwise(places))
        assert all(axes.get_window_extent().containsy(place.y0) for place in places)
