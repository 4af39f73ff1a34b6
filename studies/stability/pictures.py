"""One picture a map."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

from studies.harness import Results, Row, column, groups
from studies.harness.plot import COLORS, REFERENCE_COLOR, Curve, Panel, chart, label_axes, new_figure

from .linear import MAPS

STEP = "largest stable step h [s]"
NO_GRAVITY = 1e-1  # shown in place of zero on a logarithmic axis
SIZES = (11.0, 7.0, 4.0, 3.0, 2.0)  # of hollow markers, so that equal ones are seen
THIN = {"linewidth": 0.8}


def draw(results: Results, directory: Path) -> list[Path]:
    """All pictures that there are rows for."""
    paths = []
    for kind, (make, width, height, columns) in PICTURES.items():
        if rows := results.of_kind(kind):
            path = directory / f"stability_{kind}.png"
            paths.append(chart(path, *make(rows), width=width, height=height, columns=columns))
    if rows := results.of_kind("long"):
        paths.append(_long(rows, directory / "stability_long_runs.png"))
    return paths


def _by(rows: Sequence[Row], key: str = "scheme") -> Iterator[tuple[str, list[Row], str, float]]:
    """Label, rows, color, size of markers."""
    for (label, own), color, size in zip(groups(rows, key).items(), COLORS, SIZES, strict=False):
        yield label, own, color, size


def _once(label: str, own: Sequence[Row], rows: Sequence[Row]) -> str | None:
    """The label of what means the same for all schemes, at the first one."""
    return label if own[0] is rows[0] else None


def _hollow(size: float) -> dict[str, object]:
    return {"markersize": size, "fillstyle": "none"}


def _predicted_and_found(rows: Sequence[Row]) -> Iterator[Curve]:
    """A line and hollow markers for each scheme."""
    for scheme, own, color, size in _by(rows):
        values = [row["value"] or NO_GRAVITY for row in own]
        yield Curve(values, column(own, "predicted"), f"{scheme}, predicted", color, "-")
        yield Curve(values, column(own, "found"), _once("found", own, rows), color, "o", _hollow(size))


def _limits(what: str, rows: Sequence[Row]) -> list[Panel]:
    """Predicted lines, found markers, and the rule."""
    _, first, *_ = next(_by(rows))
    values = [row["value"] or NO_GRAVITY for row in first]
    rule = Curve(values, column(first, "rule"), "rule (37), C = 0.7", "black", ":")
    return [Panel(what, STEP, [*_predicted_and_found(rows), rule], legend=False)]


def _curvature(rows: Sequence[Row]) -> list[Panel]:
    """The critical C of Eq. (37): what the limit is in units of the rule."""
    turning, sagging = [], []
    for scheme, own, color, size in _by(rows):
        for cable, part in groups(own, "cable").items():
            critical = [0.7 / row["ruleOverLimit"] for row in part]
            style = {"straight": "^", "coil": "o", "ring": "s"}.get(cable)
            if style:
                label = f"{scheme}, {cable}"
                turning.append(Curve(column(part, "value"), critical, label, color, style, _hollow(size)))
            else:
                sagging.append(Curve(column(part, "value"), critical, scheme, color, "^-"))
    y = "critical C of Eq. (37) [-]"
    return [
        Panel("turning of an element [rad]", y, turning, "plot", horizontal=(0.7,)),
        Panel("span over length of a sagging cable [-]", y, sagging, "plot", horizontal=(0.7,)),
    ]


def _spin(rows: Sequence[Row]) -> list[Panel]:
    curves = []
    for scheme, own, color, size in _by(rows):
        rates = column(own, "value")
        curves += [
            Curve(rates, column(own, "found"), _once("found", own, rows), color, "o", _hollow(size)),
            Curve(rates, column(own, "predictedInMotion"), f"{scheme}, linearised step", color, "-"),
            Curve(rates, column(own, "predicted"), None, color, "--", THIN),
        ]
    y = "largest stable step h (dashed: of w_max alone) [s]"
    return [Panel("rate of spin [rad/s]", y, curves, legend=False)]


def _slenderness(rows: Sequence[Row]) -> list[Panel]:
    curves = list(_predicted_and_found(rows))
    for _, own, color, _ in _by(rows):
        values = column(own, "value"), column(own, "inextensible")
        curves.append(Curve(*values, _once("inextensible", own, rows), color, "--"))
    return [Panel("EA / EI of the native cable [1/m^2]", STEP, curves, legend=False)]


def _violent(rows: Sequence[Row]) -> list[Panel]:
    curves = []
    for (label, own), color in zip(groups(rows, "label").items(), COLORS, strict=False):
        speeds, parts = column(own, "value"), [row["part"] or math.nan for row in own]
        allowed = [row["predictedInMotion"] / row["predicted"] for row in own]
        curves.append(Curve(speeds, parts, label, color))
        curves.append(Curve(speeds, allowed, None, color, "--", THIN))
    y = "step over the limit at rest (dashed: w_max in motion) [-]"
    return [Panel("largest speed at the start [m/s]", y, curves, legend=False)]


def _precision(rows: Sequence[Row]) -> list[Panel]:
    limits, noise = [], []
    for scheme, own, color, _ in _by(rows):
        for bits, part in groups(own, "bits").items():
            numbers, style = column(part, "value"), {32: "o-", 64: "s--"}[bits]
            values = [row["noise"] or math.nan for row in part]
            limits.append(Curve(numbers, column(part, "ratio"), None, color, style))
            noise.append(Curve(numbers, values, f"{scheme}, {bits} bit", color, style))
    return [
        Panel("elements N [-]", "found over predicted limit [-]", limits, "semilogx", legend=False),
        Panel("elements N [-]", "noise at half the limit [-]", noise, legend=False),
    ]


PICTURES: dict[str, tuple[Callable[[Sequence[Row]], list[Panel]], float, float, int]] = {
    **{kind: (partial(_limits, one.axis), 7.0, 4.9, 3) for kind, one in MAPS.items() if one.axis},
    "curvature": (_curvature, 9.0, 4.0, 0),
    "spin": (_spin, 7.0, 5.2, 2),
    "slenderness": (_slenderness, 7.0, 4.9, 3),
    "violent": (_violent, 7.0, 4.9, 2),
    "precision": (_precision, 9.0, 4.0, 3),
}
"""kind -> panels of its rows; width, height [inch], columns of the legend."""


def _long(rows: Sequence[Row], path: Path) -> Path:
    """How long each run lasted, and how well it kept its energy."""
    with new_figure(path, 10.0, 1.6 + 0.28 * len(rows)) as figure:
        seconds, energy = figure.subplots(1, 2, sharey=True)
        names = ["{label}, {scene}, {value:.0e} steps".format_map(row) for row in rows]
        colors = [COLORS[0] if row["survives"] else COLORS[1] for row in rows]
        seconds.barh(names, column(rows, "seconds"), color=colors, log=True)
        energy.barh(names, [max(row["energyMax"], 1e-16) for row in rows], color=colors, log=True)
        seconds.invert_yaxis()
        energy.axvline(1e-3, color=REFERENCE_COLOR, linestyle=":")
        label_axes(seconds, "time that the run lasted [s]", "", "orange: diverged")
        label_axes(energy, "change of the energy over the swing [-]", "")
    return path
