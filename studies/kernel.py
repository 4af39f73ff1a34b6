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

from .harness.benchmark import Benchmark, Figures, Table
from .harness.interleaved import Task, medians, seconds_per_time
from .harness.kernel_parts import part_tasks, rates_task
from .harness.machine_rate import MULTIPLY_ADDS, TASKS
from .harness.operations import count_operations
from .harness.plot import COLORS, label_axes, new_figure
from .harness.step_tasks import SCENES, empty_task, moving_state, native_task, steps_task
from .harness.study import Row
from .harness.verdict import UNDECIDED, at_most, verdict

BARS = {2: 0.5, 3: 0.6}
INTEGRATORS = ("Zhai", "RATTLE")
MEASURES = ("secondDerivative", "product")
QUADRATURES: tuple[Quadrature, ...] = ("full", "lobatto")
MICRO = 1e6
RATES = "rates alone"


def measure(quick: bool) -> list[Row]:
    """Ratios, shares, operations and rates."""
    numbers = (5, 20) if quick else (5, 20, 50)
    repeats, seconds = (3, 4e-3) if quick else (15, 2e-2)
    rows: list[Row] = []
    for dim in SCENES:
        for elements in numbers:
            rows += _measure_chain(dim, elements, repeats, seconds, MEASURES[:1] if quick else MEASURES)
    return rows + _floors(rows, repeats, seconds)


def _measure_chain(
    dim: int, elements: int, repeats: int, seconds: float, measures: Sequence[str]
) -> list[Row]:
    """All rows of one dimension and number of elements, from one round robin."""
    parts, steps = part_tasks(*moving_state(dim, elements, MEASURES[0])), {}
    tasks: dict[str, Task] = {f"native {kind}": native_task(dim, elements, kind) for kind in QUADRATURES}
    tasks |= {"empty loop": empty_task} | parts
    for name in measures:
        tasks[f"{RATES} {name}"] = rates_task(*moving_state(dim, elements, name))
        for integrator in INTEGRATORS:
            tasks[f"{integrator} {name}"], steps[integrator] = steps_task(dim, elements, integrator, name)
    samples = seconds_per_time(tasks, repeats, seconds, f"{dim}D, N = {elements}")
    time = medians(samples)
    native = {quadrature: time[f"native {quadrature}"] - time["empty loop"] for quadrature in QUADRATURES}
    rows = [
        _ratio_row(dim, elements, what, name, time[f"{what} {name}"], native)
        for name in measures
        for what in (*INTEGRATORS, RATES)
    ]
    shares = [
        _share_row(
            dim, elements, integrator, time[f"{integrator} {MEASURES[0]}"], {p: time[p] for p in parts}
        )
        | {"stepSize": steps[integrator]}
        for integrator in INTEGRATORS
    ]
    return rows + shares


def _ratio_row(
    dim: int, elements: int, what: str, name: str, seconds: float, native: dict[Quadrature, float]
) -> Row:
    return {
        "kind": "ratio",
        "label": f"{dim}D, {what}" + ("" if what == RATES else ", one step"),
        "dimension": dim,
        "elements": elements,
        "integrator": what,
        "curvatureMeasure": name,
        "microseconds": MICRO * seconds,
        "nativeMicroseconds": MICRO * native["full"],
        "ratio": seconds / native["full"],
        "ratioLobatto": seconds / native["lobatto"],
        "bar": None if what == RATES else BARS[dim],
    }


def _share_row(dim: int, elements: int, integrator: str, step: float, parts: dict[str, float]) -> Row:
    shares = {name: seconds / step for name, seconds in parts.items()}
    return {
        "kind": "share",
        "label": f"{dim}D, {integrator}",
        "dimension": dim,
        "elements": elements,
        "integrator": integrator,
        "microseconds": MICRO * step,
        **shares,
        "update": 1.0 - sum(shares.values()),
    }


def _floors(rows: Sequence[Row], repeats: int, seconds: float) -> list[Row]:
    """Operations of a step over what the processor can do."""
    shares = [row for row in rows if row["kind"] == "share"]
    asked = [_question(row) for row in shares]
    time = medians(seconds_per_time(TASKS, repeats, seconds, "multiply-adds"))
    scalar, vector = (MULTIPLY_ADDS[name] / time[name] for name in TASKS)
    rates = [
        {"kind": "machine", "label": name, "perNanosecond": MULTIPLY_ADDS[name] / time[name] * 1e-9}
        for name in TASKS
    ]
    floors = [
        _floor_row(row, operations, scalar, vector)
        for row, operations in zip(shares, count_operations(asked), strict=True)
    ]
    return rates + floors


def _question(row: Row) -> dict[str, Any]:
    """For `count_operations`: the operations of a step in the middle of the motion."""
    _, _, q, v = moving_state(row["dimension"], row["elements"], MEASURES[0], 1.0)
    return {
        "scene": SCENES[row["dimension"]],
        "integrator": row["integrator"],
        "elements": row["elements"],
        "h": row["stepSize"],
        "q": q.tolist(),
        "v": v.tolist(),
    }


def _floor_row(row: Row, operations: dict[str, float], scalar: float, vector: float) -> Row:
    adds, multiplications = operations["add"], operations["multiply"]
    others = operations["divide"] + operations["root"]
    least = max(adds, multiplications) + others
    return {
        "kind": "floor",
        "label": row["label"],
        "elements": row["elements"],
        **operations,
        "perElement": sum(operations.values()) / row["elements"],
        "microseconds": row["microseconds"],
        "scalarFloor": MICRO * least / scalar,
        "vectorFloor": MICRO * least / vector,
        "aboveScalarFloor": row["microseconds"] / (MICRO * least / scalar),
    }


