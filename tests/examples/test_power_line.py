"""The power line: the data of the paper, balance at rest, and a refined solution."""

import exudyn as exu
import numpy as np
import pytest

from examples import power_line
from exudyn_inext import CableForces, SolveEquilibrium
from reference_models.inextensible import fine_solution
from reference_models.model import silence
from reference_models.scenes import load_scene
from tests.examples import scenes

NAME = "power_line"


def test_its_section_is_that_of_the_scene():
    scenes.require_section(power_line.LINE, NAME)


def test_at_rest_the_line_carries_the_ice_and_pulls_along_its_rod():
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    scene = power_line.build(mbs)
    mbs.Assemble()
    SolveEquilibrium(mbs)
    line, length = scene["cables"][0], power_line.LENGTH
    nodes = [state(mbs, line["nodes"][k]) for k in (0, 5, 5, 10, -1)]
    places = [0.0, length / 4, length / 4 + 1e-9, length / 2, length]
    forces = CableForces(mbs, line, places)
    slopes = np.array([slope for _, slope in nodes])
    first, before, after, _, last = forces["shearForce"] + forces["tension"][:, None] * slopes
    np.testing.assert_allclose(after - before, [0.0, 1.162], atol=1e-6)  # across the ice
    weight = np.array([0.0, power_line.LINE.massPerLength * length * 9.81 + 1.162])
    on_rod = weight - last + first  # what the ends do not carry
    along = nodes[3][0] - [power_line.SPAN, power_line.ROD]
    assert np.linalg.det([on_rod, along]) == pytest.approx(0.0, abs=1e-6)
    assert on_rod[1] > 0.4 * weight[1]


def state(mbs, node):
    """Position (2,) [m] and slope (2,) [-] of a node."""
    return np.reshape(mbs.GetNodeOutput(node, exu.OutputVariableType.CoordinatesTotal), (2, 2))


def test_it_swings_as_the_refined_solution_and_stays_on_its_rod():
    times, points = scenes.run(power_line)
    scene = load_scene(NAME)
    with silence():
        fine = fine_solution(scene, 40)
    np.testing.assert_allclose(fine.times, times, atol=1e-9)
    error = np.linalg.norm(points[:, power_line.ELEMENTS // 4] - fine.positions, axis=1)
    assert error.max() < 2e-3
    rod = np.linalg.norm(points[:, 10, :2] - [power_line.SPAN, power_line.ROD], axis=1)
    np.testing.assert_allclose(rod, power_line.ROD, atol=1e-9)
