"""What the benchmarks of steps time: native evaluations, steps of a chain, and states to start from."""

from collections.abc import Callable
from typing import Any

import exudyn

from exudyn_inext import ExplicitSettings, ExplicitStepper
from exudyn_inext.exudyn_binding.cable_loads import CableLoads
from exudyn_inext.exudyn_binding.scene import read_scene
from reference_models.conventional.model import Quadrature
from reference_models.conventional.model import build as build_native
from reference_models.inextensible import build
from reference_models.model import quiet_settings, silence
from reference_models.scenes import Scene, load_scene

from .interleaved import Task

SCENES = {2: "planar_pendulum", 3: "spatial_pendulum"}


def scene_of(dim: int) -> Scene:
    """The pendulum in that space dimension."""
    return load_scene(SCENES[dim])


def native_task(dim: int, elements: int, quadrature: Quadrature) -> Task:
    """C++ calls of ComputeODE2RHS in a tight loop."""
    model = build_native(scene_of(dim), elements, quadrature)
    solver = exudyn.MainSolverImplicitSecondOrder()
    with silence():
        solver.InitializeSolver(model.mbs, quiet_settings(1.0, 1000))

    def task(times: int, model: Any = model, compute: Callable[[Any], None] = solver.ComputeODE2RHS) -> None:
        mbs = model.mbs
        for _ in range(times):
            compute(mbs)

    return task


def empty_task(times: int) -> None:
    for _ in range(times):
        pass


def steps_task(dim: int, elements: int, integrator: str, name: str) -> tuple[Task, float]:
    """Steps from the start of the motion; and their size [s], half of the stability limit."""
    model = build(scene_of(dim), elements, name)
    settings = ExplicitSettings(integrator, massScaling=0.0)
    limit = ExplicitStepper(model.mbs, settings).bounds.stability_limit
    stepper = ExplicitStepper(model.mbs, settings, stepSize=0.5 * limit)

    def task(times: int) -> None:
        stepper.Start()
        stepper.Step(times)

    return task, stepper.stepSize


def moving_state(dim: int, elements: int, name: str, time: float = 0.1) -> tuple[Any, Any, Any, Any]:
    """Cable, external force, q and v after that time [s]."""
    model = build(scene_of(dim), elements, name)
    stepper = ExplicitStepper(model.mbs, interval=time, duration=time)
    stepper.Start()
    stepper.Step()
    q, v, _ = stepper.State()
    cable = read_scene(model.mbs).cables[0]
    return cable.cable, CableLoads(cable).constant, q.ravel().copy(), v.ravel().copy()
