"""Pictures of benchmarks."""

from pathlib import Path

import numpy as np

from studies.harness import Results, groups
from studies.harness.bars import CONTROL
from studies.harness.plot import COLORS, REFERENCE_COLOR, Curve, Panel, chart, curves_of

from . import realtime, scene_cost, soak


def cost_of_elements(results: Results, directory: Path) -> list[Path]:
    """Cost per element over N."""
    styles = {"Zhai": "s--", "RATTLE": "o-"}
    curves = curves_of(groups(results.of_kind("cost"), "label"), "elements", "microseconds", styles)
    cost = "CPU time per element and step [us]"
    panel = Panel("elements N [-]", cost, curves, "semilogx", legend=False, horizontal=(0.0,))
    return [chart(directory / "scaling_cost.png", panel, columns=3)]


def late_steps(results: Results, directory: Path) -> list[Path]:
    """Share of steps that take longer than a time."""
    colors = dict(zip((0, *realtime.NUMBERS), (COLORS[-1], *COLORS), strict=False))
    styles = {("step", True): "-", ("step", False): "--", ("cycle", True): ":", ("nothing", False): "-"}
    curves = []
    for row in results.of_kind("step"):
        shares, times = np.transpose(row["quantiles"])
        style = styles[row["what"], row["garbageCollection"]]
        curves.append(Curve(times, shares, row["label"], colors[row["elements"]], style))
    labels = "wall time t of one call [us]", "share of calls that take longer than t [-]"
    title = f"dotted: step size {1e3 * realtime.STEP:g} ms"
    panel = Panel(*labels, curves, title=title, legend=False, vertical=(realtime.MICRO * realtime.STEP,))
    return [chart(directory / "realtime_steps.png", panel, width=9.0, height=6.4, columns=2)]


def cost_of_scenes(results: Results, directory: Path) -> list[Path]:
    """Cost of a step over the size of the scene."""
    rows = [row | {"size": scene_cost.size_of(row)} for row in results.of_kind("cost")]
    series = groups(rows, "label").items()
    by_elements = {name.split(", ")[1]: own for name, own in series if name.startswith("elements")}
    by_number = {name: own for name, own in series if not name.startswith("elements")}
    sizes = {"elements of a cable [-]": by_elements, "cables, springs, points or bodies [-]": by_number}
    panels = [
        Panel(what, "CPU time of a step [us]", curves_of(own, "size", "microseconds"))
        for what, own in sizes.items()
    ]
    return [chart(directory / "scene_cost_step.png", *panels, width=10.0)]


def energy_and_memory(results: Results, directory: Path) -> list[Path]:
    """Energy over time, and memory over scenes."""
    energies = [
        Curve(np.array(row["times"]) / 3600.0, row["energies"], row["label"], color, "-")
        for row, color in zip(results.of_kind("run"), COLORS, strict=False)
    ]
    sizes = []
    for number, row in enumerate(results.of_kind("memory")):
        relative = np.array(row["megabytes"]) / row["firstMegabytes"]
        keeps = row["label"].startswith(CONTROL)
        look = (REFERENCE_COLOR, "--") if keeps else (COLORS[number % len(COLORS)], "-")
        sizes.append(Curve(np.arange(len(relative)), relative, row["label"], *look))
    axes = "scenes built, run, dropped [-]", "resident memory over its start [-]"
    panels = (
        Panel("time of motion [h]", "change of energy over the swing [-]", energies, "plot"),
        Panel(*axes, sizes, "plot", horizontal=(1.0 + soak.GROWTH,)),
    )
    return [chart(directory / "soak.png", *panels, width=10.0)]
