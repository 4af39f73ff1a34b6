"""The pictures that studies share: curves against the reference, cost and accuracy, convergence."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from scipy.interpolate import CubicSpline

from reference_models.trajectory import Array, Trajectory

from .error import distance_to_reference
from .front import front, is_implicit, is_usable
from .plot import COLORS, REFERENCE_COLOR, label_axes, new_figure
from .study import Row

TIME = "time t [s]"
_LINE_STYLES = ("--", "-.", ":")
_KINDS = {
    "native, implicit": (COLORS[1], "s"),
    "native, explicit": (COLORS[2], "^"),
    "inextensible": (COLORS[0], "o"),
    "compiled steps": (COLORS[5], "v"),
}


def draw_trajectories(
    path: Path, curves: Mapping[str, Trajectory], reference: Trajectory, point: str, components: str = "xy"
) -> Path:
    """The components of a point over the reference, and the distance to it."""
    times, positions = _until(reference, curves)
    with new_figure(path, 8.0, 3.0 * (len(components) + 1)) as figure:
        *tops, error = figure.subplots(len(components) + 1, 1, sharex=True)
        for component, axes in zip(components, tops, strict=True):
            index = "xyz".index(component)
            axes.plot(times, positions[:, index], color=REFERENCE_COLOR, linewidth=4, label="reference")
            _draw_component(axes, curves, index)
            label_axes(axes, "", f"{point} {component} [m]")
        _draw_distances(error, curves, reference)
        label_axes(error, TIME, "distance to the reference [m]")
        figure.legend(*tops[0].get_legend_handles_labels(), loc="outside upper left")
    return path


def _until(reference: Trajectory, curves: Mapping[Any, Trajectory]) -> tuple[Array, Array]:
    """Times and positions of the reference, to the end of the longest curve."""
    end = max((curve.times[-1] for curve in curves.values()), default=reference.times[-1])
    shown = reference.times <= end + 1e-9
    return reference.times[shown], reference.positions[shown]


def _draw_component(axes: Axes, curves: Mapping[str, Trajectory], index: int) -> None:
    for style, (label, curve) in zip(_LINE_STYLES, curves.items(), strict=False):
        axes.plot(curve.times, curve.positions[:, index], style, label=label)


def _draw_distances(axes: Axes, curves: Mapping[str, Trajectory], reference: Trajectory) -> None:
    spline = CubicSpline(reference.times, reference.positions)
    for curve in curves.values():
        lengths = np.linalg.norm(curve.positions - spline(curve.times), axis=1)
        axes.semilogy(curve.times[1:], lengths[1:], linewidth=1.0)
    axes.set_ylim(bottom=1e-6)


def draw_path(path: Path, curves: Mapping[str, Trajectory], reference: Trajectory, point: str) -> Path:
    """The path of a point in space, and its plan view (seen along z)."""
    _, positions = _until(reference, curves)
    runs = [curve.positions for curve in curves.values()]
    with new_figure(path, 11.0, 5.2) as figure:
        space: Any = figure.add_subplot(1, 2, 1, projection="3d")
        plan = figure.add_subplot(1, 2, 2, aspect="equal")
        space.plot(*positions.T, color=REFERENCE_COLOR, linewidth=4, label="reference")
        plan.plot(*positions.T[:2], color=REFERENCE_COLOR, linewidth=4)
        for style, label, run in zip(_LINE_STYLES, curves, runs, strict=False):
            space.plot(*run.T, style, label=label)
            plan.plot(*run.T[:2], style)
        space.set_box_aspect(np.ptp(positions, axis=0))
        space.locator_params(nbins=5)
        label_axes(space, f"{point} x [m]", f"{point} y [m]")
        space.set_zlabel(f"{point} z [m]", labelpad=5)
        label_axes(plan, f"{point} x [m]", f"{point} y [m]", "seen from above")
        figure.legend(*space.get_legend_handles_labels(), loc="outside upper left")
    return path


def draw_cost_and_accuracy(path: Path, rows: Sequence[Row]) -> Path:
    """CPU time against the largest error of every usable row; a line joins the best of a kind."""
    with new_figure(path) as figure:
        axes = figure.subplots()
        for kind, (color, marker) in _KINDS.items():
            members = [row for row in rows if is_usable(row) and _kind(row) == kind]
            if members:
                axes.loglog(*_points(members), marker, color=color, label=kind)
                axes.loglog(*_points(front(members)), color=color, linewidth=0.8)
        label_axes(axes, "largest distance to the reference [m]", "CPU time [s]")
        axes.legend()
    return path


def _kind(row: Row) -> str:
    if row["formulation"] in _KINDS:
        return str(row["formulation"])
    return "native, implicit" if is_implicit(row) else "native, explicit"


def _points(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    return [row["errorMax"] for row in rows], [row["cpuSeconds"] for row in rows]


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
    with new_figure(path, 10.0, 4.6) as figure:
        curves, errors = figure.subplots(1, 2)
        _draw_meshes(curves, next(iter(meshes.values())), reference)
        if window:
            _zoom(curves, reference, window)
        label_axes(curves, TIME, f"{point} y [m]", f"{next(iter(meshes))}, N elements")
        native_colors = iter(COLORS[1:])
        for (label, series), marker in zip(meshes.items(), "s^oD", strict=False):
            maxima = [distance_to_reference(run, reference).maximum for run in series.values()]
            color = COLORS[0] if label == "inextensible" else next(native_colors)
            errors.loglog(list(series), maxima, marker + "-", color=color, label=label)
        label_axes(errors, "number of elements N [-]", "largest distance to the reference [m]")
        name_ticks(errors, sorted({number for series in meshes.values() for number in series}))
        errors.legend()
        figure.legend(*curves.get_legend_handles_labels(), loc="outside lower left", ncols=8)
    return path


def _draw_meshes(axes: Axes, meshes: Mapping[int, Trajectory], reference: Trajectory) -> None:
    times, positions = _until(reference, meshes)
    axes.plot(times, positions[:, 1], color=REFERENCE_COLOR, linewidth=4, label="reference")
    for number, run in meshes.items():
        axes.plot(run.times, run.positions[:, 1], linewidth=1.0, label=f"N = {number}")


def _zoom(axes: Axes, reference: Trajectory, window: tuple[float, float]) -> None:
    """Show y(t) of the reference within the window [s], and a fifth of its range around it."""
    start, end = window
    values = reference.positions[(reference.times >= start) & (reference.times <= end), 1]
    margin = 0.2 * np.ptp(values)
    axes.set_xlim(start, end)
    axes.set_ylim(values.min() - margin, values.max() + margin)


def name_ticks(axes: Axes, numbers: Sequence[float]) -> None:
    """Plain numbers where the markers are, instead of powers of ten."""
    axes.set_xticks(numbers, [f"{number:g}" for number in numbers])
    axes.set_xticks([], minor=True)
