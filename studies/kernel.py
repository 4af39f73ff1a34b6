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

Where the time goes
    The parts of one evaluation are repeated alone; what is left of a step is its "update": predictor, loads,
    right-hand sides; with RATTLE also the position constraints and the velocity projection. Operations of a
    step are counted by running the same kernels on numbers that count. The floor is the time in which
    the processor could do them as multiply-adds, each an addition and a multiplication, one by one
    or in vectors; divisions and roots are counted as one operation, which flatters the floor.

What is left out
    Native elements with quadratures other than the default and Lobatto. Links, damping, natural curvature.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from reference_models.conventional.model import Quadrature

from .harness.kernel_tasks import (
    MULTIPLY_ADDS,
    PROCESSOR_TASKS,
    SCENES,
    empty_task,
    moving_state,
    native_task,
    part_tasks,
    rates_task,
    steps_task,
)
from .harness.operations import count_operations
from .harness.plot import COLORS, label_axes, new_figure
from .harness.store import Row
from .harness.study import Order, Results, Study
from .harness.table import Table, column, largest
from .harness.timing import Task, medians, seconds_per_time
from .harness.verdict import UNDECIDED, at_most, judged

BARS = {2: 0.5, 3: 0.6}
INTEGRATORS = ("Zhai", "RATTLE")
MEASURES = ("secondDerivative", "product")
QUADRATURES: tuple[Quadrature, ...] = ("full", "lobatto")
MICRO = 1e6
RATES = "rates alone"
PARTS = ("assembly", "factorisation", "substitution", "update")


def measure(order: Order) -> list[Row]:
    """Ratios, shares, operations and rates."""
    numbers = (5, 20) if order.quick else (5, 20, 50)
    timing = (3, 4e-3) if order.quick else (15, 2e-2)  # rounds, seconds of a sample
    measures = MEASURES[:1] if order.quick else MEASURES
    chains = [(dim, elements) for dim in SCENES for elements in numbers]
    rows = [row for chain in chains for row in _measure_chain(*chain, timing, measures)]
    return rows + _floors([row for row in rows if row["kind"] == "share"], timing)


def _measure_chain(dim: int, elements: int, timing: tuple[int, float], measures: Sequence[str]) -> list[Row]:
    """All rows of one dimension and number of elements, from one round robin."""
    parts, steps = part_tasks(*moving_state(dim, elements, MEASURES[0])), {}
    tasks: dict[str, Task] = {f"native {kind}": native_task(dim, elements, kind) for kind in QUADRATURES}
    tasks |= {"empty loop": empty_task} | parts
    for name in measures:
        tasks[f"{RATES} {name}"] = rates_task(*moving_state(dim, elements, name))
        for integrator in INTEGRATORS:
            tasks[f"{integrator} {name}"], steps[integrator] = steps_task(dim, elements, integrator, name)
    time = medians(seconds_per_time(tasks, *timing, f"{dim}D, N = {elements}"))
    full, lobatto = (time[f"native {quadrature}"] - time["empty loop"] for quadrature in QUADRATURES)
    ratios = [
        {
            "kind": "ratio",
            "label": f"{dim}D, {what}" + ("" if what == RATES else ", one step"),
            "dimension": dim,
            "elements": elements,
            "integrator": what,
            "curvatureMeasure": name,
            "microseconds": MICRO * time[f"{what} {name}"],
            "nativeMicroseconds": MICRO * full,
            "ratio": time[f"{what} {name}"] / full,
            "ratioLobatto": time[f"{what} {name}"] / lobatto,
            "bar": None if what == RATES else BARS[dim],
        }
        for name in measures
        for what in (*INTEGRATORS, RATES)
    ]
    return ratios + [_share_row(dim, elements, name, time, steps[name]) for name in INTEGRATORS]


def _share_row(dim: int, elements: int, integrator: str, time: dict[str, float], h: float) -> Row:
    """Parts of a step; what is left is its update."""
    step = time[f"{integrator} {MEASURES[0]}"]
    shares = {name: time[name] / step for name in PARTS[:-1]}
    return {
        "kind": "share",
        "label": f"{dim}D, {integrator}",
        "dimension": dim,
        "elements": elements,
        "integrator": integrator,
        "microseconds": MICRO * step,
        **shares,
        "update": 1.0 - sum(shares.values()),
        "stepSize": h,
    }


def _floors(shares: Sequence[Row], timing: tuple[int, float]) -> list[Row]:
    """Operations of a step over what the processor can do."""
    time = medians(seconds_per_time(PROCESSOR_TASKS, *timing, "multiply-adds"))
    rates = {name: MULTIPLY_ADDS[name] / seconds for name, seconds in time.items()}
    counted = count_operations([_question(row) for row in shares])
    floors = [_floor_row(row, found, rates) for row, found in zip(shares, counted, strict=True)]
    return [
        {"kind": "machine", "label": name, "perNanosecond": 1e-9 * rate} for name, rate in rates.items()
    ] + floors


def _question(row: Row) -> dict[str, Any]:
    """For `count_operations`: the operations of a step in the middle of the motion."""
    _, _, q, v = moving_state(row["dimension"], row["elements"], MEASURES[0], 1.0)
    known = {"scene": SCENES[row["dimension"]], "h": row["stepSize"], "q": q.tolist(), "v": v.tolist()}
    return known | {key: row[key] for key in ("integrator", "elements")}


