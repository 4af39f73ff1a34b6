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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import exudyn
import numpy as np

from exudyn_inext import (
    DivergenceError,
    ExplicitSettings,
    ExplicitStepper,
    SolveExplicit,
)
from reference_models.conventional.native_cables import NativeCables
from reference_models.model import quiet_settings, silence

from .harness import Order, Results, Row, Study, announce, column, groups, tables
from .harness import stretching_scenes as scenes
from .harness.bars import Bar, conclusions
from .harness.coupled_runs import Candidate, Inextensible, Native, distance, prepare
from .harness.coupled_scenes import CoupledScene
from .harness.plot import Curve, Panel, chart
from .harness.ratios import DEFAULT, TUNED
from .harness.timing import Task, sampled, steps_task
from .harness.tuning import Tuning, compare, draw_fronts, natives, ours
from .speed.soak import DRIFT, drift_of, long_run
from .stability.limits import DISTURBANCE, GROWTH, largest_stable_step

BOUNDS = (1e-3, 1e-4)
STIFFNESSES = (20.0, 200.0, 2e3, 2e4, 2e5, 2e6, 1e7)  # [N]
SAME, NEAR, DEARER, ENOUGH = 0.01, 0.1, 1.15, 3  # of limits, of distances, of steps [-]; scenes
REAL = scenes.SECTION.axial_stiffness
COARSE = Inextensible(10, 2e-3)
WITH_STEP = ExplicitSettings("RATTLE", stepSize=2e-3, massScaling=0.3)
LEAST_SECONDS, DISTURBED_STEPS = 1e-2, 2000  # of a sample [s]; of a disturbed cable


# ---------------------------------------------------------------------------- against native cables


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
    {
        "ours": ours,
        FULL: partial(natives, quadratures=("full",)),
        LOBATTO: partial(natives, quadratures=("lobatto",)),
    },
    _references,
    BOUNDS,
)
compared = partial(compare, bounds=BOUNDS, who=WHO)


# ------------------------------------------------------------------------------- over the stiffness


def _system(build: Callable[..., Any], **arguments: Any) -> tuple[Any, Any, Any]:
    """Container, assembled system, and what was built."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    built = build(mbs, **arguments)
    mbs.Assemble()
    return container, mbs, built


def _over_stiffness(stiffnesses: Sequence[float], end_time: float) -> Iterator[Row]:
    """Largest stable steps, and how far the pendulum is from the inextensible one."""
    scene = replace(scenes.SCENES[0], end_time=end_time)
    runs = [replace(scene, build=partial(scenes.pendulum, stiffness=k)) for k in (None, *stiffnesses)]
    rigid, *stretched = (prepare(one, COARSE, end_time)()[1] for one in runs)
    step = theirs = 1e-3
    for stiffness, paths in zip(stiffnesses, stretched, strict=True):
        step = _largest_step(step, stiffness=stiffness)
        theirs = _largest_step(theirs, addCable=NativeCables(stiffness))
        row = {"kind": "stiffness", "label": f"EA = {stiffness:g} N", "value": stiffness}
        yield row | {"found": step, "native": theirs, "distance": distance(paths, rigid)}


def _limit(row: Row) -> float:
    """What stays the same where the motion tends to the inextensible one."""
    return float(row["distance"] * row["value"])


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


def _long_runs(steps: int) -> Iterator[Row]:
    """Energy of the pendulum over that many steps."""
    for stiffness in (2e3, REAL):
        _kept, mbs, _ = _system(scenes.pendulum, elements=5, stiffness=stiffness)
        yield {"kind": "run", **long_run(f"EA = {stiffness:.3g} N", mbs, WITH_STEP, steps)}


def _costs(sizes: Sequence[tuple[int, int]], repeats: int) -> Iterator[Row]:
    """A step with axial stiffness over one without.   sizes: dimension, elements."""
    tasks = {(*size, k): _steps(*size, k) for size in sizes for k in (None, REAL)}
    found = sampled(tasks, repeats, LEAST_SECONDS, "steps")
    for dimension, elements in sizes:
        rigid, ours = (found[dimension, elements, k].cpu_seconds for k in (None, REAL))
        yield {
            "kind": "cost",
            "label": f"{dimension}D, {elements} elements",
            "microseconds": 1e6 * statistics.median(ours),
            "costRatio": statistics.median(one / other for one, other in zip(ours, rigid, strict=True)),
        }


def _steps(dimension: int, elements: int, stiffness: float | None) -> Task:
    kept = _system(scenes.pendulum, elements=elements, stiffness=stiffness, dimension=dimension)
    return steps_task(ExplicitStepper(kept[1], replace(WITH_STEP, stepSize=1e-3)), kept)


# ------------------------------------------------------------------------------------- the study


def measure(order: Order) -> list[Row]:
    """Rows of all kinds; the timed ones first."""
    quick = order.quick
    sizes = [(2, 5)] if quick else list(product((2, 3), (5, 10, 20, 50)))
    rows = list(_costs(sizes, 2 if quick else 15))
    for scene in scenes.SCENES[: 1 if quick else None]:
        announce("stretch", scene.name)
        rows += TUNING.rows(scene.brief() if quick else scene, quick)
    announce("stretch", "stiffnesses, long runs")
    rows += _over_stiffness(STIFFNESSES[2:4] if quick else STIFFNESSES, 0.1 if quick else 1.0)
    return [*rows, *_long_runs(2000 if quick else 1_000_000)]


def _third(results: Results) -> list[Row]:
    """Natives over ours on the scene that ENOUGH scenes reach, within each bound."""
    rows = []
    for name, bar in BARS.items():
        for within, own in groups(compared(results), "within").items():
            ratios = sorted(row.get(f"{name}/ours", 0.0) for row in own)
            row = {"label": f"{WHO[name][0]}, within {within}", "bar": bar}
            rows.append(row | {"ratio": ratios[-ENOUGH] if len(ratios) >= ENOUGH else None})
    return rows


CONCLUSIONS = conclusions(
    Bar(_third, "ratio", f"{{}}: CPU time over ours on {ENOUGH} scenes", "bar", "label", is_least=True),
    Bar("cost", "costRatio", "a step over an inextensible one", DEARER),
    Bar("stiffness", "found", "largest stable step over the least", 1.0 + SAME, over_least=True, noise=1.0),
    Bar("stiffness", "native", "the same of native cables", over_least=True),
    Bar("stiffness", _limit, "distance to the inextensible motion, times EA, over the least one", 1.0 + NEAR,
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
STUDY = Study("stretch", QUESTION, measure, CONCLUSIONS, TABLES, draw, minutes=5)
