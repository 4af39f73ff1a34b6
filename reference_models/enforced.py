"""A scene as an inextensible cable, moved by Exudyn's own integrators."""

from functools import partial

from .conventional.settings import Solver, number_of_steps
from .conventional.solve import solve
from .inextensible import Inextensible, build_variant
from .scenes import Scene
from .trajectory import Case, Run


def enforced_case(scene: Scene, elements: int, enforcement: str, solver: Solver) -> Case:
    """One row of a comparison.   enforcement: "penaltyMass" (explicit) or "algebraic" (implicit)."""

    def prepare() -> Run:
        return partial(solve, build_variant(scene, Inextensible(elements, enforcement=enforcement)), solver)

    steps = number_of_steps(solver.step_size, scene.end_time)
    way = f"inextensible {enforcement}, native {solver.integrator}"
    return Case(
        label=f"{way}, N = {elements}, h = {solver.step_size:.3g} s",
        formulation="inextensible",
        integrator=solver.integrator,
        elements=elements,
        step_size=scene.end_time / steps,
        steps=steps,
        prepare=prepare,
        details={"enforcement": enforcement},
    )
