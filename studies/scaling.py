"""Cost and memory of long cables.

Question
    Does an element cost the same in a cable of 20 as in one of 10 000, and how long may a cable be?

What would refute it
    Cost per element and step that varies by more than 25 % over N = 20 to 10 000; 1 GB for 100 000 elements;
    with scaled mass at h = 2e-3 s, errors of the planar pendulum above 1e-3 m or a cost out of proportion
    to N for N = 10, 100, 1000; 5000 elements slower than real time.

Protocol
    Cost: compiled steps (ExplicitStepper.Step) of the pendulums and of the free ring, pulled by two forces
    of 1 N, mass scaling 0.3, h = 1e-3 s, so that all meshes move alike; CPU time, round robin over all N,
    medians. A stepper begins anew after 3 s of motion. Zhai does the same work in all steps; RATTLE
    corrects positions as often as its tolerance asks for. The memory of a step is what it goes through: the
    records of nodes and elements, and the integrator's arrays.
    Memory: largest resident memory of a process that builds the pendulum as an mbs and steps it.
    Accuracy: 5 s of the planar pendulum with the tip at 100 Hz against the independent reference
    (good to 5e-5 m), start and steps timed, building not.

What is left out
    Building the model: some 30 us an element.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from exudyn_inext import ExplicitSettings, ExplicitStepper
from exudyn_inext.chain.records import element_type, node_type
from reference_models.inextensible import build
from reference_models.scenes import Scene, load_scene

from .harness.benchmark import Benchmark, Figures, Table
from .harness.interleaved import Task, medians, seconds_per_time
from .harness.memory import memory_of
from .harness.plot import COLORS, label_axes, new_figure
from .harness.reference import from_data
from .harness.rows import make_row
from .harness.stepper_case import stepper_case
from .harness.study import Row
from .harness.timing import measure as measure_cases
from .harness.verdict import at_most, verdict

PLANAR = load_scene("planar_pendulum")
RING = replace(load_scene("vibrating_ring"), loads=())
CHAINS = {"2D": PLANAR, "3D": load_scene("spatial_pendulum"), "2D, closed": RING}
INTEGRATORS = ("Zhai", "RATTLE")
NUMBERS = (20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)
RING_FORCE = 1.0  # [N]
PORTION = 1000  # steps in one call
RESTART = 3.0  # [s]
THETA = 0.3
LONG = 100_000
SPREAD, MEMORY, ERROR = 1.25, 1e9, 1e-3  # the bars
MICRO = 1e6


def measure(quick: bool) -> list[Row]:
    """Cost, memory and accuracy."""
    numbers = (20, 200, 2000) if quick else NUMBERS
    repeats, seconds = (3, 5e-3) if quick else (9, 5e-2)
    rows = [row for chain in CHAINS for row in _measure_cost(chain, numbers, repeats, seconds)]
    return rows + _measure_memory(quick) + _measure_accuracy(quick)


def _measure_cost(chain: str, numbers: Sequence[int], repeats: int, seconds: float) -> list[Row]:
    rows = []
    for integrator in INTEGRATORS:
        tasks = {str(elements): _steps(CHAINS[chain], elements, integrator) for elements in numbers}
        time = medians(seconds_per_time(tasks, repeats, seconds, f"{chain}, {integrator}"))
        rows += [
            {
                "kind": "cost",
                "label": f"{chain}, {integrator}",
                "elements": elements,
                "microseconds": MICRO * time[str(elements)] / elements,
                "megabytes": elements * _bytes(CHAINS[chain], integrator) / 1e6,
            }
            for elements in numbers
        ]
    return rows


def _steps(scene: Scene, elements: int, integrator: str) -> Task:
    model = build(scene, elements)
    stepper = ExplicitStepper(model.mbs, ExplicitSettings(integrator, stepSize=1e-3, massScaling=THETA))
    if scene is RING:
        stepper.SetNodeForce(model.nodes[0], [RING_FORCE, 0.0, 0.0])
        stepper.SetNodeForce(model.nodes[elements // 2], [-RING_FORCE, 0.0, 0.0])
    stepper.Start()

    def task(times: int) -> None:
        while times:
            portion = min(times, PORTION)
            if stepper.time + portion * stepper.stepSize > RESTART:
                stepper.Start()
            stepper.Step(portion)
            times -= portion

    return task


def _bytes(scene: Scene, integrator: str) -> int:
    """Of one node and element: records, and the integrator's arrays."""
    dim = 2 if scene.is_planar else 3
    arrays = {"Zhai": 8, "RATTLE": 6}[integrator] + 1  # the constant force
    return int(node_type(dim).itemsize + element_type(dim, product=False).itemsize + arrays * 2 * dim * 8)


def _measure_memory(quick: bool) -> list[Row]:
    elements, steps = (10_000, 5) if quick else (LONG, 20)
    rows = []
    for chain in ("2D", "3D"):
        row = memory_of(CHAINS[chain].name, elements, steps)
        rows.append(
            {
                "kind": "memory",
                "label": f"{chain}, RATTLE",
                "elements": elements,
                "librariesMegabytes": row["libraries"] / 1e6,
                "modelMegabytes": row["model"] / 1e6,
                "peakMegabytes": row["peak"] / 1e6,
                "startSeconds": row["startSeconds"],
                "microseconds": MICRO * row["stepSeconds"] / elements,
            }
        )
    return rows