def _floor_row(row: Row, operations: dict[str, float], rates: dict[str, float]) -> Row:
    least = max(operations["add"], operations["multiply"]) + operations["divide"] + operations["root"]
    scalar, vector = (MICRO * least / rates[name] for name in PROCESSOR_TASKS)
    return {
        "kind": "floor",
        "label": row["label"],
        "elements": row["elements"],
        **operations,
        "perElement": sum(operations.values()) / row["elements"],
        "microseconds": row["microseconds"],
        "scalarFloor": scalar,
        "vectorFloor": vector,
        "aboveScalarFloor": row["microseconds"] / scalar,
    }


def conclude(results: Results) -> list[str]:
    """Whether the bars are kept, and where the time goes."""
    above = column(results.of_kind("floor"), "aboveScalarFloor")
    return [
        *(_bar(dim, results) for dim in BARS),
        f"A step takes {min(above):.1f} to {max(above):.1f} times as long as its multiply-adds one by one.",
    ]


def _bar(dim: int, results: Results) -> str:
    rows = [r for r in results.of_kind("ratio") if r["dimension"] == dim and r["bar"] is not None]
    worst = largest(rows, "ratio")
    return (
        "{dimension}D: one full step costs at most {ratio:.2f} of a native ComputeODE2RHS of as many "
        "elements ({integrator}, {curvatureMeasure}, N = {elements}); the bar of {bar} is ".format_map(worst)
        + f"{judged(worst['ratio'], worst['bar'], results.noise)}; kept by {_kept(rows, results.noise)}. "
        f"With the Lobatto quadrature: at most {max(column(rows, 'ratioLobatto')):.2f}."
    )


def _kept(rows: Sequence[Row], noise: float) -> str:
    """Which rows are within the bar, which are not, which may be."""
    found: dict[bool | None, list[str]] = {True: [], False: [], None: []}
    for row in rows:
        name = "{integrator}, {curvatureMeasure}, N = {elements}: {ratio:.2f}".format_map(row)
        found[at_most(row["ratio"], row["bar"], noise)].append(name)
    words = ((False, "missed"), (None, UNDECIDED))
    others = ", ".join(f"{what}: {'; '.join(found[kind])}" for kind, what in words if found[kind])
    return f"{len(found[True])} of {len(rows)} rows" + (f" ({others})" if others else "")


def draw(results: Results, directory: Path) -> list[Path]:
    """Ratios as bars against the limits, and the shares of a step."""
    path = directory / "kernel_ratios.png"
    rows = [r for r in results.of_kind("ratio") if r["curvatureMeasure"] == MEASURES[0]]
    unit = "time over native ComputeODE2RHS [-]"
    with new_figure(path, 11.0, 4.6) as figure:
        for axes, dim in zip(figure.subplots(1, 2, sharey=True), SCENES, strict=True):
            of_dim = [row for row in rows if row["dimension"] == dim]
            numbers = sorted(set(column(of_dim, "elements")))
            for place, what in enumerate((*INTEGRATORS, RATES)):
                ratios = column([row for row in of_dim if row["integrator"] == what], "ratio")
                axes.bar(np.arange(len(numbers)) + 0.27 * (place - 1), ratios, 0.25, label=what)
            axes.set_axisbelow(True)
            axes.axhline(BARS[dim], color=COLORS[-1], linestyle="--", label=f"bar: {BARS[dim]}")
            axes.set_xticks(range(len(numbers)), [str(number) for number in numbers])
            label_axes(axes, "elements N [-]", unit if dim == 2 else "", f"{dim}D")
            axes.margins(y=0.35)  # room for the legend
            axes.legend(loc="upper right")
    return [path, _draw_shares(results, directory / "kernel_shares.png")]


def _draw_shares(results: Results, path: Path) -> Path:
    rows = results.of_kind("share")
    labels = [f"{row['label']}, N = {row['elements']}" for row in rows]
    with new_figure(path, 9.0, 0.8 + 0.35 * len(rows)) as figure:
        axes = figure.subplots()
        start = np.zeros(len(rows))
        for part in PARTS:
            shares = np.array(column(rows, part))
            axes.barh(labels, shares, left=start, label=part)
            start += shares
        axes.set_axisbelow(True)
        axes.invert_yaxis()
        label_axes(axes, "share of one step [-]", "")
        figure.legend(loc="outside upper left", ncols=4)
    return path


TABLES = (
    Table(
        "ratio",
        "Microseconds, and ratios to one native ComputeODE2RHS:",
        "what: label | N: elements | curvature: curvatureMeasure | time [us]: microseconds | "
        "native [us]: nativeMicroseconds | ratio | ratio, Lobatto: ratioLobatto | bar",
    ),
    Table(
        "share",
        "Shares of one step (parts timed alone; the update is what is left):",
        "step: label | N: elements | h [s]: stepSize | time [us]: microseconds | assembly | "
        "factorisation | substitution | update",
    ),
    Table("machine", "Multiply-adds of one core:", "kind: label | [1/ns]: perNanosecond"),
    Table(
        "floor",
        "Operations of one step, and the time that they take at least:",
        "step: label | N: elements | additions: add | multiplications: multiply | "
        "divisions: divide | roots: root | all, an element: perElement | time [us]: microseconds | "
        "floor, one by one [us]: scalarFloor | floor, vectors [us]: vectorFloor",
    ),
)

STUDY = Study(
    name="kernel",
    question="What does one inextensible step cost against one native evaluation of as many elements?",
    measure=measure,
    tables=TABLES,
    conclusions=conclude,
    pictures=draw,
)
