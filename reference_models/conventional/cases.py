"""Rows of a comparison: native cables with an implicit or explicit native integrator."""

from functools import partial

from ..scenes import Scene
from ..trajectory import Case, Run
from .model import Quadrature, build, build_for_explicit
from .settings import Explicit, ExplicitIntegrator, Implicit, Solver, number_of_steps
from .solve import solve
from .stability import largest_stable_step
from .supports import spring_stiffness


def native_case(
    scene: Scene, elements: int, solver: Solver, quadrature: Quadrature = "full", label: str = ""
) -> Case:
    """A native run; supports are constraints for implicit integrators and springs for explicit ones."""
    build_model = build_for_explicit if isinstance(solver, Explicit) else build

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
    )


def largest_step_case(
    scene: Scene, elements: int, integrator: ExplicitIntegrator, quadrature: Quadrature = "full"
) -> Case:
    """A native explicit run at its largest stable step, which is searched here, once, untimed."""
    step_size = largest_stable_step(scene, elements, integrator, quadrature)
    return native_case(scene, elements, Explicit(step_size, integrator), quadrature)


def native_label(elements: int, solver: Solver, quadrature: Quadrature) -> str:
    """Says all that distinguishes one native row from another."""
    parts = [f"native {solver.integrator}, N = {elements}, h = {solver.step_size:.3g} s"]
    if isinstance(solver, Implicit):
        parts += [f"{solver.newton} Newton {solver.relative_tolerance:.0e}", solver.linear_solver]
        if solver.spectral_radius != Implicit.spectral_radius:
            parts.append(f"rho_inf = {solver.spectral_radius:g}")
    if quadrature != "full":
        parts.append(f"{quadrature} quadrature")
    return ", ".join(parts)


def _details(solver: Solver, scene: Scene) -> dict[str, object]:
    if isinstance(solver, Explicit):
        return {"pinStiffness": spring_stiffness(scene)}
    return {
        "newton": solver.newton,
        "linearSolver": solver.linear_solver,
        "relativeTolerance": solver.relative_tolerance,
        "spectralRadius": solver.spectral_radius,
    }
