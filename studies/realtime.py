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
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter_ns, thread_time_ns

import numpy as np
from tqdm import tqdm

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.inextensible import build
from reference_models.scenes import load_scene

from .harness import Order, Results, Row, Study, Table, column, groups, judged, largest
from .harness.plot import COLORS, Curve, Panel, chart

STEP = 1e-3
SETTINGS = ExplicitSettings("RATTLE", stepSize=STEP, massScaling=0.3)
NUMBERS = (5, 20, 50)
PORTION = 1000
RESTART = 20.0  # [s] of motion
NANO, MICRO = 1e-9, 1e6
QUICK_TAIL_NOISE = 5.0  # factor: the 99.9 percentile of a quick run is that of its five slowest steps
PERCENTILES = {50.0: "median", 99.9: "percentile999", 100.0: "worst"}


@dataclass
class Series:
    """One distribution.   once: what is timed.   prepare: before each portion.   taken: wall, CPU [ns]."""

    what: str
    elements: int
    collects: bool
    once: Callable[[], object]
    prepare: Callable[[], object]
    taken: list[tuple[array, array]] = field(default_factory=list)

    @property
    def label(self) -> str:
        collection = f", N = {self.elements}, garbage collection {'on' if self.collects else 'off'}"
        return self.what + (collection if self.elements else "")

    def take(self) -> None:
        """Time the calls of a portion one by one."""
        self.prepare()
        once, wall, cpu = self.once, array("q", bytes(8 * PORTION)), array("q", bytes(8 * PORTION))
        was_enabled = gc.isenabled()
        (gc.enable if self.collects else gc.disable)()
        try:
            for i in range(PORTION):
                start = perf_counter_ns()
                cpu_start = thread_time_ns()
                once()
                cpu[i] = thread_time_ns() - cpu_start
                wall[i] = perf_counter_ns() - start
        finally:
            (gc.enable if was_enabled else gc.disable)()
        self.taken.append((wall, cpu))


def measure(order: Order) -> list[Row]:
    """One row for each distribution; the first portion of each is the warm-up."""
    series = [Series("nothing", 0, False, lambda: None, lambda: None)]
    series += [one for elements in NUMBERS for one in _series_of(elements)]
    for _ in tqdm(range(1 + (5 if order.quick else 100)), desc="realtime", unit="portion"):
        for one in series:
            one.take()
    return [_row(one) for one in series]


def _series_of(elements: int) -> Iterator[Series]:
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

    for what, collects, once in (
        ("step", True, stepper.Step), ("step", False, stepper.Step), ("cycle", True, cycle)
    ):  # fmt: skip
        yield Series(what, elements, collects, once, renew)


def _row(series: Series) -> Row:
    wall, cpu_of = zip(*series.taken[1:], strict=True)
    seconds, cpu = NANO * np.ravel(wall), NANO * np.ravel(cpu_of)
    ordered = np.sort(seconds)[::-1]
    ranks = np.unique(np.geomspace(1, len(ordered), 60).astype(int))
    row = {
        "kind": "step",
        "label": series.label,
        "what": series.what,
        "elements": series.elements,
        "garbageCollection": series.collects,
        "samples": len(seconds),
        "stepSize": STEP,
        "stepOverPercentile999": STEP / np.percentile(seconds, 99.9),
        "lateShare": float(np.mean(seconds > STEP)),
        # share of steps that take longer, time [us], down to the rarest
        "quantiles": [[float(rank / len(ordered)), float(MICRO * ordered[rank - 1])] for rank in ranks],
    }
    for part, name in PERCENTILES.items():
        row[name] = MICRO * np.percentile(seconds, part)
        row["cpu" + name[0].upper() + name[1:]] = MICRO * np.percentile(cpu, part)
    return row


def conclude(results: Results) -> list[str]:
    """Step size against the times."""
    rows = [row for row in results.of_kind("step") if row["what"] != "nothing"]
    (nothing,) = groups(results.of_kind("step"), "what")["nothing"]
    slowest, worst = largest(rows, "percentile999"), largest(rows, "worst")
    late = sum(row["lateShare"] * row["samples"] for row in rows)
    noise = QUICK_TAIL_NOISE if results.quick else 1.0
    found = judged(slowest["percentile999"], MICRO * STEP, noise, "bar kept", "bar MISSED")
    return [
        "99.9 % of the steps are done within {percentile999:.0f} us of wall time ({label}), "
        "{cpuPercentile999:.0f} us of CPU time; the step size is ".format_map(slowest)
        + f"{MICRO * STEP:g} us ({found}).",
        f"The longest of {sum(column(rows, 'samples'))} steps took {worst['worst']:.0f} us "
        f"({worst['label']}), {max(column(rows, 'cpuWorst')):.0f} us of CPU time at most; "
        f"{late:.0f} took longer than the step size. Nothing at all took up to "
        f"{nothing['worst']:.0f} us on this machine.",
    ]


def draw(results: Results, directory: Path) -> list[Path]:
    """Share of steps that take longer than a time."""
    colors = dict(zip((0, *NUMBERS), (COLORS[-1], *COLORS), strict=False))
    styles = {("step", True): "-", ("step", False): "--", ("cycle", True): ":", ("nothing", False): "-"}
    curves = []
    for row in results.of_kind("step"):
        shares, times = np.transpose(row["quantiles"])
        style = styles[row["what"], row["garbageCollection"]]
        curves.append(Curve(times, shares, row["label"], colors[row["elements"]], style))
    labels = "wall time t of one call [us]", "share of calls that take longer than t [-]"
    title = f"dotted: step size {1e3 * STEP:g} ms"
    panel = Panel(*labels, curves, title=title, legend=False, vertical=(MICRO * STEP,))
    return [chart(directory / "realtime_steps.png", panel, width=9.0, height=6.4, columns=2)]


TABLE = Table(
    "step",
    "Time of single calls, wall time unless stated:",
    "what: label | calls: samples | median [us]: median | 99.9 % [us]: percentile999 | "
    "worst [us]: worst | CPU 99.9 % [us]: cpuPercentile999 | CPU worst [us]: cpuWorst | "
    "h / 99.9 %: stepOverPercentile999 | share above h: lateShare",
)

QUESTION = "How long does a single step take at worst, against the step size?"
STUDY = Study("realtime", QUESTION, measure, conclude, [TABLE], draw, minutes=0.3)
