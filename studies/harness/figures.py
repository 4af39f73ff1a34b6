"""The pictures that studies share: curves against the reference, cost and accuracy, convergence."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from reference_models.trajectory import Trajectory

from .plot import COLORS, REFERENCE_COLOR, Curve, Panel, chart, label_axes, new_figure
from .ratios import front, is_implicit, is_usable
from .reference import distance_to_reference, positions_at
from .store import Row
from .table import column

TIME = "time t [s]"
COST_AXES = "CPU time [s]", "largest distance to the reference [m]"
THICK = {"linewidth": 4}  # of what is below all others
_LINE_STYLES = ("--", "-.", ":")
_KINDS = {
    "native, implicit": (COLORS[1], "s"),
    "native, explicit": (COLORS[2], "^"),
    "inextensible": (COLORS[0], "o"),
    "compiled steps": (COLORS[5], "v"),
}


def draw_trajectories(
    path: Path, curves: Mapping[str, Trajectory], reference: Trajectory, components: Sequence[str]
) -> Path:
    """The components of a point, by label, over the reference, and the distance to it."""
    shown, panels = _until(reference, curves), []
    for k, component in enumerate(components):
        lines = [Curve(shown.times, shown.positions[:, k], "reference", REFERENCE_COLOR, "-", THICK)]
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


def _until(reference: Trajectory, curves: Mapping[Any, Trajectory]) -> Trajectory:
    """The reference, to the end of the longest curve."""
    end = max((curve.times[-1] for curve in curves.values()), default=reference.times[-1])
    shown = reference.times <= end + 1e-9
    return Trajectory(reference.times[shown], reference.positions[shown])


def draw_path(path: Path, curves: Mapping[str, Trajectory], reference: Trajectory, point: str) -> Path:
    """The path of a point in space, and its plan view (seen along z)."""
    positions = _until(reference, curves).positions
    x, y, z = (f"{point} {axis} [m]" for axis in "xyz")
    with new_figure(path, 11.0, 5.2) as figure:
        space: Any = figure.add_subplot(1, 2, 1, projection="3d")
        plan = figure.add_subplot(1, 2, 2, aspect="equal")
        space.plot(*positions.T, color=REFERENCE_COLOR, linewidth=4, label="reference")
        plan.plot(*positions.T[:2], color=REFERENCE_COLOR, linewidth=4)
        for style, (label, curve) in zip(_LINE_STYLES, curves.items(), strict=False):
            space.plot(*curve.positions.T, style, label=label)
            plan.plot(*curve.positions.T[:2], style)
        space.set_box_aspect(np.ptp(positions, axis=0))
        space.locator_params(nbins=5)
        label_axes(space, x, y)
        space.set_zlabel(z, labelpad=5)
        label_axes(plan, x, y, "seen from above")
        figure.legend(*space.get_legend_handles_labels(), loc="outside upper left")
    return path


def draw_cost_and_accuracy(path: Path, rows: Sequence[Row]) -> Path:
    """The largest error of every usable row over its CPU time; a line joins the best of a kind."""
    curves = []
    for kind, (color, marker) in _KINDS.items():
        members = [row for row in rows if is_usable(row) and _kind(row) == kind]
        for own, label, style in ((members, None, marker), (front(members), kind, "-")):
            points = column(own, "cpuSeconds"), column(own, "errorMax")
            curves += [Curve(*points, label, color, style, {"linewidth": 0.8})] if own else []
    return chart(path, Panel(*COST_AXES, curves, legend="direct"), height=5.0)


def _kind(row: Row) -> str:
    if row["formulation"] in _KINDS:
        return str(row["formulation"])
    return "native, implicit" if is_implicit(row) else "native, explicit"


def draw_convergence(
    path: Path,
    meshes: Mapping[str, Mapping[int, Trajectory]],
    reference: Trajectory,
    point: str,
    window: tuple[float, float] | None = None,
) -> Path:
    """Left: y(t) for the meshes of the first series; right: error against elements, all series.

    window: the part of the motion that is shown on the left [s]; None: all of it.
    """
    name, first = next(iter(meshes.items()))
    start, end = window or (0.0, max(run.times[-1] for run in first.values()))
    runs = {"reference": reference, **{f"N = {number}": run for number, run in first.items()}}
    curves = []
    for label, run in runs.items():
        shown = (run.times >= start - 1e-9) & (run.times <= end + 1e-9)
        look = (REFERENCE_COLOR, "-", THICK) if run is reference else (None, "-", {"linewidth": 1.0})
        curves.append(Curve(run.times[shown], run.positions[shown, 1], label, *look))
    native_colors, errors = iter(COLORS[1:]), []
    for (label, series), marker in zip(meshes.items(), "s^oD", strict=False):
        maxima = [distance_to_reference(run, reference).maximum for run in series.values()]
        color = COLORS[0] if label == "inextensible" else next(native_colors)
        errors.append(Curve(list(series), maxima, label, color, marker + "-"))
    numbers = sorted({number for series in meshes.values() for number in series})
    return chart(
        path,
        Panel(TIME, f"{point} y [m]", curves, "plot", f"{name}, N elements"),
        Panel("number of elements N [-]", "largest distance to the reference [m]", errors, ticks=numbers),
        width=10.0,
    )
