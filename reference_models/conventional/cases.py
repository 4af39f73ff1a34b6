"""Rows of a comparison: native cables with an implicit or explicit native integrator."""

import time
from dataclasses import replace
from functools import partial
from typing import get_args

from ..scenes import Scene
from ..trajectory import Case, Run
from .model import Quadrature, build, build_for_explicit
from .settings import Explicit, ExplicitIntegrator, Implicit, LinearSolver, Solver, number_of_steps
from .solve import solve
from .stability import largest_stable_step
from .supports import spring_stiffness

_TRIED = 2000  # steps of the runs that choose a linear solver


def native_case(
    scene: Scene, elements: int, solver: Solver, quadrature: Quadrature = "full", label: str = ""
) -> Case:
    """A native run; supports are constraints for implicit integrators and springs for explicit ones."""
    build_model = build_for_explicit if isinstance(solver, Explicit) else build
    halved = replace(solver, step_size=0.5 * solver.step_size)

    def prepare() -> Run:
        return partial(solve, build_model(scene, elements, quadrature), solver)

    steps = number_of_steps(solver.step_size, scene.end_time)
    return Case(
        label=label or native_label(elements, solver, quadrature),
        formulation="conventional",
        integrator=solver.integrator,
        elements=elements,
        step_size=scene.end_time / steps,
        steps=steps,
        prepare=prepare,
        details={"quadrature": quadrature, **_details(solver, scene)},
        halved=lambda: native_case(scene, elements, halved, quadrature),
    )


def largest_step_case(
    scene: Scene, elements: int, integrator: ExplicitIntegrator, quadrature: Quadrature = "full"
) -> Case:
    """A native explicit run at its largest stable step, with the quicker linear solver.

    Both are found here, once.
    """
    step_size = largest_stable_step(scene, elements, integrator, quadrature)

    def seconds(solver: Explicit) -> float:
        model, start = build_for_explicit(scene, elements, quadrature), time.process_time()
        solve(model, solver, _TRIED * step_size)
        return time.process_time() - start

    solvers = [Explicit(step_size, integrator, linear) for linear in get_args(LinearSolver)]
    best = min(solvers, key=lambda solver: min(seconds(solver) for _ in range(3)))
    return native_case(scene, elements, best, quadrature)


def native_label(elements: int, solver: Solver, quadrature: Quadrature) -> str:
    """Says all that distinguishes one native row from another."""
    parts = [f"native {solver.integrator}, N = {elements}, h = {solver.step_size:.3g} s"]
    if isinstance(solver, Implicit):
        parts += [f"{solver.newton} Newton {solver.relative_tolerance:.0e}", solver.linear_solver]
        if solver.spectral_radius != Implicit.spectral_radius:
            parts.append(f"rho_inf = {solver.spectral_radius:g}")
    elif solver.linear_solver != Explicit.linear_solver:
        parts.append(solver.linear_solver)
    if quadrature != "full":
        parts.append(f"{quadrature} quadrature")
    return ", ".join(parts)


def _details(solver: Solver, scene: Scene) -> dict[str, object]:
    if isinstance(solver, Explicit):
        return {"pinStiffness": spring_stiffness(scene), "linearSolver": solver.linear_solver}
    return {
        "newton": solver.newton,
        "linearSolver": solver.linear_solver,
        "relativeTolerance": solver.relative_tolerance,
        "spectralRadius": solver.spectral_radius,
    }
