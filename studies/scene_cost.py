"""What a step costs, by what the scene contains.

Question
    Which path does the solver take for which scene, what does its step cost, and does the cost grow in
    proportion to what there is?

What would refute it
    A cost that grows faster than linearly with the elements of a cable, or with the number of cables,
    bodies or joints, over the range that is measured.

Protocol
    Planar cables of 1.8 m, RATTLE, mass scaling 0.3, h = 5e-4 s, so that the number of elements does not
    change the motion. Each scene is run for a short and for a long time by SolveExplicit, all scenes in
    turn; the difference of both CPU times over that of the steps is the cost of a step, what is left is
    the start (reading, step bounds, first evaluation). Medians over the rounds. "Watched" scenes have a
    user function that is called at each step, so that each step is a step of Exudyn's loop.

What is left out
    Contact, user functions that cost time of their own, and spatial cables (`kernel`: about 1.6 times the
    planar ones). Nets (`coupled`). Items that Exudyn evaluates, as contact, or springs
    with user functions.
"""

import statistics
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from exudyn_inext import ExplicitSettings, SolveExplicit
from reference_models.model import quiet_settings, silence

from .harness import Order, Results, Row, Study, Table, column, groups, judged
from .harness.joined_scenes import Contents, joined_scene
from .harness.plot import Panel, chart, curves_of
from .harness.timing import in_turn

STEP = 5e-4
SETTINGS = ExplicitSettings("RATTLE", stepSize=STEP, massScaling=0.3)
SHORT, LONG = 50, 250  # steps
SOME, MANY = 3, 40  # times as many steps, where steps are compiled: among others, and of a cable alone
NUMBERS = (1, 2, 4, 8)
ELEMENTS = (10, 20, 50, 100, 200)
MICRO, MILLI = 1e6, 1e3

# series -> its scenes; the first two are enough for a quick run
SERIES = {
    "elements, cable alone": [Contents(elements=n) for n in ELEMENTS],
    "elements, watched": [Contents(elements=n, watched=True) for n in ELEMENTS],
    "elements, with a spring": [Contents(elements=n, springs=1) for n in ELEMENTS],
    "elements, with a body": [Contents(elements=n, bodies=1) for n in ELEMENTS],
    "cables alone": [Contents(cables=n) for n in NUMBERS],
    "joined cables": [Contents(cables=n, links=n - 1) for n in (2, 4, 8, 16)],
    "springs": [Contents(springs=n) for n in NUMBERS],
    "mass points on joints": [Contents(points=n) for n in NUMBERS],
    "bodies on joints": [Contents(bodies=n) for n in NUMBERS],
}


def measure(order: Order) -> list[Row]:
    """One row for each scene."""
    cases = [
        (name, contents)
        for name, scenes in SERIES.items()
        for contents in scenes[: 2 if order.quick else None]
    ]
    runs = {
        f"{name}, {contents}, {steps}": partial(_prepare, contents, steps)
        for name, contents in cases
        for steps in _lengths(contents)
    }
    found = list(in_turn(runs, 1 if order.quick else 7, "scene_cost").values())
    return [
        _row(*case, few.found, list(zip(few.cpu_seconds, many.cpu_seconds, strict=True)))
        for case, few, many in zip(cases, found[::2], found[1::2], strict=True)
    ]


def _lengths(contents: Contents) -> tuple[int, int]:
    """Steps of the short and of the long run."""
    if contents.watched:
        return SHORT, LONG
    often = SOME if contents.joints or contents.springs else MANY
    return often * SHORT, often * LONG


def _prepare(contents: Contents, steps: int) -> Callable[[], str]:
    """A run of so many steps; it returns the path that it took."""
    mbs = joined_scene(contents)
    settings = quiet_settings(steps * STEP, steps if contents.watched else 1)

    def run() -> str:
        with silence():
            return str(SolveExplicit(mbs, settings, SETTINGS)["path"])

    return run


def _row(name: str, contents: Contents, path: str, taken: Sequence[tuple[float, ...]]) -> Row:
    """taken: CPU seconds of the short and of the long run, round by round."""
    few, many = _lengths(contents)
    step = statistics.median((long - short) / (many - few) for short, long in taken)
    start = statistics.median(short for short, _ in taken) - few * step
    parts = ("cables", "elements", "springs", "points", "bodies", "joints")
    return {
        "kind": "cost",
        "label": name,
        **{part: getattr(contents, part) for part in parts},
        "microseconds": MICRO * step,
        "startMilliseconds": MILLI * start,
        "path": path.split(": ", 1)[1].split(", as mbs contains")[0],
    }


def size_of(row: Row) -> int:
    """What varies in the series of a row."""
    if row["label"].startswith("elements"):
        return int(row["elements"])
    return int(max(row["cables"], row["springs"], row["points"], row["bodies"]))


def conclude(results: Results) -> list[str]:
    """Overhead of the coupled path, and how costs grow."""
    series = groups(results.of_kind("cost"), "label")
    alone = {row["elements"]: row["microseconds"] for row in series["elements, cable alone"]}
    sentences = [
        f"{name.removeprefix('elements, ').capitalize()}, N = {row['elements']}: "
        f"{row['microseconds']:.0f} us a step, "
        f"{row['microseconds'] / alone[row['elements']]:.1f} times the compiled path."
        for name in ("elements, watched", "elements, with a spring", "elements, with a body")
        for row in (series[name][0], series[name][-1])
    ]
    return sentences + [_growth(name, rows, results.noise) for name, rows in series.items()]


def _growth(name: str, rows: Sequence[Row], noise: float) -> str:
    """Cost of one more: over the smaller and over the larger half of the range."""
    sizes, costs = [size_of(row) for row in rows], column(rows, "microseconds")
    middle = len(rows) // 2

    def one_more(start: int, end: int) -> float:
        return float((costs[end] - costs[start]) / (sizes[end] - sizes[start]))

    if middle in (0, len(rows) - 1):
        return f"{name}: {one_more(0, -1):.3g} us for one more."
    first, second = one_more(0, middle), one_more(middle, -1)
    return (
        f"{name}: {first:.3g} us for one more from {sizes[0]} to {sizes[middle]}, {second:.3g} us from "
        f"{sizes[middle]} to {sizes[-1]} ({judged(second, 1.5 * first, noise, 'linear', 'NOT linear')})."
    )


def draw(results: Results, directory: Path) -> list[Path]:
    """Cost of a step over the size of the scene."""
    series = groups([row | {"size": size_of(row)} for row in results.of_kind("cost")], "label").items()
    by_elements = {name.split(", ")[1]: rows for name, rows in series if name.startswith("elements")}
    by_number = {name: rows for name, rows in series if not name.startswith("elements")}
    panels = [
        Panel(what, "CPU time of a step [us]", curves_of(own, "size", "microseconds"))
        for what, own in (
            ("elements of a cable [-]", by_elements),
            ("cables, springs, points or bodies [-]", by_number),
        )
    ]
    return [chart(directory / "scene_cost_step.png", *panels, width=10.0)]


TABLE = Table(
    "cost",
    "CPU time of a step and of the start:",
    "series: label | cables | elements | springs | points | bodies | joints | "
    "us a step: microseconds | start [ms]: startMilliseconds | path",
)

QUESTION = "What does a step cost, by what the scene contains, and which path does it take?"
STUDY = Study("scene_cost", QUESTION, measure, conclude, [TABLE], draw, minutes=1)
