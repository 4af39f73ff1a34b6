"""Pictures of studies: curves in panels, in the one style that all pictures have."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from examples.style import COLORS as COLORS
from examples.style import REFERENCE_COLOR as REFERENCE_COLOR
from examples.style import label_axes as label_axes
from examples.style import new_figure as new_figure

from .store import Row
from .table import column


@dataclass(frozen=True)
class Curve:
    """y over x.   style: of line and markers, as for `Axes.plot`; look: further keywords."""

    x: Any
    y: Any
    label: str | None = None
    color: str | None = None
    style: str = "o-"
    look: Mapping[str, Any] = field(default_factory=dict)


def curves_of(
    parts: Mapping[Any, Sequence[Row]], x: str, y: str, styles: Mapping[str, str] | None = None
) -> list[Curve]:
    """One curve a group of rows, in a color of its own.   styles: word of a label -> style."""
    found = []
    for (label, rows), color in zip(parts.items(), COLORS, strict=False):
        style = next((style for word, style in (styles or {}).items() if word in label), "o-")
        found.append(Curve(column(rows, x), column(rows, y), label, color, style))
    return found


@dataclass(frozen=True)
class Panel:
    """Curves in one pair of axes.

    x, y: labels with units.   scale: a method of `Axes`, such as "loglog".
    legend: whether it has one of its own; "below" the axes; "direct": labels at the ends of the curves.
    horizontal, vertical: dotted lines at these values.   ticks: numbers at the x axis.
    unknown: what is below it on the y axis is shaded, as the reference cannot tell it.
    least: where the y axis begins.   names: of y = 0, 1, ..., from above.
    """

    x: str
    y: str
    curves: Sequence[Curve]
    scale: str = "loglog"
    title: str = ""
    legend: bool | str = True
    horizontal: Sequence[float] = ()
    vertical: Sequence[float] = ()
    ticks: Sequence[float] = ()
    unknown: float | None = None
    least: float | None = None
    names: Sequence[str] = ()

    def draw(self, axes: Any) -> None:
        """All of it."""
        for curve in self.curves:
            look = {"label": curve.label, "color": curve.color, **curve.look}
            getattr(axes, self.scale)(curve.x, curve.y, curve.style, **look)
        for value in self.horizontal:
            axes.axhline(value, color="black", linestyle=":", linewidth=1.0)
        for value in self.vertical:
            axes.axvline(value, color="black", linestyle=":", linewidth=1.0)
        if self.unknown:
            bottom = min(axes.get_ylim()[0], 0.5 * self.unknown)
            label = "below the reference's uncertainty"
            axes.axhspan(bottom, self.unknown, color=REFERENCE_COLOR, alpha=0.3, label=label)
            axes.set_ylim(bottom=bottom)
        if self.least:
            axes.set_ylim(bottom=self.least)
        if self.ticks:
            axes.set_xticks(self.ticks, [f"{number:g}" for number in self.ticks])  # no powers of ten
            axes.set_xticks([], minor=True)
        if self.names:
            axes.set_yticks(range(len(self.names)), self.names)
            axes.set_ylim(len(self.names) - 0.5, -0.5)
        label_axes(axes, self.x, self.y, self.title)
        self._name_curves(axes)

    def _name_curves(self, axes: Axes) -> None:
        if self.legend == "direct":
            self._label_ends(axes)
        elif self.legend == "below":
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
        elif self.legend and any(curve.label for curve in self.curves):
            axes.legend(fontsize=8)

    def _label_ends(self, axes: Axes) -> None:
        """Each label in its curve's color, below the last point, and below other labels there."""
        axes.margins(0.12)
        axes.figure.canvas.draw()  # places are known then
        taken: list[Any] = []
        for curve in sorted((c for c in self.curves if c.label), key=lambda c: -c.y[-1]):
            end, look = (curve.x[-1], curve.y[-1]), {"color": curve.color, "fontsize": 9}
            text = axes.annotate(
                str(curve.label), end, (0, -8), textcoords="offset points", ha="center", va="top", **look
            )
            while any(text.get_window_extent().overlaps(other) for other in taken):
                text.xyann = (0, text.xyann[1] - 3)
            taken.append(text.get_window_extent())


def chart(
    path: Path, *panels: Panel, width: float = 8.0, height: float = 4.6, rows: int = 1, columns: int = 0
) -> Path:
    """A picture of panels side by side, in so many rows.   columns: of a common legend above them.

    Panels below each other without a label of their own share the x axis of the last one.
    """
    with new_figure(path, width, height) as figure:
        shares = any(not panel.x for panel in panels)
        all_axes = figure.subplots(rows, math.ceil(len(panels) / rows), squeeze=False, sharex=shares).flat
        for axes, panel in zip_longest(all_axes, panels):
            if panel:
                panel.draw(axes)
            else:
                axes.set_axis_off()
        unique = {}
        for axes in figure.axes if columns else ():
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                unique[label, handle.get_color()] = handle
        if unique:
            labels = [label for label, _ in unique]
            figure.legend(unique.values(), labels, loc="outside upper left", ncols=columns, fontsize=8)
    return path