def _measure_accuracy(quick: bool) -> list[Row]:
    scene = replace(PLANAR, end_time=0.5) if quick else PLANAR
    numbers = (10, 100) if quick else (10, 100, 1000, 5000)
    cases = [
        stepper_case(scene, elements, ExplicitSettings(integrator, stepSize=2e-3, massScaling=THETA))
        for integrator in INTEGRATORS
        for elements in numbers
    ]
    reference = from_data(PLANAR).trajectory
    rows = [make_row(measurement, reference) for measurement in measure_cases(cases, 2 if quick else 5)]
    return [{"kind": "accuracy", "motion": scene.end_time} | row | _speed(row, scene) for row in rows]


def _speed(row: Row, scene: Scene) -> Row:
    """Cost of an element's step, and seconds of motion a second of CPU time."""
    if not row["cpuSeconds"]:
        return {"microseconds": None, "realTime": None}
    return {
        "microseconds": MICRO * row["cpuSeconds"] / row["steps"] / row["elements"],
        "realTime": scene.end_time / row["cpuSeconds"],
    }


def conclude(figures: Figures) -> list[str]:
    """Whether the bars are kept."""
    return [
        *(_spread(label, rows, figures.noise) for label, rows in _series(figures).items()),
        *(
            f"{row['elements']} elements, {row['label']}: {row['peakMegabytes']:.0f} MB at most, "
            f"{row['librariesMegabytes']:.0f} MB of them libraries "
            f"({_verdict(row['peakMegabytes'] <= 1e-6 * MEMORY)})."
            for row in figures.of_kind("memory")
        ),
        *(_beyond_caches(row, figures) for row in figures.of_kind("memory")),
        *(_accuracy(row) for row in figures.of_kind("accuracy")),
    ]


def _beyond_caches(row: Row, figures: Figures) -> str:
    """How much dearer an element is where a step goes through more memory than the caches hold."""
    longest = _series(figures)[row["label"]][-1]
    ratio = row["microseconds"] / longest["microseconds"]
    megabytes = longest["megabytes"] * row["elements"] / longest["elements"]
    return (
        f"{row['label']}: an element's step costs {ratio:.2f} times as much at N = {row['elements']} "
        f"({megabytes:.0f} MB) as at N = {longest['elements']} ({longest['megabytes']:.1f} MB)."
    )


def _verdict(is_kept: bool | None) -> str:
    return verdict(is_kept, "bar kept", "bar MISSED")


def _series(figures: Figures) -> dict[str, list[Row]]:
    """Label -> its rows of cost."""
    rows = figures.of_kind("cost")
    return {
        label: [r for r in rows if r["label"] == label] for label in dict.fromkeys(r["label"] for r in rows)
    }


def _spread(label: str, rows: Sequence[Row], noise: float) -> str:
    least, most = (pick(rows, key=lambda row: row["microseconds"]) for pick in (min, max))
    ratio = most["microseconds"] / least["microseconds"]
    return (
        f"{label}: {least['microseconds']:.3f} us per element and step (N = {least['elements']}) to "
        f"{most['microseconds']:.3f} us (N = {most['elements']}), a factor of {ratio:.2f} "
        f"({_verdict(at_most(ratio, SPREAD, noise))}); "
        f"{1e6 * rows[-1]['megabytes'] / rows[-1]['elements']:.0f} bytes an element."
    )


def _accuracy(row: Row) -> str:
    if row["errorMax"] is None:
        return f"{row['label']}: {row['status']}."
    return (
        f"{row['label']}, h = {row['stepSize']:g} s: {row['errorMax']:.1e} m off over {row['motion']:g} s "
        f"({_verdict(row['errorMax'] <= ERROR)}), {row['realTime']:.3g} times real time."
    )


def draw(figures: Figures, directory: Path) -> list[Path]:
    """Cost per element over N."""
    path = directory / "scaling_cost.png"
    with new_figure(path, 8.0, 4.6) as figure:
        axes = figure.subplots()
        for (label, rows), color in zip(_series(figures).items(), COLORS, strict=False):
            numbers = [row["elements"] for row in rows]
            style = "o-" if "RATTLE" in label else "s--"
            axes.semilogx(numbers, [row["microseconds"] for row in rows], style, color=color, label=label)
        axes.set_ylim(bottom=0.0)
        label_axes(axes, "elements N [-]", "CPU time per element and step [us]")
        figure.legend(loc="outside upper left", ncols=3)
    return [path]


COST_COLUMNS = {
    "chain": "label",
    "N": "elements",
    "us/(N step)": "microseconds",
    "memory of a step [MB]": "megabytes",
}
MEMORY_COLUMNS = {
    "chain": "label",
    "N": "elements",
    "libraries [MB]": "librariesMegabytes",
    "with model [MB]": "modelMegabytes",
    "peak [MB]": "peakMegabytes",
    "start [s]": "startSeconds",
    "us/(N step)": "microseconds",
}
ACCURACY_COLUMNS = {
    "run": "label",
    "N": "elements",
    "motion [s]": "motion",
    "CPU [s]": "cpuSeconds",
    "us/(N step)": "microseconds",
    "times real time": "realTime",
    "error max [m]": "errorMax",
    "error rms [m]": "errorRms",
}

STUDY = Benchmark(
    name="scaling",
    question="Does an element cost the same in short and in very long cables?",
    measure=measure,
    tables=(
        Table(
            "cost", "CPU time per element and step, and the memory that a step goes through:", COST_COLUMNS
        ),
        Table("memory", "Resident memory of a long cable:", MEMORY_COLUMNS),
        Table("accuracy", "Planar pendulum with mass scaling 0.3 at h = 2e-3 s:", ACCURACY_COLUMNS),
    ),
    conclusions=conclude,
    pictures=draw,
)
