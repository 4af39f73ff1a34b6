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

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from .harness import UNDECIDED, Order, Results, Row, Study, at_most, column, judged, largest, tables
from .harness import kernel_tasks as of
from .harness.operations import count_operations
from .harness.plot import COLORS, label_axes, new_figure
from .harness.timing import medians, seconds_per_time

BARS = {2: 0.5, 3: 0.6}
INTEGRATORS = ("Zhai", "RATTLE")
MEASURES = ("secondDerivative", "product")
MICRO = 1e6
RATES = "rates alone"
PARTS = ("assembly", "factorisation", "substitution", "update")


def measure(order: Order) -> list[Row]:
    """Ratios, shares, operations and rates."""
    numbers, measures = ((5, 20), MEASURES[:1]) if order.quick else ((5, 20, 50), MEASURES)
    timing = (3, 4e-3) if order.quick else (15, 2e-2)  # rounds, seconds of a sample
    chains = [(dim, elements) for dim in of.SCENES for elements in numbers]
    rows = [row for chain in chains for row in _rows_of_chain(*chain, timing, measures)]
    return rows + list(_floors([row for row in rows if row["kind"] == "share"], timing))


def _rows_of_chain(
    dim: int, elements: int, timing: tuple[int, float], measures: Sequence[str]
) -> Iterator[Row]:
    """Ratios and shares of one dimension and number of elements, from one round robin."""
    tasks, steps = of.native_tasks(dim, elements), {}
    tasks |= of.part_tasks(*of.moving_state(dim, elements, MEASURES[0]))
    for name in measures:
        tasks[f"{RATES} {name}"] = of.rates_task(*of.moving_state(dim, elements, name))
        for integrator in INTEGRATORS:
            tasks[f"{integrator} {name}"], steps[integrator] = of.steps_task(dim, elements, integrator, name)
    time = medians(seconds_per_time(tasks, *timing, f"{dim}D, N = {elements}"))
    full, lobatto = (time[quadrature] - time[of.EMPTY] for quadrature in of.QUADRATURES)
    for name in measures:
        for what in (*INTEGRATORS, RATES):
            yield {
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
    for integrator, h in steps.items():
        step = time[f"{integrator} {MEASURES[0]}"]
        shares = {name: time[name] / step for name in PARTS[:-1]}
        yield {
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


def _floors(shares: Sequence[Row], timing: tuple[int, float]) -> Iterator[Row]:
    """Operations of a step in the middle of the motion, over what the processor can do."""
    time = medians(seconds_per_time(of.PROCESSOR_TASKS, *timing, "multiply-adds"))
    rates = {name: of.MULTIPLY_ADDS[name] / seconds for name, seconds in time.items()}
    for name, rate in rates.items():
        yield {"kind": "machine", "label": name, "perNanosecond": 1e-9 * rate}
    asked = []
    for row in shares:
        _, _, q, v = of.moving_state(row["dimension"], row["elements"], MEASURES[0], 1.0)
        known = {"scene": of.SCENES[row["dimension"]], "q": q.tolist(), "v": v.tolist()}
        asked.append(known | {"h": row["stepSize"]} | {key: row[key] for key in ("integrator", "elements")})
    for row, found in zip(shares, count_operations(asked), strict=True):
        least = max(found["add"], found["multiply"]) + found["divide"] + found["root"]
        scalar, vector = (MICRO * least / rates[name] for name in of.PROCESSOR_TASKS)
        yield {
            "kind": "floor",
            "label": row["label"],
            "elements": row["elements"],
            **found,
            "perElement": sum(found.values()) / row["elements"],
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
    """The dearest step against the bar; which rows are within it, which are not, which may be."""
    rows = [r for r in results.of_kind("ratio") if r["dimension"] == dim and r["bar"] is not None]
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
    """Ratios as bars against the limits, and the shares of a step."""
    path = directory / "kernel_ratios.png"
    rows = [r for r in results.of_kind("ratio") if r["curvatureMeasure"] == MEASURES[0]]
    with new_figure(path, 11.0, 4.6) as figure:
        for axes, dim in zip(figure.subplots(1, 2, sharey=True), of.SCENES, strict=True):
            of_dim = [row for row in rows if row["dimension"] == dim]
            numbers = sorted(set(column(of_dim, "elements")))
            for place, what in enumerate((*INTEGRATORS, RATES)):
                ratios = column([row for row in of_dim if row["integrator"] == what], "ratio")
                axes.bar(np.arange(len(numbers)) + 0.27 * (place - 1), ratios, 0.25, label=what)
            axes.set_axisbelow(True)
            axes.axhline(BARS[dim], color=COLORS[-1], linestyle="--", label=f"bar: {BARS[dim]}")
            axes.set_xticks(range(len(numbers)), [str(number) for number in numbers])
            unit = "time over native ComputeODE2RHS [-]" if dim == 2 else ""
            label_axes(axes, "elements N [-]", unit, f"{dim}D")
            axes.margins(y=0.35)  # room for the legend
            axes.legend(loc="upper right")
    shares = results.of_kind("share")
    labels = ["{label}, N = {elements}".format_map(row) for row in shares]
    with new_figure(directory / "kernel_shares.png", 9.0, 0.8 + 0.35 * len(shares)) as figure:
        axes, start = figure.subplots(), np.zeros(len(shares))
        for part in PARTS:
            axes.barh(labels, column(shares, part), left=start, label=part)
            start += column(shares, part)
        axes.set_axisbelow(True)
        axes.invert_yaxis()
        label_axes(axes, "share of one step [-]", "")
        figure.legend(loc="outside upper left", ncols=4)
    return [path, directory / "kernel_shares.png"]


TABLES = tables(
    """
    ratio: Microseconds, and ratios to one native ComputeODE2RHS:
        what: label | N: elements | curvature: curvatureMeasure | time [us]: microseconds |
        native [us]: nativeMicroseconds | ratio | ratio, Lobatto: ratioLobatto | bar
    share: Shares of one step (parts timed alone; the update is what is left):
        step: label | N: elements | h [s]: stepSize | time [us]: microseconds | assembly | factorisation |
        substitution | update
    machine: Multiply-adds of one core:
        kind: label | [1/ns]: perNanosecond
    floor: Operations of one step, and the time that they take at least:
        step: label | N: elements | additions: add | multiplications: multiply | divisions: divide |
        roots: root | all, an element: perElement | time [us]: microseconds |
        floor, one by one [us]: scalarFloor | floor, vectors [us]: vectorFloor
    """
)

QUESTION = "What does one inextensible step cost against one native evaluation of as many elements?"
STUDY = Study("kernel", QUESTION, measure, conclude, TABLES, draw, minutes=1)
