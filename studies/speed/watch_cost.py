"""What the watch over a run costs.

Question
    How much longer does a step take because energy, constraints and finiteness are watched?

What would refute it
    More than 3 % of a step.

Protocol
    Cables alone: the compiled loop over 4096 steps, with inspections and without one, from the same state.
    Steady: gravity alone; damped: bending damping; loaded: a force that is a function of time; moved: a
    support that moves. Step: half of the stability limit.
    Among bodies: the loop in mid-motion, up to the second inspection, with the watch and without one, of
    one and the same run; joined: a rigid body on the cable's end; beside: a mass on a spring near the
    cable, the cheapest step that there is. At the automatic step.
    CPU time, all tasks of one chain round robin, medians of ratios within one round, and the interval
    that holds the median with 95 % confidence (sign test), whatever else the machine does.

What is left out
    The look at the present stability limit every 20 000 steps, and what a run that went wrong costs.
"""

import math
from contextlib import ExitStack
from functools import partial
from types import SimpleNamespace
from typing import Any

import exudyn.utilities as items
import numpy as np

from exudyn_inext import CreatePrescribedMotion, ExplicitSettings, ExplicitStepper
from studies.harness import Row, inner
from studies.harness.joined_scenes import GRAVITY, Contents, joined_scene
from studies.harness.timing import Task

BAR = 0.03
STEPS = 4096
STEPS_AMONG_BODIES = 2 * inner.STEPS_BETWEEN
STEPS_OF_AN_OUTPUT = 8
CONFIDENCE = 0.95
ALONE = ("steady", "damped", "loaded", "moved")
AMONG_BODIES = ("joined", "beside")
DAMPING = 1e-5
MICRO = 1e6

WATCHED, UNINSPECTED = "watched", "uninspected"
Ways = dict[Any, Task]


def row(case: Row, found: Any) -> Row:
    """What the watch takes of a step, from ratios within one round."""
    from scipy.stats import quantile_test  # which takes a second to import

    name, kind = case["integrator"], case["scene"]
    watched, uninspected = (np.array(found[name, way].cpu_seconds) for way in (WATCHED, UNINSPECTED))
    ratios = watched / uninspected - 1.0
    interval = quantile_test(ratios, p=0.5).confidence_interval(CONFIDENCE)
    steps = STEPS_AMONG_BODIES if kind in AMONG_BODIES else STEPS
    return case | {
        "label": f"{case['dimension']}D, {kind}, {name}",
        "repeats": len(ratios),
        "microseconds": MICRO * float(np.median(uninspected)) / steps,
        "share": float(np.median(ratios)),
        "low": float(interval.low),
        "high": float(interval.high),
        "bar": BAR,
    }


def alone(case: Row) -> Ways:
    """Steps of the compiled loops."""
    mbs, name = _build(case), case["integrator"]
    h = 0.5 * ExplicitStepper(mbs, ExplicitSettings(name, massScaling=0.0)).bounds.stability_limit
    explicit = ExplicitSettings(name, energyTolerance=math.inf)
    (run,) = inner.cable_runs(mbs, inner.read_scene(mbs).cables, 0.0, 0.0, explicit)
    initial = run.state.q.copy(), run.state.v.copy()
    loads = run.loads.sample(inner.Piece(0.0, 0, h, STEPS, STEPS, True), run.integrator.stages)
    history = np.zeros((STEPS // STEPS_OF_AN_OUTPUT, 3, run.state.q.size))
    motion = (explicit.method[1], run.called, loads, run.state, h, STEPS_OF_AN_OUTPUT, history)

    def task(times: int, **changed: int) -> None:
        watch = run.watch.watch._replace(**changed)
        for _ in range(times):
            run.state.q[:], run.state.v[:] = initial
            run.start(0.0)
            inner.record_watched(*motion, watch)

    return {(name, WATCHED): task, (name, UNINSPECTED): partial(task, every=STEPS)}


def among_bodies(case: Row) -> Ways:
    """Steps of a run from mid-motion on; it is the same one for both, since each lies elsewhere in memory."""
    explicit = ExplicitSettings(case["integrator"], energyTolerance=math.inf)
    mbs, by_kernels = _build(case), ExitStack()  # for good: nobody else asks this mbs
    scene = inner.read_scene(mbs)
    by_kernels.enter_context(inner.switched_off(mbs, *scene.evaluated_by_kernels))
    (run,) = inner.runs_of_scene(mbs, scene, 0.0, 0.0, explicit)
    h, _ = inner.largest_step(inner.step_bounds([run], 0.0, explicit), explicit.stepSafety)
    grid = inner.TimeGrid(0.0, STEPS_AMONG_BODIES // STEPS_OF_AN_OUTPUT, STEPS_OF_AN_OUTPUT, h)
    history = np.zeros((grid.loop_steps, 3, len(run.indices)))
    run.start(0.0)
    run.record(grid, 0, history)
    in_motion = run.state.q.copy(), run.state.v.copy()

    def take(times: int, watch: Any = run.watch, kept: Any = by_kernels) -> None:
        run.watch = watch
        for _ in range(times):
            run.state.q[:], run.state.v[:] = in_motion
            run.start(0.0)
            run.record(grid, 0, history)

    name, blind = case["integrator"], partial(take, watch=_blind(run.watch))
    return {(name, WATCHED): take, (name, UNINSPECTED): blind}


def _blind(watch: Any) -> Any:
    """Opens like that watch, but remembers and judges nothing."""
    return SimpleNamespace(
        open=watch.open,
        may_shorten=False,
        is_slow=False,
        gain=0.0,
        path_of_evaluations=None,
        path=watch.path,
        before=watch.before,
        has_one_evaluation=True,
        after_each_step=(),
        stretches=watch.stretches,
        steps_ahead=inner.STEPS_BETWEEN,
        look=lambda state: None,
        begin_steps=lambda h: None,
        count=lambda steps: None,
        is_well_at=lambda t, h, state, at_once=False: True,
    )


def _build(case: Row) -> Any:
    """A cable that is pinned at its start and let fall."""
    kind = case["scene"]
    look = {"damping": DAMPING if kind == "damped" else 0.0, "pinned": kind != "moved"}
    look |= {"bodies": int(kind == "joined"), "also": _ADDITIONS.get(kind)}
    return joined_scene(Contents(elements=case["elements"], dimension=case["dimension"], length=1.0, **look))


def _push(mbs: Any, cable: dict[str, Any], dim: int) -> None:
    def force(mbs: Any, t: float, load: list[float]) -> list[float]:
        return [0.0, 0.1 * math.sin(6.0 * t), 0.0]

    marker = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    mbs.AddLoad(items.Force(markerNumber=marker, loadVectorUserFunction=force))


def _move(mbs: Any, cable: dict[str, Any], dim: int) -> None:
    way = lambda t: [0.0, 0.05 * (1.0 - math.cos(3.0 * t)), 0.0][:dim]  # noqa: E731
    CreatePrescribedMotion(mbs, cable["nodes"][0], way)


def _stand_beside(mbs: Any, cable: dict[str, Any], dim: int) -> None:
    mass = mbs.CreateMassPoint(referencePosition=[1.5, 0.0, 0.0], mass=0.1, gravity=GRAVITY)
    ground = mbs.CreateGround(referencePosition=[2.0, 0.0, 0.0])
    mbs.CreateSpringDamper(itemNumbers=[mass, ground], stiffness=10.0, damping=0.1)


_ADDITIONS = {"loaded": _push, "moved": _move, "beside": _stand_beside}
