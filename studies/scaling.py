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

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.inextensible import build
from reference_models.scenes import Scene, load_scene

from .harness import Order, Results, Row, Study, groups, judged, largest, tables
from .harness.cases import stepper_case
from .harness.inner import element_type, node_type
from .harness.memory import long_cable
from .harness.plot import Panel, chart, curves_of
from .harness.pool import ask
from .harness.reference import from_data
from .harness.timing import Task, medians, seconds_per_time
from .harness.timing import measure as measure_cases

PLANAR = load_scene("planar_pendulum")
RING = replace(load_scene("vibrating_ring"), loads=())
CHAINS = {"2D": PLANAR, "3D": load_scene("spatial_pendulum"), "2D, closed": RING}
INTEGRATORS = {"Zhai": 9, "RATTLE": 7}  # arrays of the integrator, and the constant force
NUMBERS = (20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)
RING_FORCE = 1.0  # [N]
PORTION, RESTART = 1000, 3.0  # steps in one call; [s] of motion
THETA = 0.3
LONG = 100_000
SPREAD, MEMORY, ERROR = 1.25, 1e9, 1e-3  # the bars
MICRO = 1e6

bar = partial(judged, kept="bar kept", missed="bar MISSED")


def measure(order: Order) -> list[Row]:
    """Cost, memory and accuracy."""
    costs = [row for chain in CHAINS for name in INTEGRATORS for row in _costs(chain, name, order.quick)]
    size = (10_000, 5) if order.quick else (LONG, 20)
    return costs + [_memory_row(chain, *size) for chain in ("2D", "3D")] + list(_accuracy_rows(order.quick))


def _costs(chain: str, integrator: str, quick: bool) -> Iterator[Row]:
    """CPU time of an element's step; its memory: records of a node and an element, and arrays."""
    scene, timing = CHAINS[chain], (3, 5e-3) if quick else (9, 5e-2)
    tasks = {n: _steps(scene, n, integrator) for n in ((20, 200, 2000) if quick else NUMBERS)}
    dim = 2 if scene.is_planar else 3
    records = node_type(dim).itemsize + element_type(dim, product=False).itemsize
    for elements, seconds in medians(seconds_per_time(tasks, *timing, f"{chain}, {integrator}")).items():
        yield {
            "kind": "cost",
            "label": f"{chain}, {integrator}",
            "elements": elements,
            "microseconds": MICRO * seconds / elements,
            "megabytes": elements * (records + INTEGRATORS[integrator] * 2 * dim * 8) / 1e6,
        }


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


def _memory_row(chain: str, elements: int, steps: int) -> Row:
    found = ask(long_cable, CHAINS[chain].name, elements, steps)
    return {
        "kind": "memory",
        "label": f"{chain}, RATTLE",
        "elements": elements,
        **{f"{what}Megabytes": found[what] / 1e6 for what in ("libraries", "model", "peak")},
        "startSeconds": found["startSeconds"],
        "microseconds": MICRO * found["stepSeconds"] / elements,
    }


def _accuracy_rows(quick: bool) -> Iterator[Row]:
    """Errors, cost of an element's step, and seconds of motion a second of CPU time."""
    scene = replace(PLANAR, end_time=0.5) if quick else PLANAR
    cases = [
        stepper_case(scene, elements, ExplicitSettings(integrator, stepSize=2e-3, massScaling=THETA))
        for integrator in INTEGRATORS
        for elements in ((10, 100) if quick else (10, 100, 1000, 5000))
    ]
    for row, _ in measure_cases(cases, 2 if quick else 5, from_data(PLANAR).trajectory, "accuracy"):
        seconds, work = row["cpuSeconds"], row["steps"] * row["elements"]
        yield {
            "kind": "accuracy",
            "motion": scene.end_time,
            **row,
            "microseconds": MICRO * seconds / work if seconds else None,
            "realTime": scene.end_time / seconds if seconds else None,
        }


def conclude(results: Results) -> list[str]:
    """Whether the bars are kept."""
    series, memory = groups(results.of_kind("cost"), "label"), results.of_kind("memory")
    sentences = []
    for rows in series.values():
        most, least = largest(rows, "microseconds"), min(rows, key=lambda row: row["microseconds"])
        ratio = most["microseconds"] / least["microseconds"]
        sentences.append(
            "{label}: {microseconds:.3f} us per element and step (N = {elements}) to ".format_map(least)
            + "{microseconds:.3f} us (N = {elements}), a factor of ".format_map(most)
            + f"{ratio:.2f} ({bar(ratio, SPREAD, results.noise)}); "
            f"{1e6 * rows[-1]['megabytes'] / rows[-1]['elements']:.0f} bytes an element."
        )
    sentences += [
        "{elements} elements, {label}: {peakMegabytes:.0f} MB at most, {librariesMegabytes:.0f} MB of "
        "them libraries ({found}).".format_map(row | {"found": bar(row["peakMegabytes"], 1e-6 * MEMORY)})
        for row in memory
    ]
    sentences += [_beyond_caches(row, series[row["label"]][-1]) for row in memory]
    measured = (
        "{label}, h = {stepSize:g} s: {errorMax:.1e} m off over {motion:g} s ({found}), {realTime:.3g} "
        "times real time."
    )
    return sentences + [
        "{label}: {status}.".format_map(row)
        if row["errorMax"] is None
        else measured.format_map(row | {"found": bar(row["errorMax"], ERROR)})
        for row in results.of_kind("accuracy")
    ]


def _beyond_caches(row: Row, longest: Row) -> str:
    """How much dearer an element is where a step goes through more memory than the caches hold."""
    ratio = row["microseconds"] / longest["microseconds"]
    megabytes = longest["megabytes"] * row["elements"] / longest["elements"]
    return (
        f"{row['label']}: an element's step costs {ratio:.2f} times as much at N = {row['elements']} "
        f"({megabytes:.0f} MB) as at N = {longest['elements']} ({longest['megabytes']:.1f} MB)."
    )


def draw(results: Results, directory: Path) -> list[Path]:
    """Cost per element over N."""
    curves = curves_of(
        groups(results.of_kind("cost"), "label"), "elements", "microseconds", {"Zhai": "s--", "RATTLE": "o-"}
    )
    cost = "CPU time per element and step [us]"
    panel = Panel("elements N [-]", cost, curves, "semilogx", legend=False, horizontal=(0.0,))
    return [chart(directory / "scaling_cost.png", panel, columns=3)]


TABLES = tables(
    """
    cost: CPU time per element and step, and the memory that a step goes through:
        chain: label | N: elements | us/(N step): microseconds | memory of a step [MB]: megabytes
    memory: Resident memory of a long cable:
        chain: label | N: elements | libraries [MB]: librariesMegabytes |
        with model [MB]: modelMegabytes | peak [MB]: peakMegabytes | start [s]: startSeconds |
        us/(N step): microseconds
    accuracy: Planar pendulum with mass scaling 0.3 at h = 2e-3 s:
        run: label | N: elements | motion [s]: motion | CPU [s]: cpuSeconds | us/(N step): microseconds |
        times real time: realTime | error max [m]: errorMax | error rms [m]: errorRms
    """
)

QUESTION = "Does an element cost the same in short and in very long cables?"
STUDY = Study("scaling", QUESTION, measure, conclude, TABLES, draw, minutes=2)
