"""A scene's cable moved by compiled steps alone: what Exudyn's loop, set-up and sensors add can be seen."""

import math

import numpy as np

from exudyn_inext import ExplicitSettings
from exudyn_inext.exudyn_binding.explicit_runs import cable_runs, scheme_of
from exudyn_inext.exudyn_binding.scene import read_scene
from exudyn_inext.exudyn_binding.time_grid import TimeGrid
from reference_models.inextensible import build
from reference_models.model import SENSOR_PERIOD, node_index
from reference_models.scenes import Scene
from reference_models.trajectory import Case, Run, Trajectory, Untimed

FORMULATION = "compiled steps"


def compiled_case(
    scene: Scene,
    integrator: str,
    elements: int,
    step_size: float,
    mass_scaling: float,
    zeta: float = ExplicitSettings.stabilizationRate,
) -> Case:
    """One compiled call, started from an evaluation of the initial state; states are kept at 100 Hz.

    step_size: divides the sensors' period [s].   zeta: stabilisation rate of Zhai [1/s].
    """
    substeps = round(SENSOR_PERIOD / step_size)
    h, samples = SENSOR_PERIOD / substeps, round(scene.end_time / SENSOR_PERIOD)
    settings = ExplicitSettings(
        integrator, stepSize=h, massScaling=mass_scaling, stabilizationRate=zeta, energyTolerance=math.inf
    )
    grid = TimeGrid(0.0, samples, substeps, h)

    def prepare() -> Run:
        mbs = build(scene, elements).mbs
        (cable,) = cable_runs(mbs, read_scene(mbs).cables, 0.0, h, settings)
        node = node_index(scene.observe[scene.main_point], elements)

        def run() -> Untimed:
            start = cable.state.q.copy()
            cable.start(0.0)
            history = np.empty((samples, 3, len(cable.indices)))
            good = cable.record(scheme_of(settings), grid, 0, history)

            def trajectory() -> Trajectory:
                states = np.concatenate([start[None], history[:good, 0] + cable.reference])
                tip = states.reshape(len(states), *cable.scene_cable.cable.reference.shape)[:, node, 0]
                positions = np.zeros((len(tip), 3))
                positions[:, : tip.shape[1]] = tip
                return Trajectory(SENSOR_PERIOD * np.arange(len(tip)), positions)

            return trajectory

        return run

    return Case(
        label=f"compiled steps: {integrator}, N = {elements}, h = {h:.3g} s, mass scaling {mass_scaling:g}",
        formulation=FORMULATION,
        integrator=integrator,
        elements=elements,
        step_size=h,
        steps=substeps * samples,
        prepare=prepare,
        details={"zeta": zeta, "massScaling": mass_scaling},
    )
