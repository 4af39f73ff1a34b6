"""One picture a map."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from studies.harness.benchmark import Figures
from studies.harness.plot import COLORS, REFERENCE_COLOR, label_axes, new_figure
from studies.harness.study import Row

NAME = "stability_"
STEP = "largest stable step h [s]"
LINEAR_MAPS = {
    "zeta": "stabilisation rate zeta [1/s]",
    "stiffness": "EI over its physical value [-]",
    "elements": "elements N [-]",
    "gravity": "gravity g/g_0 [-]",
}
NO_GRAVITY = 1e-1  # shown in place of zero on a logarithmic axis
SIZES = (11.0, 7.0, 4.0, 3.0, 2.0)  # of hollow markers, so that equal ones are seen


def draw(figures: Figures, directory: Path) -> list[Path]:
    """All pictures that there are rows for."""
    paths = [_limits(figures, directory, kind, what) for kind, what in LINEAR_MAPS.items()]
    paths += [
        _curvature(figures, directory),
        _spin(figures, directory),
        _slenderness(figures, directory),
        _violent(figures, directory),
        _long(figures, directory),
        _precision(figures, directory),
    ]
    return [path for path in paths if path is not None]


def _groups(rows: Sequence[Row], key: str = "scheme") -> dict[str, list[Row]]:
    return {
        label: [row for row in rows if row[key] == label] for label in dict.fromkeys(row[key] for row in rows)
    }


def _hollow(color: str, size: float) -> dict[str, Any]:
    return {"color": color, "markersize": size, "fillstyle": "none"}


def _predicted_and_found(axes: Axes, values: list[float], rows: list[Row], scheme: str, style: Any) -> None:
    """A line and hollow markers over `values`.   style: color and size of the markers."""
    color, size = style
    axes.loglog(values, [row["predicted"] for row in rows], color=color, label=f"{scheme}, predicted")
    axes.loglog(values, [row["found"] for row in rows], "o", **_hollow(color, size), label="found")


def _legend_above(axes: Axes) -> None:
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize=8)


def _limits(figures: Figures, directory: Path, kind: str, what: str) -> Path | None:
    """Predicted lines, found markers, and the rule."""
    rows = figures.of_kind(kind)
    if not rows:
        return None
    path = directory / f"{NAME}{kind}.png"
    with new_figure(path, 7.0, 4.6) as figure:
        axes = figure.subplots()
        for (scheme, own), color, size in zip(_groups(rows).items(), COLORS, SIZES, strict=False):
            values = [row["value"] or NO_GRAVITY for row in own]
            _predicted_and_found(axes, values, own, scheme, (color, size))
        first = next(iter(_groups(rows).values()))
        values = [row["value"] or NO_GRAVITY for row in first]
        axes.loglog(values, [row["rule"] for row in first], ":", color="black", label="rule (37), C = 0.7")
        label_axes(axes, what, STEP)
        _legend_above(axes)
    return path


def _curvature(figures: Figures, directory: Path) -> Path | None:
    """The critical C of Eq. (37): what the limit is in units of the rule."""
    rows = figures.of_kind("curvature")
    if not rows:
        return None
    path = directory / f"{NAME}curvature.png"
    with new_figure(path, 9.0, 4.0) as figure:
        turning, sagging = figure.subplots(1, 2, sharey=True)
        for (scheme, own), color, size in zip(_groups(rows).items(), COLORS, SIZES, strict=False):
            for cable, marker in (("straight", "^"), ("coil", "o"), ("ring", "s")):
                part = [row for row in own if row["cable"] == cable]
                label = f"{scheme}, {cable}"
                turning.plot(
                    [row["value"] for row in part],
                    _critical(part),
                    marker,
                    **_hollow(color, size),
                    label=label,
                )
            part = [row for row in own if row["cable"] == "sagging"]
            sagging.plot(
                [row["value"] for row in part], _critical(part), marker + "-", color=color, label=scheme
            )
        for axes in (turning, sagging):
            axes.axhline(0.7, color="black", linestyle=":")
            axes.legend(fontsize=8)
        label_axes(turning, "turning of an element [rad]", "critical C of Eq. (37) [-]")
        label_axes(sagging, "span over length of a sagging cable [-]", "")
    return path


def _critical(rows: Sequence[Row]) -> list[float]:
    return [0.7 / row["ruleOverLimit"] for row in rows]


def _spin(figures: Figures, directory: Path) -> Path | None:
    rows = figures.of_kind("spin")
    if not rows:
        return None
    path = directory / f"{NAME}spin.png"
    with new_figure(path, 7.0, 4.8) as figure:
        axes = figure.subplots()
        for (scheme, own), color, size in zip(_groups(rows).items(), COLORS, SIZES, strict=False):
            rates = [row["value"] for row in own]
            axes.loglog(
                rates, [row["found"] for row in own], "o", **_hollow(color, size), label=f"{scheme}, found"
            )
            axes.loglog(
                rates, [row["predictedInMotion"] for row in own], color=color, label="linearised step"
            )
            axes.loglog(rates, [row["predicted"] for row in own], "--", color=color, linewidth=0.8)
        label_axes(axes, "rate of spin [rad/s]", "largest stable step h (dashed: of w_max alone) [s]")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=8)
    return path


def _slenderness(figures: Figures, directory: Path) -> Path | None:
    rows = figures.of_kind("slenderness")
    if not rows:
        return None
    path = directory / f"{NAME}slenderness.png"
    with new_figure(path, 7.0, 4.6) as figure:
        axes = figure.subplots()
        for (scheme, own), color, size in zip(_groups(rows).items(), COLORS, SIZES, strict=False):
            values = [row["value"] for row in own]
            _predicted_and_found(axes, values, own, scheme, (color, size))
            inextensible = [row["inextensible"] for row in own]
            axes.loglog(values, inextensible, "--", color=color, label="inextensible")
        label_axes(axes, "EA / EI of the conventional cable [1/m^2]", STEP)
        _legend_above(axes)
    return path


def _violent(figures: Figures, directory: Path) -> Path | None:
    rows = figures.of_kind("violent")
    if not rows:
        return None
    path = directory / f"{NAME}violent.png"
    with new_figure(path, 7.0, 4.6) as figure:
        axes = figure.subplots()
        for (label, own), color in zip(_groups(rows, "label").items(), COLORS, strict=False):
            speeds = [row["value"] for row in own]
            shown = [row["part"] or math.nan for row in own]
            axes.loglog(speeds, shown, "o-", color=color, label=label)
            allowed = [row["predictedInMotion"] / row["predicted"] for row in own]
            axes.loglog(speeds, allowed, "--", color=color, linewidth=0.8)
        label_axes(
            axes,
            "largest speed at the start [m/s]",
            "step over the limit at rest (dashed: w_max in motion) [-]",
        )
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=8)
    return path


def _long(figures: Figures, directory: Path) -> Path | None:
    """How long each run lasted, and how well it kept its energy."""
    rows = figures.of_kind("long")
    if not rows:
        return None
    path = directory / f"{NAME}long_runs.png"
    with new_figure(path, 10.0, 1.6 + 0.28 * len(rows)) as figure:
        seconds, energy = figure.subplots(1, 2, sharey=True)
        names = [f"{row['label']}, {row['scene']}, {row['value']:.0e} steps" for row in rows]
        colors = [COLORS[0] if row["survives"] else COLORS[1] for row in rows]
        seconds.barh(names, [row["seconds"] for row in rows], color=colors, log=True)
        energy.barh(names, [max(row["energyMax"], 1e-16) for row in rows], color=colors, log=True)
        seconds.invert_yaxis()
        energy.axvline(1e-3, color=REFERENCE_COLOR, linestyle=":")
        label_axes(seconds, "time that the run lasted [s]", "", "orange: diverged")
        label_axes(energy, "change of the energy over the swing [-]", "")
    return path


def _precision(figures: Figures, directory: Path) -> Path | None:
    rows = figures.of_kind("precision")
    if not rows:
        return None
    path = directory / f"{NAME}precision.png"
    with new_figure(path, 9.0, 4.0) as figure:
        limits, noise = figure.subplots(1, 2)
        for (scheme, own), color in zip(_groups(rows).items(), COLORS, strict=False):
            for bits, style in ((32, "o-"), (64, "s--")):
                part = [row for row in own if row["bits"] == bits]
                numbers = [row["value"] for row in part]
                limits.semilogx(numbers, [row["ratio"] for row in part], style, color=color)
                values = [row["noise"] or math.nan for row in part]
                noise.loglog(numbers, values, style, color=color, label=f"{scheme}, {bits} bit")
        label_axes(limits, "elements N [-]", "found over predicted limit [-]")
        label_axes(noise, "elements N [-]", "noise at half the limit [-]")
        figure.legend(*noise.get_legend_handles_labels(), loc="outside upper left", ncols=3, fontsize=8)
    return path
