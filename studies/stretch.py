"""Cables that stretch: what implicit axial forces save, from ropes of 20 N to wires of 1e7 N.

Question
    Does the explicit step of a cable with axial stiffness stay as it is for every stiffness, does the motion
    come out right, and what does it cost beside native cables?

What would refute it
    A largest stable step that changes with the stiffness; a step that costs more than 1.15 of the
    inextensible one; states that do not tend to the inextensible ones as the stiffness grows; energy that
    changes with time; on fewer than three scenes, at equal error, 20 times less CPU than natives with default
    quadrature and 5 times less than those with Lobatto quadrature.

Protocol
    Scenes, see `harness/stretching_scenes.py`: the pendulum of the paper with its real stiffness; a bungee
    of 20 N with a mass, which stretches by 43 %; a string under pretension; the power line of the paper
    with its real stiffness, from its equilibrium with ice, which falls off. The mass of the bungee is a part
    of our cable, and on a joint with natives, the cheapest way of either. Both sides are tuned as in
    `coupled`, natives with either quadrature on their own; the best runs of all sides are timed in turn.
    CPU times include the start of a run; ratios without it are beside them. Errors are those of `coupled`,
    from converged native runs; how far converged runs of ours are from these is said, too.
    Largest stable steps are bisected, by disturbances of a straight cable, without implicit bending;
    native cables take the same explicit steps. Cost of a step: compiled steps of the pendulum with and
    without axial stiffness, in turn.

Reference and tolerance
    Frequencies of the string, native pendulum and bungee, and the elastic catenary are compared in the tests.

What is left out
    Axial waves that a step does not resolve. Zhai and RK4, which treat axial forces explicitly.
"""

import statistics
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import exudyn
import numpy as np

from exudyn_inext import DivergenceError, ExplicitSettings, ExplicitStepper, SolveExplicit
from reference_models.conventional.native_cables import NativeCables
from reference_models.model import quiet_settings, silence

from .harness import Results, Row, Study, column, groups, tables
from .harness import stretching_scenes as scenes
from .harness.bars import Bar, conclusions
from .harness.benchmark import Benchmark, Series, varied
from .harness.coupled_runs import Candidate, Inextensible, Native, distance, prepare
from .harness.coupled_scenes import CoupledScene
from .harness.plot import Curve, Panel, chart
from .harness.ratios import DEFAULT, TUNED
from .harness.table import number
from .harness.timing import Task, steps_task
from .harness.tuning import Tuning, draw_fronts, natives, ours
from .speed.soak import DRIFT, drift_of, long_run
from .stability.limits import DISTURBANCE, GROWTH, largest_stable_step

BOUNDS = (1e-3, 1e-4)
STIFFNESSES = (20.0, 200.0, 2e3, 2e4, 2e5, 2e6, 1e7)  # [N]
SAME, NEAR, DEARER, ENOUGH = 0.01, 0.1, 1.15, 3  # of limits, of distances, of steps [-]; scenes
REAL = scenes.SECTION.axial_stiffness
COARSE = Inextensible(10, 2e-3)
WITH_STEP = ExplicitSettings("RATTLE", stepSize=2e-3, massScaling=0.3)
DISTURBED_STEPS, OURS, NATIVES = 2000, 2e-3, 8.5e-3  # of a disturbed cable; limits, nearly [s], [s N^1/2]


def _references(scene: CoupledScene) -> tuple[Candidate, Candidate]:
    elements, step = scene.fine
    return Native(elements, step, scene.axial[0]), Inextensible(elements, step)


FULL, LOBATTO = "native, default quadrature", "native, Lobatto quadrature"
BARS = {"full": 20.0, "lobatto": 5.0}  # native over ours
WHO = {
    "ours": ("ours", TUNED),
    "default": ("ours", DEFAULT),
    "full": (FULL, TUNED),
    "lobatto": (LOBATTO, TUNED),
}
TUNING = Tuning(
    scenes.SCENES,
    {
        "ours": ours,
        FULL: partial(natives, quadratures=("full",)),
        LOBATTO: partial(natives, quadratures=("lobatto",)),
    },
    _references,
    BOUNDS,
    WHO,
)
compared = TUNING.compared


