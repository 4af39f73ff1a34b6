"""What a scene needs: one change of the model or the method at a time, its effect on error and cost.

Question
    Which parts of the formulation may be left out, where, and what does that save?

What would refute it
    A change that is said to be harmless and whose error exceeds the base's by more than a tenth and by more
    than the reference's uncertainty.

Protocol
    The base is Zhai with the projected rate, zeta = 100 1/s, |r_xx| as curvature, one length constraint an
    element, nodal constraints, consistent masses, the smallest dimension. Each variant differs in one
    thing and runs at 0.6 of its own stability limit, as the base does. Base and variant are timed in turn,
    five times after a warm-up, alone in one process; medians of CPU time are compared.
    Nodal constraints and lumped masses: the package has no such switches, since it eliminates the nodal
    constraints node by node. There a dense solve in plain Python with RK4 takes its place, for errors only.

Reference and tolerance
    Those of the scenes; the power line is compared with a refined solution, as in `table3`.

What is left out
    Combinations of changes.
"""

from collections.abc import Sequence
from pathlib import Path

from .harness import Results, Row, Study, Table, column, groups
from .harness.plot import COLORS, label_axes, new_figure
from .harness.sweep import Sweep
from .minimal.changes import change_cases, run_change, sentences_of, summary_of
from .minimal.dense_system import dense_cases, run_dense

COST_TICKS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)


def make_cases(quick: bool) -> Sequence[Row]:
    """Dense variants and timed changes."""
    return [*dense_cases(quick), *change_cases(quick)]


def run_case(case: Row) -> Row:
    """One of them."""
    return run_dense(case) if case["kind"] == "dense" else run_change(case)


def conclude(results: Results) -> list[str]:
    """What may be changed where, and what that saves."""
    return sentences_of(summary_of(results))


def draw(results: Results, directory: Path) -> list[Path]:
    """Error and cost over those of the base."""
    rows = [row for row in results.of_kind("change") if row.get("errorRatio") and row.get("costRatio")]
    if not rows:
        return []
    path = directory / "minimal_model.png"
    labels = list(groups(rows, "label"))
    with new_figure(path, 10.0, 1.5 + 0.3 * len(labels)) as figure:
        error, cost = figure.subplots(1, 2, sharey=True)
        for (scene, own), color, marker in zip(groups(rows, "scene").items(), COLORS, "os^D", strict=False):
            places = [labels.index(row["label"]) for row in own]
            style = {"color": color, "marker": marker, "linestyle": ""}
            error.semilogx(column(own, "errorRatio"), places, label=scene, **style)
            cost.semilogx(column(own, "costRatio"), places, **style)
        for axes in (error, cost):
            axes.axvline(1.0, color="black", linewidth=0.8)
        cost.minorticks_off()  # their labels would overlap
        cost.set_xticks(COST_TICKS, [f"{tick:g}" for tick in COST_TICKS])
        error.set_yticks(range(len(labels)), labels)
        error.invert_yaxis()
        label_axes(error, "error over that of the base [-]", "")
        label_axes(cost, "CPU time over that of the base [-]", "")
        figure.legend(loc="outside upper left", ncols=4)
    return [path]


TABLES = (
    Table(
        "summary",
        "What may be left out when (error within a tenth of the base's, or not to be told from it):",
        "change | verdict | harmless on: harmless | not on: elsewhere | CPU ratio: costRatio",
        summary_of,
    ),
    Table(
        "change",
        "One change at a time:",
        "change: label | scene | base error [m]: baseError | error [m]: error | "
        "error ratio: errorRatio | base h [s]: baseStep | h [s]: stepSize | "
        "base CPU [s]: baseSeconds | CPU [s]: seconds | CPU ratio: costRatio | outcome | status",
    ),
    Table(
        "dense",
        "Dense variants of the planar pendulum (RK4, no times):",
        "variant: label | N: elements | error [m]: error | stretch of slopes [-]: stretch | outcome | status",
    ),
)

QUESTION = "What may be left out of the model when, and what does that save?"
STUDY = Study("minimal_model", QUESTION, Sweep(make_cases, run_case), conclude, TABLES, draw)
