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

from .harness.benchmark import Figures, Table
from .harness.plot import COLORS, label_axes, new_figure
from .harness.study import Row
from .harness.sweep.study import SweepStudy
from .harness.table import number
from .minimal.changes import change_cases, run_change
from .minimal.dense_system import dense_cases, run_dense

HARMLESS = 1.1  # error over that of the base


def make_cases(quick: bool) -> Sequence[Row]:
    """Dense variants and timed changes."""
    return [*dense_cases(quick), *change_cases(quick)]


def run_case(case: Row) -> Row:
    """One of them."""
    return run_dense(case) if case["kind"] == "dense" else run_change(case)


def is_harmless(row: Row) -> bool:
    """Whether the error stays that of the base, or what the reference cannot tell from it."""
    if row.get("error") is None or row.get("baseError") is None:
        return False
    bound = max(HARMLESS * row["baseError"], row["baseError"] + row["uncertainty"])
    return bool(row["error"] <= bound)


def conclude(figures: Figures) -> list[str]:
    """For each change: where it may be made, and what it saves or costs."""
    rows = figures.of_kind("change")
    sentences = [_sentence(label, rows) for label in dict.fromkeys(row["label"] for row in rows)]
    return sentences + _dense_sentences(figures.of_kind("dense"))


def _sentence(label: str, rows: Sequence[Row]) -> str:
    own = [row for row in rows if row["label"] == label]
    where = [row["scene"] for row in own if is_harmless(row)]
    elsewhere = [f"{row['scene']} ({_error(row)})" for row in own if not is_harmless(row)]
    costs = [row["costRatio"] for row in own if row.get("costRatio") is not None]
    cost = f"{min(costs):.2f} to {max(costs):.2f} times the CPU time" if costs else "no CPU time"
    return (
        f"{label}: harmless on {', '.join(where) or 'no scene'}"
        + (f"; not on {', '.join(elsewhere)}" if elsewhere else "")
        + f"; {cost}."
    )


def _error(row: Row) -> str:
    if row.get("errorRatio") is None:
        return str(row.get("outcome", row["status"]))[:60]
    return f"{number(row['errorRatio'])} times the error"


def _dense_sentences(rows: Sequence[Row]) -> list[str]:
    sentences = []
    for count in dict.fromkeys(row["elements"] for row in rows):
        own = {row["label"]: row for row in rows if row["elements"] == count}
        base = own.pop("as in the package", None)
        for label, row in own.items():
            if row.get("error") is None or base is None or not base.get("error"):
                sentences.append(f"Pendulum, N = {count}, {label}: {row.get('outcome', row['status'])}.")
                continue
            sentences.append(
                f"Pendulum, N = {count}, {label}: {row['error'] / base['error']:.2f} times the error; "
                f"slopes at nodes stretch by up to {number(row['stretch'], 2)}."
            )
    return sentences


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Error and cost over those of the base."""
    rows = [row for row in figures.of_kind("change") if row.get("errorRatio") and row.get("costRatio")]
    if not rows:
        return []
    path = directory / "minimal_model.png"
    labels = list(dict.fromkeys(row["label"] for row in rows))
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    with new_figure(path, 10.0, 1.5 + 0.3 * len(labels)) as figure:
        error, cost = figure.subplots(1, 2, sharey=True)
        for scene, color, marker in zip(scenes, COLORS, "os^D", strict=False):
            own = [row for row in rows if row["scene"] == scene]
            places = [labels.index(row["label"]) for row in own]
            style = {"color": color, "marker": marker, "linestyle": ""}
            error.semilogx([row["errorRatio"] for row in own], places, label=scene, **style)
            cost.semilogx([row["costRatio"] for row in own], places, **style)
        for axes in (error, cost):
            axes.axvline(1.0, color="black", linewidth=0.8)
        error.set_yticks(range(len(labels)), labels)
        error.invert_yaxis()
        label_axes(error, "error over that of the base [-]", "")
        label_axes(cost, "CPU time over that of the base [-]", "")
        figure.legend(loc="outside upper left", ncols=4)
    return [path]


TABLES = (
    Table(
        "change",
        "One change at a time:",
        {
            "change": "label",
            "scene": "scene",
            "base error [m]": "baseError",
            "error [m]": "error",
            "error ratio": "errorRatio",
            "base h [s]": "baseStep",
            "h [s]": "stepSize",
            "base CPU [s]": "baseSeconds",
            "CPU [s]": "seconds",
            "CPU ratio": "costRatio",
            "outcome": "outcome",
            "status": "status",
        },
    ),
    Table(
        "dense",
        "Dense variants of the planar pendulum (RK4, no times):",
        {
            "variant": "label",
            "N": "elements",
            "error [m]": "error",
            "stretch of slopes [-]": "stretch",
            "outcome": "outcome",
            "status": "status",
        },
    ),
)

STUDY = SweepStudy(
    name="minimal_model",
    question="What may be left out of the model when, and what does that save?",
    cases=make_cases,
    run=run_case,
    tables=TABLES,
    conclusions=conclude,
    pictures=draw,
)
