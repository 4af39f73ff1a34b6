"""The paper's middle column: its explicit Zhai method on conventional cables."""

import time

import exudyn

from exudyn_inext import ExplicitSettings, SolveExplicit

from ..model import SENSOR_PERIOD, quiet_settings, sensor_trajectory, silence
from ..scenes import Scene
from ..trajectory import Case, Run, Trajectory
from .model import Quadrature, build
from .settings import number_of_steps
from .supports import spring_stiffness


def zhai_case(
    scene: Scene, elements: int, step_size: float, label: str = "", quadrature: Quadrature = "full"
) -> Case:
    """Explicit Zhai (psi = phi = 1/2, no corrector) on native cables; pins are exact, hangers springs."""

    def prepare() -> Run:
        model = build(scene, elements, quadrature, hanger_stiffness=spring_stiffness(scene))
        settings = quiet_settings(scene.end_time, round(scene.end_time / SENSOR_PERIOD))

        def run() -> Trajectory:
            with silence():
                SolveExplicit(model.mbs, settings, ExplicitSettings("Zhai", stepSize=step_size))
            return sensor_trajectory(model, scene.main_point)

        return run

    steps = number_of_steps(step_size, scene.end_time)
    return Case(
        label=label or _label(elements, step_size, quadrature),
        formulation="conventional",
        integrator="zhai",
        elements=elements,
        step_size=scene.end_time / steps,
        steps=steps,
        prepare=prepare,
        details={"quadrature": quadrature, "forceSeconds": force_seconds(scene, elements, quadrature)},
    )


def force_seconds(scene: Scene, elements: int, quadrature: Quadrature = "full", calls: int = 1000) -> float:
    """CPU time of one evaluation of all forces by Exudyn [s]: the part of a step that is not ours."""
    mbs = build(scene, elements, quadrature, hanger_stiffness=spring_stiffness(scene)).mbs
    solver = exudyn.MainSolverImplicitSecondOrder()
    with silence():
        solver.InitializeSolver(mbs, quiet_settings(1.0, calls))
    start = time.process_time()
    for _ in range(calls):
        solver.ComputeODE2RHS(mbs)
    return (time.process_time() - start) / calls


def largest_zhai_step(scene: Scene, elements: int, quadrature: Quadrature = "full") -> float:
    """Stability limit [s] in the initial state."""
    model = build(scene, elements, quadrature, hanger_stiffness=spring_stiffness(scene))
    with silence():
        report = SolveExplicit(model.mbs, quiet_settings(1e-4, 1, 1e-4), ExplicitSettings("Zhai"))
    return float(report["bounds"].stability_limit)


def _label(elements: int, step_size: float, quadrature: Quadrature) -> str:
    label = f"native Zhai, N = {elements}, h = {step_size:.3g} s"
    return label if quadrature == "full" else f"{label}, {quadrature} quadrature"
