"""How long a single step takes, and how long it takes at worst.

Question
    Can hardware in the loop be run with these cables: how far below the step size does the time of
    a single step stay, in the rare cases too?

What would refute it
    A 99.9 percentile above the step size.

Protocol
    Planar pendulum, RATTLE, mass scaling 0.3, h = 1e-3 s, one ExplicitStepper.Step() at a time from Python:
    wall time of each of 100 000 steps, with Python's garbage collection on and off; and of a whole
    cycle, SetNodeForce, Step, State. All are run in turn, in portions of 1000 steps, so that a busy
    spell hits all alike. CPU time is that of the thread: it leaves out what other programs take, but
    not what they do to the caches. "Nothing" is two readings of the clocks: what the operating system and
    other programs take. A motion begins anew after 20 s.

What is left out
    Real-time kernels, pinned cores and priorities: the worst times are those of this machine as it was
    then, other programs included. Nodes and cables beyond 50 elements: see `scaling`.
"""

import gc
from array import array
from collections.abc import Callable
from functools import partial
from time import perf_counter_ns, thread_time_ns
from typing import Any

import numpy as np

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.inextensible import build
from reference_models.scenes import load_scene
from studies.harness import Results, Row
from studies.harness.timing import Prepare

STEP = 1e-3
SETTINGS = ExplicitSettings("RATTLE", stepSize=STEP, massScaling=0.3)
NUMBERS = (5, 20, 50)
PORTION = 1000
RESTART = 20.0  # [s] of motion
NANO, MICRO = 1e-9, 1e6
PERCENTILES = {50.0: "median", 99.9: "percentile999", 100.0: "worst"}
Times = list[tuple[array, array]]


def cases(quick: bool) -> list[Row]:
    """Nothing; steps with and without garbage collection; whole cycles."""
    ways = (("step", True), ("step", False), ("cycle", True))
    numbers = NUMBERS[:1] if quick else NUMBERS
    calls = [("nothing", 0, False), *((what, n, collects) for n in numbers for what, collects in ways)]
    return [dict(zip(("what", "elements", "garbageCollection"), one, strict=True)) for one in calls]


def label_of(case: Row) -> str:
    """What is timed, and how."""
    collection = (
        f", N = {case['elements']}, garbage collection {'on' if case['garbageCollection'] else 'off'}"
    )
    return case["what"] + (collection if case["elements"] else "")


def portions(case: Row) -> dict[str, Prepare]:
    """Calls one by one; what is found grows portion by portion."""
    once, renew = _call(case["what"], case["elements"])
    taken: Times = []

    def prepare() -> Callable[[], Times]:
        renew()
        return partial(take, once, case["garbageCollection"], taken)

    return {label_of(case): prepare}


def take(once: Callable[[], object], collects: bool, taken: Times) -> Times:
    """Wall and CPU time [ns] of each call of a portion, added to those that are known."""
    wall, cpu = array("q", bytes(8 * PORTION)), array("q", bytes(8 * PORTION))
    if collects:  # of all objects, as in a program of its own
        gc.unfreeze()
        gc.enable()
    try:
        for i in range(PORTION):
            start = perf_counter_ns()
            cpu_start = thread_time_ns()
            once()
            cpu[i] = thread_time_ns() - cpu_start
            wall[i] = perf_counter_ns() - start
    finally:
        gc.disable()
        gc.freeze()
    taken.append((wall, cpu))
    return taken


def _call(what: str, elements: int) -> tuple[Callable[[], object], Callable[[], object]]:
    """What is timed; what goes before each portion."""
    if what == "nothing":
        return (lambda: None), (lambda: None)
    model = build(load_scene("planar_pendulum"), elements)
    stepper = ExplicitStepper(model.mbs, SETTINGS)
    stepper.Start()
    node, force = model.nodes[-1], [0.0, 0.01, 0.0]

    def renew() -> None:
        if stepper.time > RESTART:
            stepper.Start()

    def cycle() -> None:
        stepper.SetNodeForce(node, force)
        stepper.Step()
        stepper.State()

    return (stepper.Step if what == "step" else cycle), renew


def row(case: Row, found: Any) -> Row:
    """The distribution; the first portion is the warm-up."""
    label = label_of(case)
    wall, cpu_of = zip(*found[label].found[1:], strict=True)
    seconds, cpu = NANO * np.ravel(wall), NANO * np.ravel(cpu_of)
    ordered = np.sort(seconds)[::-1]
    ranks = np.unique(np.geomspace(1, len(ordered), 60).astype(int))
    measured = {
        "label": label,
        "samples": len(seconds),
        "stepSize": STEP,
        "stepOverPercentile999": STEP / np.percentile(seconds, 99.9),
        "lateShare": float(np.mean(seconds > STEP)),
        # share of steps that take longer, time [us], down to the rarest
        "quantiles": [[float(rank / len(ordered)), float(MICRO * ordered[rank - 1])] for rank in ranks],
    }
    for part, name in PERCENTILES.items():
        measured[name] = MICRO * np.percentile(seconds, part)
        measured["cpu" + name[0].upper() + name[1:]] = MICRO * np.percentile(cpu, part)
    return case | measured


def steps(results: Results) -> list[Row]:
    """All rows but that of nothing."""
    return [row for row in results.of_kind("step") if row["what"] != "nothing"]
