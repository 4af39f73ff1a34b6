"""The diagram of imports, drawn from the code at each build: docs/generated/imports.svg."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import grimp
from matplotlib.axes import Axes

from examples.style import COLORS, REFERENCE_COLOR, styled_figure

PACKAGE = "exudyn_inext"
OTHERS = ("reference_models", "studies", "examples")
BINDING = "exudyn_binding"

Imports = Mapping[str, set[str]]


def direct_imports() -> dict[str, set[str]]:
    """Folder or module of the package, or other top-level package -> what of these it imports."""
    graph = grimp.build_graph(PACKAGE, *OTHERS, cache_dir=None)
    parts = [*graph.find_children(PACKAGE), *OTHERS]
    for part in parts:
        if graph.find_children(part):
            graph.squash_module(part)
    found = {part: graph.find_modules_directly_imported_by(part) for part in parts}
    surface = {PACKAGE: {f"{PACKAGE}.{BINDING}"}}  # the package itself hands out what the binding defines
    named = {
        part: {other for name in imported for other in surface.get(name, {name}) if other != part}
        for part, imported in found.items()
    }
    return {_short(part): {_short(name) for name in imported} for part, imported in named.items()}


def _short(name: str) -> str:
    return name.removeprefix(f"{PACKAGE}.")


def without_implied(imports: Imports) -> dict[str, set[str]]:
    """The imports that do not follow from others: their transitive reduction."""

    def reached(part: str) -> set[str]:
        return set().union(*({other} | reached(other) for other in imports[part]))

    return {
        part: {one for one in direct if not any(one in reached(other) for other in direct - {one})}
        for part, direct in imports.items()
    }


def levels(imports: Imports) -> dict[str, int]:
    """How many imports deep each part stands on those that import nothing."""

    def level(part: str) -> int:
        return max((1 + level(other) for other in imports[part]), default=0)

    return {part: level(part) for part in imports}


def places(imports: Imports) -> dict[str, tuple[float, float]]:
    """x, y of each part: levels are rows; within a row, near what it imports."""
    heights, placed = levels(imports), {}
    for height in range(max(heights.values()) + 1):
        row = sorted(part for part in heights if heights[part] == height)
        row.sort(key=lambda part: sum(placed[o][0] for o in imports[part]) / max(1, len(imports[part])))
        for k, part in enumerate(row):
            shift = 0.3 if height % 2 else -0.3  # so that no arrow runs through the row between
            placed[part] = (k - 0.5 * (len(row) - 1) + shift, float(height))
    return placed


def draw(path: Path) -> None:
    """Write the picture (SVG, text as text)."""
    imports = without_implied(direct_imports())
    at = places(imports)
    path.parent.mkdir(parents=True, exist_ok=True)
    with styled_figure(7.0, 0.75 * (1 + max(y for _, y in at.values()))) as figure:
        axes = figure.subplots()
        axes.axis("off")
        axes.set_xlim(min(x for x, _ in at.values()) - 0.6, max(x for x, _ in at.values()) + 0.6)
        axes.set_ylim(-0.5, max(y for _, y in at.values()) + 0.5)
        boxes = {part: _box(axes, part, *at[part]) for part in imports}
        for part, others in imports.items():
            for other in others:
                ends = {"patchA": boxes[part], "patchB": boxes[other], "shrinkA": 1, "shrinkB": 1}
                style = {"arrowstyle": "->", "color": REFERENCE_COLOR}
                axes.annotate("", xy=at[other], xytext=at[part], arrowprops=style | ends, zorder=1)
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def _box(axes: Axes, part: str, x: float, y: float) -> Any:
    """The name of a part in a frame; returns the frame."""
    color = COLORS[1] if part in OTHERS else COLORS[0]
    frame = {"boxstyle": "round,pad=0.35", "facecolor": "white", "edgecolor": color}
    return axes.text(x, y, part, ha="center", va="center", fontsize=9, bbox=frame).get_bbox_patch()


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("builder-inited", lambda app: draw(Path(app.srcdir) / "generated" / "imports.svg"))
    return {"parallel_read_safe": True}
