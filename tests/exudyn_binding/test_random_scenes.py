"""Random scenes at default settings move as their native twins with finer meshes and implicit steps."""

import exudyn
import numpy as np
import pytest

from exudyn_inext import SolveExplicit
from reference_models.model import quiet_settings, silence
from tests.random_scenes import PERIOD, RandomScene

END, LOOP_STEPS = 0.4, 200  # [s]; pre-step functions are called as often
SEEDS = (0, 1, 2, 4, 6, 14, 16, 23, 24, 27)  # of which natives converge within a second
PULLED_STRAIGHT = 6008  # by a drive: energy jumps there, and steps are taken again


def native_paths(seed):
    scene = RandomScene(seed, native=True, elements=16)
    settings = quiet_settings(END, 2 * LOOP_STEPS, PERIOD)
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    with silence():
        scene.mbs.SolveDynamic(settings)
    return scene.paths()


@pytest.mark.filterwarnings("ignore:.*vibrates along its axis")  # once pulled straight, which is true
@pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")  # as those of its twin do
@pytest.mark.parametrize(("seed", "stretches"), [*((seed, False) for seed in SEEDS), (PULLED_STRAIGHT, True)])
def test_it_moves_as_its_native_twin(seed, stretches):
    scene, expected = RandomScene(seed, stretches=stretches), native_paths(seed)
    with silence():
        SolveExplicit(scene.mbs, quiet_settings(END, LOOP_STEPS, PERIOD))
    distances = np.linalg.norm(scene.paths() - expected, axis=2)
    size = np.linalg.norm(expected - expected[0], axis=2).max()
    assert np.sqrt((distances**2).mean()) < 0.01 * size
