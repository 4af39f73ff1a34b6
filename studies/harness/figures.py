"""The pictures that studies share: curves against the reference, cost and accuracy, convergence."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from scipy.interpolate import CubicSpline

from reference_models.trajectory import Trajectory

from .error import distance_to_reference
from .front import front, is_implicit, is_usable
from .plot import COLORS, REFERENCE_COLOR, label_axes, new_figure
from .study import Row

TIME = "time t [s]"
_KINDS = {
    "native, implicit": (COLORS[1], "s"),
    "native, explicit": (COLORS[2], "^"),
    "inextensible": (COLORS[0], "o"),
}


def draw_trajectories(
    path: Path, curves: Mapping[str, Trajectory], reference: Trajectory, point: str
) -> Path:
    """x(t), y(t) of a point over the reference, and the distance to it."""
    end = max((curve.times[-1] for curve in curves.values()), default=reference.times[-1])
    shown = reference.times <= end + 1e-9
    with new_figure(path, 8.0, 9.0) as figure:
        x, y, error = figure.subplots(3, 1, sharex=True)
        for index, axes in enumerate((x, y)):
            times, values = reference.times[shown], reference.positions[shown, index]
            axes.plot(times, values, color=REFERENCE_COLOR, linewidth=4, label="reference")
            _draw_component(axes, curves, index)
            label_axes(axes, "", f"{point} {'xy'[index]} [m]")
        _draw_distances(error, curves, reference)
        label_axes(error, TIME, "distance to the reference [m]")
        figure.legend(*x.get_legend_handles_labels(), loc="outside upper left")
    return path


def _draw_component(axes: Axes, curves: Mapping[str, Trajectory], index: int) -> None:
    for style, (label, curve) in zip(("--", "-.", ":"), curves.items(), strict=False):
        axes.plot(curve.times, curve.positions[:, index], style, label=label)


def _draw_distances(axes: Axes, curves: Mapping[str, Trajectory], reference: Trajectory) -> None:
    spline = CubicSpline(reference.times, reference.positions)
    for curve in curves.values():
        lengths = np.linalg.norm(curve.positions - spline(curve.times), axis=1)
        axes.semilogy(curve.times[1:], lengths[1:], linewidth=1.0)
    axes.set_ylim(bottom=1e-6)


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
    if row["formulation"] == "inextensible":
        return "inextensible"
    return "native, implicit" if is_implicit(row) else "native, explicit"


def _points(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    return [row["errorMax"] for row in rows], [row["cpuSeconds"] for row in rows]


def draw_convergence(
    path: Path, meshes: Mapping[str, Mapping[int, Trajectory]], reference: Trajectory, point: str
) -> Path:
    """Left: y(t) for the meshes of the first series; right: error against elements, all series."""
    with new_figure(path, 10.0, 4.6) as figure:
        curves, errors = figure.subplots(1, 2)
        _draw_meshes(curves, next(iter(meshes.values())), reference)
        label_axes(curves, TIME, f"{point} y [m]", f"{next(iter(meshes))}, N elements")
        native_colors = iter(COLORS[1:])
        for (label, series), marker in zip(meshes.items(), "s^oD", strict=False):
            maxima = [distance_to_reference(run, reference).maximum for run in series.values()]
            color = COLORS[0] if label == "inextensible" else next(native_colors)
            errors.loglog(list(series), maxima, marker + "-", color=color, label=label)
        label_axes(errors, "number of elements N [-]", "largest distance to the reference [m]")
        _name_ticks(errors, sorted({number for series in meshes.values() for number in series}))
        errors.legend()
        figure.legend(*curves.get_legend_handles_labels(), loc="outside lower left", ncols=8)
    return path


def _draw_meshes(axes: Axes, meshes: Mapping[int, Trajectory], reference: Trajectory) -> None:
    end = max(run.times[-1] for run in meshes.values())
    shown = reference.times <= end + 1e-9
    times, values = reference.times[shown], reference.positions[shown, 1]
    axes.plot(times, values, color=REFERENCE_COLOR, linewidth=4, label="reference")
    for number, run in meshes.items():
        axes.plot(run.times, run.positions[:, 1], linewidth=1.0, label=f"N = {number}")


def _name_ticks(axes: Axes, numbers: Sequence[int]) -> None:
    """Plain numbers at the element counts instead of powers of ten."""
    axes.set_xticks(numbers, [str(number) for number in numbers])
    axes.set_xticks([], minor=True)
