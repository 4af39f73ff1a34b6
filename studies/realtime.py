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
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter_ns, thread_time_ns

import numpy as np
from tqdm import tqdm

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.inextensible import build
from reference_models.scenes import load_scene

from .harness.benchmark import Benchmark, Figures, Table
from .harness.plot import COLORS, label_axes, new_figure
from .harness.study import Row
from .harness.verdict import at_most, verdict

STEP = 1e-3
SETTINGS = ExplicitSettings("RATTLE", stepSize=STEP, massScaling=0.3)
NUMBERS = (5, 20, 50)
PORTION = 1000
RESTART = 20.0  # [s] of motion
NANO = 1e-9
MICRO = 1e6
QUICK_TAIL_NOISE = 5.0  # factor: the 99.9 percentile of a quick run is that of its five slowest steps


@dataclass
class Series:
    """One distribution.   once: what is timed.   prepare: before each portion.   wall, cpu: samples [ns]."""

    what: str
    elements: int
    collects: bool
    once: Callable[[], object]
    prepare: Callable[[], object]
    wall: array = field(default_factory=lambda: array("q"))
    cpu: array = field(default_factory=lambda: array("q"))

    @property
    def label(self) -> str:
        collection = "" if self.elements == 0 else f", garbage collection {'on' if self.collects else 'off'}"
        return self.what + (f", N = {self.elements}" if self.elements else "") + collection


def measure(quick: bool) -> list[Row]:
    """One row for each distribution."""
    portions = 5 if quick else 100
    series = [Series("nothing", 0, False, lambda: None, lambda: None)]
    for elements in NUMBERS:
        series += _series_of(elements)
    for one in series:
        _take(one, PORTION)
        del one.wall[:], one.cpu[:]
    for _ in tqdm(range(portions), desc="realtime", unit="portion"):
        for one in series:
            _take(one, PORTION)
    return [_row(one) for one in series]


def _series_of(elements: int) -> list[Series]:
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

    return [
        Series("step", elements, True, stepper.Step, renew),
        Series("step", elements, False, stepper.Step, renew),
        Series("cycle", elements, True, cycle, renew),
    ]


def _take(series: Series, number: int) -> None:
    """Time `number` calls one by one."""
    series.prepare()
    once, wall, cpu = series.once, array("q", bytes(8 * number)), array("q", bytes(8 * number))
    was_enabled = gc.isenabled()
    (gc.enable if series.collects else gc.disable)()
    try:
        for i in range(number):
            start = perf_counter_ns()
            cpu_start = thread_time_ns()
            once()
            cpu[i] = thread_time_ns() - cpu_start
            wall[i] = perf_counter_ns() - start
    finally:
        (gc.enable if was_enabled else gc.disable)()
    series.wall.extend(wall)
    series.cpu.extend(cpu)


def _row(series: Series) -> Row:
    seconds, cpu = (NANO * np.asarray(samples, dtype=float) for samples in (series.wall, series.cpu))
    median, most, worst = np.percentile(seconds, [50.0, 99.9, 100.0])
    cpu_median, cpu_most, cpu_worst = np.percentile(cpu, [50.0, 99.9, 100.0])
    return {
        "kind": "step",
        "label": series.label,
        "what": series.what,
        "elements": series.elements,
        "garbageCollection": series.collects,
        "samples": len(seconds),
        "stepSize": STEP,
        "median": MICRO * median,
        "percentile999": MICRO * most,
        "worst": MICRO * worst,
        "cpuMedian": MICRO * cpu_median,
        "cpuPercentile999": MICRO * cpu_most,
        "cpuWorst": MICRO * cpu_worst,
        "stepOverPercentile999": STEP / most,
        "lateShare": float(np.mean(seconds > STEP)),
        "quantiles": _tail(seconds),
    }


def _tail(seconds: np.ndarray) -> list[list[float]]:
    """[share of steps that take longer, time [us]], down to the rarest."""
    ordered = np.sort(seconds)[::-1]
    ranks = np.unique(np.geomspace(1, len(ordered), 60).astype(int))
    return [[float(rank / len(ordered)), float(MICRO * ordered[rank - 1])] for rank in ranks]


def conclude(figures: Figures) -> list[str]:
    """Step size against the times."""
    rows = [row for row in figures.of_kind("step") if row["what"] != "nothing"]
    slowest = max(rows, key=lambda row: float(row["percentile999"]))
    worst = max(rows, key=lambda row: float(row["worst"]))
    late = sum(row["lateShare"] * row["samples"] for row in rows)
    (nothing,) = (row for row in figures.of_kind("step") if row["what"] == "nothing")
    noise = QUICK_TAIL_NOISE if figures.quick else 1.0
    is_kept = at_most(slowest["percentile999"], MICRO * STEP, noise)
    return [
        f"99.9 % of the steps are done within {slowest['percentile999']:.0f} us of wall time "
        f"({slowest['label']}), {slowest['cpuPercentile999']:.0f} us of CPU time; the step size is "
        f"{MICRO * STEP:g} us ({verdict(is_kept, 'bar kept', 'bar MISSED')}).",
        f"The longest of {sum(row['samples'] for row in rows)} steps took {worst['worst']:.0f} us "
        f"({worst['label']}), {max(row['cpuWorst'] for row in rows):.0f} us of CPU time at most; "
        f"{late:.0f} took longer than the step size. Nothing at all took up to "
        f"{nothing['worst']:.0f} us on this machine.",
    ]


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Share of steps that take longer than a time."""
    path = directory / "realtime_steps.png"
    colors = dict(zip((0, *NUMBERS), (COLORS[-1], *COLORS), strict=False))
    styles = {("step", True): "-", ("step", False): "--", ("cycle", True): ":", ("nothing", False): "-"}
    with new_figure(path, 9.0, 5.4) as figure:
        axes = figure.subplots()
        for row in figures.of_kind("step"):
            shares, times = np.transpose(row["quantiles"])
            style = styles[row["what"], row["garbageCollection"]]
            axes.loglog(times, shares, style, color=colors[row["elements"]], label=row["label"])
        axes.axvline(MICRO * STEP, color="#666666", linewidth=3, label=f"step size {1e3 * STEP:g} ms")
        label_axes(axes, "wall time t of one call [us]", "share of calls that take longer than t [-]")
        figure.legend(loc="outside right upper")
    return [path]


STUDY = Benchmark(
    name="realtime",
    question="How long does a single step take at worst, against the step size?",
    measure=measure,
    tables=(
        Table(
            "step",
            "Time of single calls, wall time unless stated:",
            {
                "what": "label",
                "calls": "samples",
                "median [us]": "median",
                "99.9 % [us]": "percentile999",
                "worst [us]": "worst",
                "CPU 99.9 % [us]": "cpuPercentile999",
                "CPU worst [us]": "cpuWorst",
                "h / 99.9 %": "stepOverPercentile999",
                "share above h": "lateShare",
            },
        ),
    ),
    conclusions=conclude,
    pictures=draw,
)
