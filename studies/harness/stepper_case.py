"""A scene moved by an ExplicitStepper, without Exudyn's time loop."""

import numpy as np

from exudyn_inext import ExplicitSettings, ExplicitStepper
from reference_models.inextensible import build
from reference_models.model import SENSOR_PERIOD
from reference_models.scenes import Scene
from reference_models.trajectory import Case, Run, Trajectory


def stepper_case(scene: Scene, elements: int, settings: ExplicitSettings) -> Case:
    """The main point at 100 Hz; timed are start and steps.   settings: its step divides the period."""
    h = float(settings.stepSize or SENSOR_PERIOD)
    steps = round(SENSOR_PERIOD / h)
    samples = round(scene.end_time / SENSOR_PERIOD)
    node = round(scene.observe[scene.main_point] * elements)

    def prepare() -> Run:
        model = build(scene, elements)
        stepper = ExplicitStepper(model.mbs, settings)
        q, _, _ = stepper.State()
        positions = np.zeros((samples + 1, 3))

        def run() -> Trajectory:
            stepper.Start()
            for sample in range(samples + 1):
                if sample:
                    stepper.Step(steps)
                positions[sample, : q.shape[2]] = q[node, 0]
            return Trajectory(SENSOR_PERIOD * np.arange(samples + 1), positions)

        return run

    return Case(
        label=f"{settings.integrator}, N = {elements}",
        formulation="inextensible",
        integrator=settings.integrator,
        elements=elements,
        step_size=h,
        steps=steps * samples,
        prepare=prepare,
        details={"massScaling": settings.massScaling},
    )