def conclude(figures: Figures) -> list[str]:
    """Whether the bars are kept, and where the time goes."""
    sentences = []
    for dim, bar in BARS.items():
        rows = [r for r in figures.of_kind("ratio") if r["dimension"] == dim and r["bar"] is not None]
        worst = max(rows, key=lambda row: float(row["ratio"]))
        is_kept, kept = at_most(worst["ratio"], bar, figures.noise), _kept(rows, figures.noise)
        sentences.append(
            f"{dim}D: one full step costs at most {worst['ratio']:.2f} of a native ComputeODE2RHS of as many "
            f"elements ({worst['integrator']}, {worst['curvatureMeasure']}, N = {worst['elements']}); the "
            f"bar of {bar} is {verdict(is_kept)}; kept by {kept}. With the Lobatto "
            f"quadrature: at most {max(row['ratioLobatto'] for row in rows):.2f}."
        )
    floors = figures.of_kind("floor")
    above = [row["aboveScalarFloor"] for row in floors]
    return [
        *sentences,
        f"A step takes {min(above):.1f} to {max(above):.1f} times as long as its multiply-adds one by one.",
    ]


def _kept(rows: Sequence[Row], noise: float) -> str:
    """Which rows are within the bar, which are not, which may be."""
    verdicts = [at_most(row["ratio"], row["bar"], noise) for row in rows]
    named = {
        is_kept: [
            f"{row['integrator']}, {row['curvatureMeasure']}, N = {row['elements']}: {row['ratio']:.2f}"
            for row, found in zip(rows, verdicts, strict=True)
            if found is is_kept
        ]
        for is_kept in (False, None)
    }
    others = [
        f"{what}: {'; '.join(named[is_kept])}"
        for is_kept, what in ((False, "missed"), (None, UNDECIDED))
        if named[is_kept]
    ]
    return f"{verdicts.count(True)} of {len(rows)} rows" + (f" ({', '.join(others)})" if others else "")


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Ratios as bars against the limits, and the shares of a step."""
    path = directory / "kernel_ratios.png"
    rows = [r for r in figures.of_kind("ratio") if r["curvatureMeasure"] == MEASURES[0]]
    unit = "time over native ComputeODE2RHS [-]"
    with new_figure(path, 11.0, 4.6) as figure:
        for axes, dim in zip(figure.subplots(1, 2, sharey=True), SCENES, strict=True):
            of_dim = [row for row in rows if row["dimension"] == dim]
            numbers = sorted({row["elements"] for row in of_dim})
            for place, what in enumerate((*INTEGRATORS, RATES)):
                ratios = [row["ratio"] for row in of_dim if row["integrator"] == what]
                axes.bar(np.arange(len(numbers)) + 0.27 * (place - 1), ratios, 0.25, label=what)
            axes.set_axisbelow(True)
            axes.axhline(BARS[dim], color=COLORS[-1], linestyle="--", label=f"bar: {BARS[dim]}")
            axes.set_xticks(range(len(numbers)), [str(number) for number in numbers])
            label_axes(axes, "elements N [-]", unit if dim == 2 else "", f"{dim}D")
            axes.margins(y=0.35)  # room for the legend
            axes.legend(loc="upper right")
    return [path, _draw_shares(figures, directory / "kernel_shares.png")]


def _draw_shares(figures: Figures, path: Path) -> Path:
    rows = figures.of_kind("share")
    labels = [f"{row['label']}, N = {row['elements']}" for row in rows]
    with new_figure(path, 9.0, 0.8 + 0.35 * len(rows)) as figure:
        axes = figure.subplots()
        start = np.zeros(len(rows))
        for part in ("assembly", "factorisation", "substitution", "update"):
            shares = np.array([row[part] for row in rows])
            axes.barh(labels, shares, left=start, label=part)
            start += shares
        axes.set_axisbelow(True)
        axes.invert_yaxis()
        label_axes(axes, "share of one step [-]", "")
        figure.legend(loc="outside upper left", ncols=4)
    return path


RATIO_COLUMNS = {
    "what": "label",
    "N": "elements",
    "curvature": "curvatureMeasure",
    "time [us]": "microseconds",
    "native [us]": "nativeMicroseconds",
    "ratio": "ratio",
    "ratio, Lobatto": "ratioLobatto",
    "bar": "bar",
}
SHARE_COLUMNS = {
    "step": "label",
    "N": "elements",
    "h [s]": "stepSize",
    "time [us]": "microseconds",
    "assembly": "assembly",
    "factorisation": "factorisation",
    "substitution": "substitution",
    "update": "update",
}
FLOOR_COLUMNS = {
    "step": "label",
    "N": "elements",
    "additions": "add",
    "multiplications": "multiply",
    "divisions": "divide",
    "roots": "root",
    "all, an element": "perElement",
    "time [us]": "microseconds",
    "floor, one by one [us]": "scalarFloor",
    "floor, vectors [us]": "vectorFloor",
}

STUDY = Benchmark(
    name="kernel",
    question="What does one inextensible step cost against one native evaluation of as many elements?",
    measure=measure,
    tables=(
        Table("ratio", "Microseconds, and ratios to one native ComputeODE2RHS:", RATIO_COLUMNS),
        Table("share", "Shares of one step (parts timed alone; the update is what is left):", SHARE_COLUMNS),
        Table("machine", "Multiply-adds of one core:", {"kind": "label", "[1/ns]": "perNanosecond"}),
        Table("floor", "Operations of one step, and the time that they take at least:", FLOOR_COLUMNS),
    ),
    conclusions=conclude,
    pictures=draw,
)
