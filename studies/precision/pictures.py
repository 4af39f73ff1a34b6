"""Every run of a scene by its family, inextensible ones also by their method; and ratios over the error."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.harness.plot import COLORS, REFERENCE_COLOR, label_axes, new_figure
from studies.harness.ratios import is_usable
from studies.harness.store import Row
from studies.harness.study import Results
from studies.harness.table import column

from .fronts import (
    BY_NATIVE_SOLVERS,
    EXPLICIT,
    FAMILIES,
    IMPLICIT,
    INEXTENSIBLE,
    OPPONENTS,
    OTHERS,
    PEER,
    Front,
    family_of,
    front_of,
    members,
    method_of,
    speed_up,
)  # fmt: skip

_LOOK = {
    INEXTENSIBLE: (COLORS[0], "o"),
    BY_NATIVE_SOLVERS: (COLORS[5], "v"),
    IMPLICIT: (COLORS[1], "s"),
    EXPLICIT: (COLORS[2], "^"),
    PEER: (COLORS[3], "D"),
}
_MARKERS = "osD^v<>PX*h"
_TIME, _ERROR = "CPU time [s]", "largest distance to the reference [m]"
_NAME = "work_precision"


def draw(results: Results, directory: Path) -> list[Path]:
    """One picture a scene, and one of all ratios."""
    references = [row for row in results.of_kind("reference") if _runs(results, row)]
    paths = [_draw_scene(row, _runs(results, row), directory) for row in references]
    return [*paths, _draw_ratios(results, references, directory)] if paths else []


def _runs(results: Results, reference: Row) -> list[Row]:
    return [row for row in results.of_kind("run") if row["scene"] == reference["scene"] and is_usable(row)]


def _draw_scene(reference: Row, runs: Sequence[Row], directory: Path) -> Path:
    path = directory / f"{_NAME}_{reference['scene']}.png"
    with new_figure(path, 12.0, 6.4) as figure:
        left, right = figure.subplots(1, 2)
        _draw_fronts(
            left, {family: members(runs, family) for family in FAMILIES}, reference["uncertainty"], _LOOK
        )
        own = [row for row in runs if family_of(row) in (INEXTENSIBLE, BY_NATIVE_SOLVERS)]
        methods = sorted({method_of(row) for row in own})
        looks = {
            name: (COLORS[k % len(COLORS)], _MARKERS[k % len(_MARKERS)]) for k, name in enumerate(methods)
        }
        groups = {name: [row for row in own if method_of(row) == name] for name in methods}
        _draw_fronts(right, groups, reference["uncertainty"], looks)
        label_axes(left, _TIME, _ERROR, f"{reference['scene']}: all formulations")
        label_axes(right, _TIME, _ERROR, "inextensible cables by method")
        for axes in (left, right):
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
    return path


def _draw_fronts(
    axes: Axes, groups: Mapping[str, Sequence[Row]], uncertainty: float, looks: Mapping[str, tuple[str, str]]
) -> None:
    """Rows as markers, fronts as lines; what the reference cannot tell is shaded."""
    for name, rows in groups.items():
        if not rows:
            continue
        color, marker = looks[name]
        axes.loglog(
            column(rows, "cpuSeconds"), column(rows, "errorMax"), marker, color=color, markersize=3, alpha=0.5
        )
        found = front_of(rows, uncertainty)
        axes.loglog(found.seconds, found.errors, marker, linestyle="-", color=color, markersize=5, label=name)
    bottom = min(axes.get_ylim()[0], 0.5 * uncertainty)
    axes.axhspan(
        bottom, uncertainty, color=REFERENCE_COLOR, alpha=0.3, label="below the reference's uncertainty"
    )
    axes.set_ylim(bottom=bottom)


def _draw_ratios(results: Results, references: Sequence[Row], directory: Path) -> Path:
    path = directory / f"{_NAME}_ratios.png"
    with new_figure(path, 11.0, 8.0) as figure:
        grid = figure.subplots(2, 2, squeeze=False).flat
        for axes, reference in zip(grid, references, strict=False):
            _draw_scene_ratios(axes, _runs(results, reference), reference)
        for axes in list(figure.axes)[len(references) :]:
            axes.set_axis_off()
        handles = {
            label: handle
            for axes in figure.axes
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="outside upper left", ncols=4)
    return path


def _draw_scene_ratios(axes: Axes, runs: Sequence[Row], reference: Row) -> None:
    own = front_of(members(runs, INEXTENSIBLE), reference["uncertainty"])
    for opponent in OTHERS:
        theirs = front_of(filter(OPPONENTS[opponent], runs), reference["uncertainty"])
        errors, ratios = ratio_curve(theirs, own)
        if len(errors):
            axes.loglog(errors, ratios, color=_LOOK[opponent][0], label=opponent)
    if not axes.lines:
        axes.text(0.5, 0.5, "no fronts overlap", transform=axes.transAxes, ha="center")
    axes.axhline(1.0, color="black", linewidth=0.8)
    label_axes(axes, "error [m]", "CPU time over the inextensible cable's [-]", reference["scene"])


def ratio_curve(theirs: Front, own: Front, points: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Errors (n,) [m] and ratios (n,) [-] where both fronts are; empty if they do not overlap."""
    if not (theirs.rows and own.rows):
        return np.array([]), np.array([])
    largest = min(theirs.errors[0], own.errors[0])
    least = max(theirs.errors[-1], own.errors[-1])
    if largest <= least:
        return np.array([]), np.array([])
    inside = np.geomspace(largest, least, points)[1:-1]  # ends may leave a front by rounding
    return inside, np.array([speed_up(theirs, own, float(bound)) for bound in inside])
