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
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

from exudyn_inext import ExplicitSettings, SolveExplicit
from reference_models.model import quiet_settings, silence
from studies.harness import Results, Row, column, groups
from studies.harness.joined_scenes import Contents, joined_scene
from studies.harness.timing import Prepare

STEP = 5e-4
SETTINGS = ExplicitSettings("RATTLE", stepSize=STEP, massScaling=0.3)
SHORT, LONG = 50, 250  # steps
SOME, MANY = 3, 40  # times as many steps, where steps are compiled: among others, and of a cable alone
NUMBERS = (1, 2, 4, 8)
ELEMENTS = (10, 20, 50, 100, 200)
PARTS = ("cables", "elements", "springs", "points", "bodies", "joints")
MICRO, MILLI = 1e6, 1e3

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
"""Series -> its scenes; the first two are enough for a quick run."""


def cases(quick: bool) -> list[Row]:
    """All scenes."""
    few = 2 if quick else None
    return [{"label": name, "contents": one} for name, scenes in SERIES.items() for one in scenes[:few]]


def lengths(contents: Contents) -> tuple[int, int]:
    """Steps of the short and of the long run."""
    if contents.watched:
        return SHORT, LONG
    often = SOME if contents.joints or contents.springs else MANY
    return often * SHORT, often * LONG


def runs(case: Row) -> dict[Any, Prepare]:
    """The short and the long one."""
    contents = case["contents"]
    return {
        (case["label"], contents, steps): partial(_prepare, contents, steps) for steps in lengths(contents)
    }


def _prepare(contents: Contents, steps: int) -> Callable[[], str]:
    """A run of so many steps; it returns the path that it took."""
    mbs = joined_scene(contents)
    settings = quiet_settings(steps * STEP, steps if contents.watched else 1)

    def run() -> str:
        with silence():
            return str(SolveExplicit(mbs, settings, SETTINGS)["path"])

    return run


def row(case: Row, found: Any) -> Row:
    """Cost of a step and of the start, from both runs, round by round."""
    contents = case["contents"]
    few, many = lengths(contents)
    shorter, longer = (found[case["label"], contents, steps] for steps in (few, many))
    pairs = zip(shorter.cpu_seconds, longer.cpu_seconds, strict=True)
    step = statistics.median((long - short) / (many - few) for short, long in pairs)
    return {
        "label": case["label"],
        **{part: getattr(contents, part) for part in PARTS},
        "microseconds": MICRO * step,
        "startMilliseconds": MILLI * (shorter.median - few * step),
        "path": shorter.found.split(": ", 1)[1].split(", as mbs contains")[0],
    }


def size_of(row: Row) -> int:
    """What varies in the series of a row."""
    if row["label"].startswith("elements"):
        return int(row["elements"])
    return int(max(row["cables"], row["springs"], row["points"], row["bodies"]))


def growth(results: Results) -> list[Row]:
    """Of each series, the cost of one more [us] over the larger half of its range; bar: that of the other."""
    found = []
    for label, rows in groups(results.of_kind("cost"), "label").items():
        sizes, costs = [size_of(row) for row in rows], column(rows, "microseconds")
        ends = sorted({0, len(rows) // 2, len(rows) - 1})
        slopes = [(costs[end] - costs[start]) / (sizes[end] - sizes[start]) for start, end in pairwise(ends)]
        if len(slopes) > 1:
            found.append({"label": label, "more": slopes[-1], "bar": 1.5 * slopes[0]})
    return found
