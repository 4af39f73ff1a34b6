"""What is timed of single steps: native evaluations, steps of a chain, their parts, the processor."""

from functools import partial
from typing import Any

import exudyn
import numpy as np

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.conventional.model import Quadrature
from reference_models.conventional.model import build as build_native
from reference_models.inextensible import build
from reference_models.model import Model, quiet_settings, silence
from reference_models.scenes import load_scene
from reference_models.trajectory import Array

from . import inner
from .inner import Cable, assemble, factorise, index_reduced_rates, kernel, leave_targets, solve_both_columns
from .timing import Task

SCENES = {2: "planar_pendulum", 3: "spatial_pendulum"}
QUADRATURES: tuple[Quadrature, ...] = ("full", "lobatto")
EMPTY = "empty loop"
ZETA = 100.0


def native_tasks(dim: int, elements: int) -> dict[str, Task]:
    """Quadrature -> C++ calls of ComputeODE2RHS in a tight loop; and that loop, empty."""

    def task(times: int, model: Model, solver: Any) -> None:
        mbs, compute = model.mbs, solver.ComputeODE2RHS
        for _ in range(times):
            compute(mbs)

    def empty(times: int) -> None:
        for _ in range(times):
            pass

    tasks: dict[str, Task] = {EMPTY: empty}
    for quadrature in QUADRATURES:
        model = build_native(load_scene(SCENES[dim]), elements, quadrature)
        solver = exudyn.MainSolverImplicitSecondOrder()
        with silence():
            solver.InitializeSolver(model.mbs, quiet_settings(1.0, 1000))
        tasks[quadrature] = partial(task, model=model, solver=solver)
    return tasks


def steps_task(dim: int, elements: int, integrator: str, name: str) -> tuple[Task, float]:
    """Steps from the start of the motion; and their size [s], half of the stability limit."""
    model = build(load_scene(SCENES[dim]), elements, name)
    settings = ExplicitSettings(integrator, massScaling=0.0)
    limit = ExplicitStepper(model.mbs, settings).bounds.stability_limit
    stepper = ExplicitStepper(model.mbs, settings, stepSize=0.5 * limit)

    def task(times: int) -> None:
        stepper.Start()
        stepper.Step(times)

    return task, stepper.stepSize


def moving_state(dim: int, elements: int, name: str, time: float = 0.1) -> tuple[Any, Any, Any, Any]:
    """Cable, external force, q and v after that time [s]."""
    model = build(load_scene(SCENES[dim]), elements, name)
    stepper = ExplicitStepper(model.mbs, interval=time, duration=time)
    stepper.Start()
    stepper.Step()
    q, v, _ = stepper.State()
    cable = inner.read_scene(model.mbs).cables[0]
    return cable.cable, inner.CableLoads(cable).constant, q.ravel().copy(), v.ravel().copy()


# ------------------------------------------------- parts of one evaluation of Eq. (30), each repeated


@kernel
def _rates(times, system, external, q, v, acceleration, rate):
    for _ in range(times):
        index_reduced_rates(system, external, q, v, acceleration, rate)


@kernel
def _assembly(times, chain, external, q, v):
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    for _ in range(times):
        assemble(axes, nodes, elements, external, q, v, 0, leave_targets, 0.0)


@kernel
def _factorisation(times, chain):
    for _ in range(times):
        factorise(chain.axes, chain.nodes, chain.elements)


@kernel
def _substitution(times, chain, x, y):
    axes, nodes, elements = chain.axes, chain.nodes, chain.elements
    for _ in range(times):
        solve_both_columns(axes, nodes, elements, x, y)


def rates_task(cable: Cable, external: Array, q: Array, v: Array) -> Task:
    """index_reduced_rates alone.   external, q, v: (n_dof,)."""
    system = inner.cable_system(cable, ZETA)
    a, rate = np.zeros(q.size), np.zeros(q.size)
    return lambda times: _rates(times, system, external, q, v, a, rate)


def part_tasks(cable: Cable, external: Array, q: Array, v: Array) -> dict[str, Task]:
    """Name of a part -> task; of a chain without links.   external, q, v: (n_dof,)."""
    system = inner.cable_system(cable, ZETA)
    chain = system.chain
    force, known, rates = (array.reshape(chain.shape) for array in (external, q, v))
    x, y = np.zeros(chain.shape), np.zeros(chain.shape)
    index_reduced_rates(system, external, q, v, x.ravel(), y.ravel())
    return {
        "assembly": lambda times: _assembly(times, chain, force, known, rates),
        "factorisation": lambda times: _factorisation(times, chain),
        "substitution": lambda times: _substitution(times, chain, x, y),
    }


# -------------------------------------- multiply-adds of the processor in one thread, alone and in vectors


@kernel
def scalar_multiply_adds(times, x, y):
    """12 independent chains of multiply-adds, `times` long: enough to fill the pipelines."""
    a, b, c, d, e, f = y, y + 1.0, y + 2.0, y + 3.0, y + 4.0, y + 5.0
    g, h, i, j, k, m = y + 6.0, y + 7.0, y + 8.0, y + 9.0, y + 10.0, y + 11.0
    for _ in range(times):
        a, b, c, d = a * x + y, b * x + y, c * x + y, d * x + y
        e, f, g, h = e * x + y, f * x + y, g * x + y, h * x + y
        i, j, k, m = i * x + y, j * x + y, k * x + y, m * x + y
    return a + b + c + d + e + f + g + h + i + j + k + m


@kernel
def vector_multiply_adds(times, x, y):
    """`times` times 8 multiply-adds on each of 64 numbers in the nearest cache."""
    z = inner.local_array(64, 1)
    for n in range(64):
        z[n, 0] = y + n
    for _ in range(times):
        for n in range(64):
            value = z[n, 0]
            for _ in range(8):
                value = value * x + y
            z[n, 0] = value
    total = 0.0
    for n in range(64):
        total += z[n, 0]
    return total


PROCESSOR_TASKS: dict[str, Task] = {
    "scalar multiply-adds": lambda times: scalar_multiply_adds(1000 * times, 0.999, 1e-3),
    "vector multiply-adds": lambda times: vector_multiply_adds(100 * times, 0.999, 1e-3),
}
MULTIPLY_ADDS = {"scalar multiply-adds": 1000 * 12, "vector multiply-adds": 100 * 64 * 8}
