"""One step of an inextensible chain against one evaluation of native elements.

Question
    Is one full step (bending force, constraints, update) of an inextensible chain cheaper than one
    native ComputeODE2RHS of as many ANCF cable elements, of which any native step needs at least one?

What would refute it
    A ratio above 0.5 (2D, ANCFCable2D) or 0.6 (3D, ANCFCable) at N = 5, 20 or 50.

Protocol
    The pendulums of Tables 1 and 2. Steps: a compiled call of many steps (ExplicitStepper.Step) that
    always begins at the start of the motion, at half of the stability limit. Native: C++ calls in a
    Python loop, less the empty loop. All tasks of one chain are sampled round robin, CPU time,
    medians; ratios within one run. RATTLE corrects positions as often as its tolerance of 1e-10 asks for,
    which takes more solves at the larger steps of coarse chains.

What is left out
    Native elements with quadratures other than the default and Lobatto. Links, damping, natural curvature:
    `scene_cost`, `watch_cost`. What the parts of a step take: a profiler says it.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import exudyn

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.conventional.model import Quadrature
from reference_models.conventional.model import build as build_native
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import load_scene

from .harness import UNDECIDED, Order, Results, Row, Study, at_most, column, groups, judged, largest, tables
from .harness.plot import Panel, chart, curves_of
from .harness.timing import Task, medians, seconds_per_time, steps_task

BARS = {2: 0.5, 3: 0.6}
SCENES = {2: "planar_pendulum", 3: "spatial_pendulum"}
INTEGRATORS = ("Zhai", "RATTLE")
MEASURES = ("secondDerivative", "product")
QUADRATURES: tuple[Quadrature, ...] = ("full", "lobatto")
EMPTY = "empty loop"
MICRO = 1e6


def measure(order: Order) -> list[Row]:
    """Ratios."""
    numbers, measures = ((5, 20), MEASURES[:1]) if order.quick else ((5, 20, 50), MEASURES)
    timing = (3, 4e-3) if order.quick else (15, 2e-2)  # rounds, seconds of a sample
    chains = [(dim, elements) for dim in SCENES for elements in numbers]
    return [row for chain in chains for row in _rows_of_chain(*chain, timing, measures)]


def _rows_of_chain(
    dim: int, elements: int, timing: tuple[int, float], measures: Sequence[str]
) -> Iterator[Row]:
    """One dimension and number of elements, from one round robin."""
    tasks = native_tasks(dim, elements)
    for name in measures:
        for integrator in INTEGRATORS:
            tasks[f"{integrator} {name}"] = steps_task(half_limit(dim, elements, integrator, name))
    time = medians(seconds_per_time(tasks, *timing, f"{dim}D, N = {elements}"))
    full, lobatto = (time[quadrature] - time[EMPTY] for quadrature in QUADRATURES)
    for name in measures:
        for integrator in INTEGRATORS:
            step = time[f"{integrator} {name}"]
            yield {
                "kind": "ratio",
                "label": f"{dim}D, {integrator}, one step",
                "dimension": dim,
                "elements": elements,
                "integrator": integrator,
                "curvatureMeasure": name,
                "microseconds": MICRO * step,
                "nativeMicroseconds": MICRO * full,
                "ratio": step / full,
                "ratioLobatto": step / lobatto,
                "bar": BARS[dim],
            }


def native_tasks(dim: int, elements: int) -> dict[str, Task]:
    """Quadrature -> C++ calls of ComputeODE2RHS in a tight loop; and that loop, empty."""

    def task(times: int, model: Model, solver: Any) -> None:
        mbs, compute = model.mbs, solver.ComputeODE2RHS
        for _ in range(times):
            compute(mbs)

    def empty(times: int) -> None:
        for _ in range(times):
            pass

    tasks: dict[str, Task] = {EMPTY: empty}
    for quadrature in QUADRATURES:
        model = build_native(load_scene(SCENES[dim]), elements, quadrature)
        solver = exudyn.MainSolverImplicitSecondOrder()
        with silence():
            solver.InitializeSolver(model.mbs, quiet_settings(1.0, 1000))
        tasks[quadrature] = partial(task, model=model, solver=solver)
    return tasks


def half_limit(dim: int, elements: int, integrator: str, name: str) -> ExplicitStepper:
    """A pendulum that takes steps of half of the stability limit.   name: of the curvature measure."""
    model = build(load_scene(SCENES[dim]), elements, name)
    settings = ExplicitSettings(integrator, massScaling=0.0)
    limit = ExplicitStepper(model.mbs, settings).bounds.stability_limit
    return ExplicitStepper(model.mbs, settings, stepSize=0.5 * limit)


def conclude(results: Results) -> list[str]:
    """Whether the bars are kept."""
    return [_bar(dim, results) for dim in BARS]


def _bar(dim: int, results: Results) -> str:
    """The dearest step against the bar; which rows are within it, which are not, which may be."""
    rows = [row for row in results.of_kind("ratio") if row["dimension"] == dim]
    worst, found = largest(rows, "ratio"), {True: [], False: [], None: []}
    for row in rows:
        name = "{integrator}, {curvatureMeasure}, N = {elements}: {ratio:.2f}".format_map(row)
        found[at_most(row["ratio"], row["bar"], results.noise)].append(name)
    words = ((False, "missed"), (None, UNDECIDED))
    others = ", ".join(f"{what}: {'; '.join(found[kind])}" for kind, what in words if found[kind])
    return (
        "{dimension}D: one full step costs at most {ratio:.2f} of a native ComputeODE2RHS of as many "
        "elements ({integrator}, {curvatureMeasure}, N = {elements}); the bar of {bar} is ".format_map(worst)
        + f"{judged(worst['ratio'], worst['bar'], results.noise)}; kept by {len(found[True])} of {len(rows)} "
        f"rows{f' ({others})' if others else ''}. "
        f"With the Lobatto quadrature: at most {max(column(rows, 'ratioLobatto')):.2f}."
    )


def draw(results: Results, directory: Path) -> list[Path]:
    """Ratios over the elements, below the bars."""
    rows = [row for row in results.of_kind("ratio") if row["curvatureMeasure"] == MEASURES[0]]
    panels = []
    for dim, own in groups(rows, "dimension").items():
        curves = curves_of(groups(own, "integrator"), "elements", "ratio")
        look = {"title": f"{dim}D", "horizontal": (0.0, BARS[dim]), "ticks": column(own, "elements")}
        labels = "elements N [-]", "time over native ComputeODE2RHS [-]"
        panels.append(Panel(*labels, curves, "semilogx", **look))
    return [chart(directory / "kernel_ratios.png", *panels, width=10.0)]


TABLES = tables(
    """
    ratio: Microseconds, and ratios to one native ComputeODE2RHS:
        what: label | N: elements | curvature: curvatureMeasure | time [us]: microseconds |
        native [us]: nativeMicroseconds | ratio | ratio, Lobatto: ratioLobatto | bar
    """
)

QUESTION = "What does one inextensible step cost against one native evaluation of as many elements?"
STUDY = Study("kernel", QUESTION, measure, conclude, TABLES, draw, minutes=1)