def _system(build: Callable[..., Any], **arguments: Any) -> tuple[Any, Any, Any]:
    """Container, assembled system, and what was built."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    built = build(mbs, **arguments)
    mbs.Assemble()
    return container, mbs, built


def _over_stiffness(case: Row) -> Row:
    """Largest stable steps, and how far the pendulum is from the inextensible one."""
    stiffness, scene = case["value"], replace(scenes.SCENES[0], end_time=case["motion"])
    runs = [replace(scene, build=partial(scenes.pendulum, stiffness=k)) for k in (None, stiffness)]
    rigid, paths = (prepare(one, COARSE, scene.end_time)()[1] for one in runs)
    return {
        "label": f"EA = {stiffness:g} N",
        "found": _largest_step(OURS, stiffness=stiffness),
        "native": _largest_step(NATIVES / stiffness**0.5, addCable=NativeCables(stiffness)),
        "distance": distance(paths, rigid),
    }


def _largest_step(estimate: float, **cable: Any) -> float:
    """Bisected, about the straight cable [s]."""
    _kept, mbs, _ = _system(scenes.pendulum, elements=6, gravity=0.0, **cable)
    disturbance = DISTURBANCE * np.random.default_rng(1).uniform(-1.0, 1.0, 28)
    disturbance[:2] = 0.0
    data, settings = mbs.systemData, ExplicitSettings("RATTLE", allowUnstableStep=True, rejectSteps=False)

    def is_stable(h: float) -> bool:
        """Whether the disturbance of the cable at rest does not grow."""
        data.SetODE2Coordinates(disturbance, exudyn.ConfigurationType.Initial)
        end = DISTURBED_STEPS * h
        with warnings.catch_warnings(), silence():
            warnings.simplefilter("ignore", UserWarning)  # the step is above the limit on purpose
            try:
                SolveExplicit(mbs, quiet_settings(end, 1, period=end), replace(settings, stepSize=h))
            except DivergenceError:
                return False
        return float(np.abs(data.GetODE2Coordinates()).max()) < GROWTH * DISTURBANCE

    return largest_stable_step(is_stable, estimate)


def _long_run(case: Row) -> Row:
    """Energy of the pendulum over many steps."""
    _kept, mbs, _ = _system(scenes.pendulum, elements=5, stiffness=case["stiffness"])
    return long_run(f"EA = {case['stiffness']:.3g} N", mbs, WITH_STEP, case["steps"])


def _steps(case: Row) -> dict[Any, Task]:
    """With axial stiffness and without."""
    tasks = {}
    for stiffness in (None, REAL):
        kept = _system(scenes.pendulum, stiffness=stiffness, **case)
        stepper = ExplicitStepper(kept[1], replace(WITH_STEP, stepSize=1e-3))
        tasks[(*case.values(), stiffness)] = steps_task(stepper, kept)
    return tasks


def _cost(case: Row, found: Any) -> Row:
    """A step with axial stiffness over one without."""
    rigid, ours = (found[(*case.values(), k)].cpu_seconds for k in (None, REAL))
    return {
        "label": f"{case['dimension']}D, {case['elements']} elements",
        "microseconds": 1e6 * statistics.median(ours),
        "costRatio": statistics.median(one / other for one, other in zip(ours, rigid, strict=True)),
    }


SIZES = varied({"dimension": (2,), "elements": (5,)}, dimension=(2, 3), elements=(5, 10, 20, 50))
STIFF = varied({"value": STIFFNESSES[2:4], "motion": (0.1,)}, value=STIFFNESSES, motion=(1.0,))
LONG = varied({"steps": (2000,)}, stiffness=(2e3, REAL), steps=(1_000_000,))
MEASURE = Benchmark(
    [
        Series("cost", SIZES, _cost, _steps, rounds=(2, 15), least=(1e-2, 1e-2)),  # timed, before all others
        TUNING.series,
        Series("stiffness", STIFF, _over_stiffness),
        Series("run", LONG, _long_run),
    ]
)


def _third(results: Results) -> list[Row]:
    """Natives over ours that ENOUGH scenes reach, within each bound; the label has those of all scenes."""
    rows = []
    for name, bar in BARS.items():
        for within, own in groups(compared(results), "within").items():
            ratios = {row["scene"]: row.get(f"{name}/ours", 0.0) for row in own}
            third = sorted(ratios.values())[-ENOUGH] if len(ratios) >= ENOUGH else None
            row = {"label": ", ".join(f"{scene} {number(one)}" for scene, one in ratios.items()), "bar": bar}
            rows.append(row | {"sides": f"{WHO[name][0]}, within {within}", "ratio": third})
    return rows


CONCLUSIONS = conclusions(
    Bar(_third, "ratio", f"{{}}: CPU time over ours on {ENOUGH} scenes", "bar", "sides", is_least=True),
    Bar("cost", "costRatio", "a step over an inextensible one", DEARER),
    Bar("stiffness", "found", "largest stable step over the least", 1.0 + SAME, over_least=True, noise=1.0),
    Bar("stiffness", "native", "the same of native cables", over_least=True),
    Bar("stiffness", lambda row: row["distance"] * row["value"],
        "distance to the inextensible motion, times EA, over the least one", 1.0 + NEAR,
        over_least=True, noise=1.0),
    Bar("run", drift_of, "{}: drift of the mean energy over its range", DRIFT, "label", noise=1.0),
)  # fmt: skip


def draw(results: Results, directory: Path) -> list[Path]:
    """Fronts, and largest stable steps over the stiffness."""
    rows = results.of_kind("stiffness")
    steps = [Curve(column(rows, "value"), column(rows, key), name) for key, name in SHOWN.items()]
    panel = Panel("axial stiffness [N]", "largest stable step [s]", steps)
    fronts = draw_fronts(results, directory / "stretch_fronts.png", BOUNDS)
    return [fronts, chart(directory / "stretch_steps.png", panel)]


SHOWN = {"found": "ours", "native": "native cables"}
TABLES = tables(
    """
    best: Cheapest runs within a bound [s], and natives over ours, also without what the start takes:
        scene | within | ours | default settings: default | native, default quadrature: full |
        native, Lobatto: lobatto | default quadrature over ours: full/ours | steps alone: full//ours |
        Lobatto over ours: lobatto/ours | steps alone: lobatto//ours | converged runs agree to: agreement
    settings: Their settings and errors:
        scene | within | ours: oursSettings | error: oursError | default: defaultSettings |
        error: defaultError | default quadrature: fullSettings | error: fullError |
        Lobatto: lobattoSettings | error: lobattoError
    stiffness: Straight cable of 6 elements, and how far the pendulum is from the inextensible one:
        EA [N]: value | our largest step [s]: found | natives' [s]: native | distance [-]: distance
    cost: A step with axial stiffness:
        cable: label | step [us]: microseconds | over an inextensible one: costRatio
    run: Pendulum of 5 elements, h = 2e-3 s; energies over the swing:
        cable: label | steps | energy varies by: range | its mean drifts by: drift
    """,
    best=compared,
    settings=compared,
)
QUESTION = "What do cables that stretch cost, and are they right, from 20 N to 1e7 N?"
STUDY = Study("stretch", QUESTION, MEASURE, CONCLUSIONS, TABLES, draw, minutes=5)
