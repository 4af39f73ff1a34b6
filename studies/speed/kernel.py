"""One step of an inextensible chain against one evaluation of native elements.

Question
    Is one full step (bending force, constraints, update) of an inextensible chain cheaper than one
    native ComputeODE2RHS of as many ANCF cable elements, of which any native step needs at least one?

What would refute it
    A ratio above 0.5 (2D, ANCFCable2D) or 0.6 (3D, ANCFCable) at N = 5, 20 or 50.

Protocol
    The pendulums of Tables 1 and 2. Steps: a compiled call of many steps (ExplicitStepper.Step) that
    always begins at the start of the motion, at half of the stability limit. Native: C++ calls in a
    Python loop, less the empty loop. All tasks of one chain are sampled round robin, CPU time,
    medians; ratios within one run. RATTLE corrects positions as often as its tolerance of 1e-10 asks for,
    which takes more solves at the larger steps of coarse chains.

What is left out
    Native elements with quadratures other than the default and Lobatto. Links, damping, natural curvature:
    `scene_cost`, `watch_cost`. What the parts of a step take: a profiler says it.
"""

from functools import lru_cache, partial
from typing import Any

import exudyn

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.conventional.model import Quadrature
from reference_models.conventional.model import build as build_native
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import load_scene
from studies.harness import Row
from studies.harness.timing import Task, steps_task

BARS = {2: 0.5, 3: 0.6}
SCENES = {2: "planar_pendulum", 3: "spatial_pendulum"}
MEASURES = ("secondDerivative", "product")
QUADRATURES: tuple[Quadrature, ...] = ("full", "lobatto")
EMPTY = "empty loop"
MICRO = 1e6


def tasks(case: Row) -> dict[Any, Task]:
    """Native evaluations, and steps of half of the stability limit."""
    model = build(load_scene(SCENES[case["dimension"]]), case["elements"], case["curvatureMeasure"])
    settings = ExplicitSettings(case["integrator"], massScaling=0.0)
    limit = ExplicitStepper(model.mbs, settings).bounds.stability_limit
    own = steps_task(ExplicitStepper(model.mbs, settings, stepSize=0.5 * limit))
    key = case["integrator"], case["curvatureMeasure"]
    return native_tasks(case["dimension"], case["elements"]) | {key: own}


@lru_cache(1)
def native_tasks(dim: int, elements: int) -> dict[Any, Task]:
    """Quadrature -> C++ calls of ComputeODE2RHS in a tight loop; and that loop, empty."""

    def task(times: int, model: Model, solver: Any) -> None:
        mbs, compute = model.mbs, solver.ComputeODE2RHS
        for _ in range(times):
            compute(mbs)

    def empty(times: int) -> None:
        for _ in range(times):
            pass

    found: dict[Any, Task] = {EMPTY: empty}
    for quadrature in QUADRATURES:
        model = build_native(load_scene(SCENES[dim]), elements, quadrature)
        solver = exudyn.MainSolverImplicitSecondOrder()
        with silence():
            solver.InitializeSolver(model.mbs, quiet_settings(1.0, 1000))
        found[quadrature] = partial(task, model=model, solver=solver)
    return found


def row(case: Row, found: Any) -> Row:
    """Ratios to the native evaluations."""
    step = found[case["integrator"], case["curvatureMeasure"]].median
    full, lobatto = (found[quadrature].median - found[EMPTY].median for quadrature in QUADRATURES)
    return case | {
        "label": f"{case['dimension']}D, {case['integrator']}, one step",
        "microseconds": MICRO * step,
        "nativeMicroseconds": MICRO * full,
        "ratio": step / full,
        "ratioLobatto": step / lobatto,
        "bar": BARS[case["dimension"]],
    }
