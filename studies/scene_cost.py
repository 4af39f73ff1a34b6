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
    planar ones). Large joint systems: the Schur complement is dense, its factorisation grows with the
    cube of the number of joint equations.
"""

import statistics
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from exudyn_inext import ExplicitSettings, SolveExplicit
from reference_models.model import quiet_settings, silence

from .harness.benchmark import Benchmark, Figures, Table
from .harness.joined_scenes import Contents, joined_scene
from .harness.plot import COLORS, label_axes, new_figure
from .harness.study import Row
from .harness.timing import garbage_collection_off
from .harness.verdict import at_most, verdict

STEP = 5e-4
SETTINGS = ExplicitSettings("RATTLE", stepSize=STEP, massScaling=0.3)
SHORT, LONG = 50, 250  # steps
CHEAP = 40  # times as many steps, where steps are compiled
NUMBERS = (1, 2, 4, 8)
ELEMENTS = (10, 20, 50, 100, 200)
MICRO, MILLI = 1e6, 1e3

# series -> its scenes; the first and the largest are enough for a quick run
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


def measure(quick: bool) -> list[Row]:
    """One row for each scene."""
    cases = [
        (name, contents)
        for name, scenes in SERIES.items()
        for contents in ((scenes[0], scenes[1]) if quick else scenes)
    ]
    rounds = 1 if quick else 7
    samples: list[list[tuple[float, ...]]] = [[] for _ in cases]
    paths = [_run(contents, SHORT)[1] for _, contents in cases]
    for _ in tqdm(range(rounds), desc="scene_cost", unit="round"):
        with garbage_collection_off():
            for (_, contents), taken in zip(cases, samples, strict=True):
                taken.append(tuple(_run(contents, steps)[0] for steps in _lengths(contents)))
    return [
        _row(name, contents, path, taken)
        for (name, contents), path, taken in zip(cases, paths, samples, strict=True)
    ]


def _lengths(contents: Contents) -> tuple[int, int]:
    """Steps of the short and of the long run."""
    joined = contents.joints or contents.springs or contents.watched
    return (SHORT, LONG) if joined else (CHEAP * SHORT, CHEAP * LONG)


def _run(contents: Contents, steps: int) -> tuple[float, str]:
    """CPU seconds of a run of so many steps, and the path that it took."""
    mbs = joined_scene(contents)
    settings = quiet_settings(steps * STEP, steps if contents.watched else 1)
    start = time.process_time()
    with silence():
        report = SolveExplicit(mbs, settings, SETTINGS)
    return time.process_time() - start, report["path"]


def _row(name: str, contents: Contents, path: str, taken: Sequence[tuple[float, ...]]) -> Row:
    few, many = _lengths(contents)
    step = statistics.median((long - short) / (many - few) for short, long in taken)
    start = statistics.median(short for short, _ in taken) - few * step
    return {
        "kind": "cost",
        "label": name,
        "cables": contents.cables,
        "elements": contents.elements,
        "springs": contents.springs,
        "points": contents.points,
        "bodies": contents.bodies,
        "joints": contents.joints,
        "microseconds": MICRO * step,
        "startMilliseconds": MILLI * start,
        "path": path.split(": ", 1)[1].split(", as mbs contains")[0],
    }


def _series(figures: Figures) -> dict[str, list[Row]]:
    rows = figures.of_kind("cost")
    return {name: [r for r in rows if r["label"] == name] for name in dict.fromkeys(r["label"] for r in rows)}


def _size(row: Row) -> int:
    """What varies in the series of a row."""
    if row["label"].startswith("elements"):
        return int(row["elements"])
    return int(max(row["cables"], row["springs"], row["points"], row["bodies"]))


def conclude(figures: Figures) -> list[str]:
    """Overhead of the coupled path, and how costs grow."""
    series = _series(figures)
    alone = {row["elements"]: row["microseconds"] for row in series["elements, cable alone"]}
    sentences = [
        f"{name.removeprefix('elements, ').capitalize()}, N = {row['elements']}: "
        f"{row['microseconds']:.0f} us a step, "
        f"{row['microseconds'] / alone[row['elements']]:.1f} times the compiled path."
        for name in ("elements, watched", "elements, with a spring", "elements, with a body")
        for row in (series[name][0], series[name][-1])
    ]
    return sentences + [_growth(name, rows, figures.noise) for name, rows in series.items()]


def _growth(name: str, rows: Sequence[Row], noise: float) -> str:
    """Cost of one more: over the smaller and over the larger half of the range."""
    sizes, costs = [_size(row) for row in rows], [row["microseconds"] for row in rows]
    middle = len(rows) // 2
    total = (costs[-1] - costs[0]) / (sizes[-1] - sizes[0])
    if middle in (0, len(rows) - 1):
        return f"{name}: {total:.3g} us for one more."
    first = (costs[middle] - costs[0]) / (sizes[middle] - sizes[0])
    second = (costs[-1] - costs[middle]) / (sizes[-1] - sizes[middle])
    is_linear = at_most(second, 1.5 * first, noise)
    return (
        f"{name}: {first:.3g} us for one more from {sizes[0]} to {sizes[middle]}, {second:.3g} us from "
        f"{sizes[middle]} to {sizes[-1]} ({verdict(is_linear, 'linear', 'NOT linear')})."
    )


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Cost of a step over the size of the scene."""
    path = directory / "scene_cost_step.png"
    with new_figure(path, 10.0, 4.6) as figure:
        by_elements, by_number = figure.subplots(1, 2)
        drawn: dict[Any, int] = {by_elements: 0, by_number: 0}
        for name, rows in _series(figures).items():
            axes = by_elements if name.startswith("elements") else by_number
            values = [row["microseconds"] for row in rows]
            label = name.removeprefix("elements, ")
            axes.loglog([_size(r) for r in rows], values, "o-", color=COLORS[drawn[axes]], label=label)
            drawn[axes] += 1
        label_axes(by_elements, "elements of a cable [-]", "CPU time of a step [us]")
        label_axes(by_number, "cables, springs, points or bodies [-]", "CPU time of a step [us]")
        by_elements.legend()
        by_number.legend()
    return [path]


STUDY = Benchmark(
    name="scene_cost",
    question="What does a step cost, by what the scene contains, and which path does it take?",
    measure=measure,
    tables=(
        Table(
            "cost",
            "CPU time of a step and of the start:",
            {
                "series": "label",
                "cables": "cables",
                "elements": "elements",
                "springs": "springs",
                "points": "points",
                "bodies": "bodies",
                "joints": "joints",
                "us a step": "microseconds",
                "start [ms]": "startMilliseconds",
                "path": "path",
            },
        ),
    ),
    conclusions=conclude,
    pictures=draw,
)
