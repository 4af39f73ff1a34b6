"""The paper's middle column: its explicit Zhai method on conventional cables."""

from exudyn_inext import ExplicitSettings, SolveExplicit

from ..scenes import Scene
from ..trajectory import Case, Run, Trajectory
from .model import build
from .settings import SENSOR_PERIOD, Explicit, number_of_steps, simulation_settings
from .solve import sensor_trajectory, silence


def zhai_case(scene: Scene, elements: int, step_size: float, label: str = "") -> Case:
    """Explicit Zhai (psi = phi = 1/2, no corrector) on native cables; pins are exact."""

    def prepare() -> Run:
        model = build(scene, elements)
        settings = simulation_settings(Explicit(SENSOR_PERIOD), scene.end_time)

        def run() -> Trajectory:
            with silence():
                SolveExplicit(model.mbs, settings, ExplicitSettings(stepSize=step_size))
            return sensor_trajectory(model, scene.main_point)

        return run

    steps = number_of_steps(step_size, scene.end_time)
    return Case(
        label=label or f"native Zhai, N = {elements}, h = {step_size:.3g} s",
        formulation="conventional",
        integrator="zhai",
        elements=elements,
        step_size=scene.end_time / steps,
        steps=steps,
        prepare=prepare,
    )
