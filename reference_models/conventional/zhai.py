"""The paper's middle column: its explicit Zhai method on conventional cables."""

from exudyn_inext import ExplicitSettings, SolveExplicit

from ..model import SENSOR_PERIOD, quiet_settings, sensor_trajectory, silence
from ..scenes import Scene
from ..trajectory import Case, Run, Trajectory
from .model import build
from .settings import number_of_steps


def zhai_case(scene: Scene, elements: int, step_size: float, label: str = "") -> Case:
    """Explicit Zhai (psi = phi = 1/2, no corrector) on native cables; pins are exact."""

    def prepare() -> Run:
        model = build(scene, elements)
        settings = quiet_settings(scene.end_time, round(scene.end_time / SENSOR_PERIOD))

        def run() -> Trajectory:
            with silence():
                SolveExplicit(model.mbs, settings, ExplicitSettings("Zhai", stepSize=step_size))
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
