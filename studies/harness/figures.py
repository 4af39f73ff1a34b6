"""The pictures that studies share: curves against the reference, cost and accuracy, convergence."""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from reference_models.trajectory import Trajectory

from .plot import COLORS, REFERENCE_COLOR, Curve, Panel, chart
from .ratios import BY_NATIVE_SOLVERS, EXPLICIT, IMPLICIT, INEXTENSIBLE, PEER, family_of, front, is_usable
from .reference import positions_at
from .store import Row
from .table import column, groups

TIME = "time t [s]"
COST_AXES = "CPU time [s]", "largest distance to the reference [m]"
THICK = {"linewidth": 4}  # of what is below all others
_LINE_STYLES = ("--", "-.", ":")
LOOKS = {
    INEXTENSIBLE: (COLORS[0], "o"),
    BY_NATIVE_SOLVERS: (COLORS[4], "P"),
    IMPLICIT: (COLORS[1], "s"),
    EXPLICIT: (COLORS[2], "^"),
    PEER: (COLORS[3], "D"),
}
"""Family of rows -> color and marker."""


def draw_trajectories(
    path: Path, curves: Mapping[str, Trajectory], reference: Trajectory, components: Sequence[str]
) -> Path:
    """The components of a point, by label, over the reference, and the distance to it."""
    end, panels = max((curve.times[-1] for curve in curves.values()), default=math.inf), []
    shown = reference.times <= end + 1e-9
    times, positions = reference.times[shown], reference.positions[shown]
    for k, component in enumerate(components):
        lines = [Curve(times, positions[:, k], "reference", REFERENCE_COLOR, "-", THICK)]
        for style, (label, curve) in zip(_LINE_STYLES, curves.items(), strict=False):
            lines.append(Curve(curve.times, curve.positions[:, k], label, style=style))
        panels.append(Panel("", component, lines, "plot", legend=False))
    distances = []
    for curve in curves.values():
        lengths = np.linalg.norm(curve.positions - positions_at(reference, curve.times), axis=1)
        distances.append(Curve(curve.times[1:], lengths[1:], style="-", look={"linewidth": 1.0}))
    panels.append(Panel(TIME, "distance to the reference [m]", distances, "semilogy", least=1e-6))
    rows = len(panels)
    return chart(path, *panels, height=3.0 * rows, rows=rows, columns=1)


def draw_cost_and_accuracy(path: Path, rows: Sequence[Row]) -> Path:
    """The largest error of every usable row over its CPU time; a line joins the best of a kind."""
    families = groups([row | {"family": family_of(row)} for row in rows if is_usable(row)], "family")
    return chart(path, Panel(*COST_AXES, front_curves(families, LOOKS), legend="direct"), height=5.0)


def front_curves(
    parts: Mapping[str, Sequence[Row]],
    looks: Mapping[str, tuple[str, str]],
    front_of: Callable[[Sequence[Row]], list[Row]] = front,
) -> list[Curve]:
    """Rows as faint markers, fronts as lines."""
    curves = []
    for name, rows in parts.items():
        color, marker = looks[name]
        for some, label, style, look in (
            (rows, None, marker, {"markersize": 3, "alpha": 0.5}),
            (front_of(rows), name, marker + "-", {"markersize": 5, "linewidth": 0.8}),
        ):
            curves.append(
                Curve(column(some, "cpuSeconds"), column(some, "errorMax"), label, color, style, look)
            )
    return curves
