"""The spatial pendulum inside Exudyn: inextensible and native cables against the independent limit."""

import dataclasses

import numpy as np
import pytest

from exudyn_inext import ExplicitSettings
from reference_models.conventional.cases import native_case
from reference_models.conventional.model import build as build_native
from reference_models.conventional.settings import Implicit
from reference_models.conventional.zhai import zhai_case
from reference_models.data import reference_trajectory
from reference_models.inextensible import Inextensible, build, inextensible_case
from reference_models.scenes import load_scene

SCENE = load_scene("spatial_pendulum")
REFERENCE = reference_trajectory(SCENE).positions


def largest_error(case):
    """Largest tip distance to the reference at its samples [m]."""
    positions = case.prepare()().positions
    return np.linalg.norm(positions - REFERENCE[: len(positions)], axis=1).max()


def inextensible(integrator, elements, step_size, **settings):
    return inextensible_case(
        SCENE, Inextensible(elements, ExplicitSettings(integrator, stepSize=step_size, **settings))
    )


@pytest.mark.parametrize(
    ("elements", "step_size", "bound"), [(5, 1e-3, 3.5e-3), (10, 6e-4, 9e-4)], ids=["N=5", "N=10"]
)
def test_zhai_with_the_rate_of_the_paper_is_within_millimetres_of_the_limit(elements, step_size, bound):
    case = inextensible("Zhai", elements, step_size, stabilizationRate=1000.0)
    assert case.step_size == pytest.approx(step_size, rel=0.03)
    assert largest_error(case) <= bound


def test_rattle_with_scaled_mass_is_as_accurate_at_four_times_the_step():
    assert largest_error(inextensible("RATTLE", 8, 2.5e-3, massScaling=0.25)) <= 9e-4


def test_native_cables_at_the_setting_of_the_paper_have_their_known_error():
    implicit = native_case(SCENE, 10, Implicit(2e-3, linear_solver="sparse"))
    assert largest_error(implicit) == pytest.approx(2.7e-3, rel=0.05)


def test_explicit_zhai_moves_native_cables_in_space_too():
    short = dataclasses.replace(SCENE, end_time=0.3)
    assert largest_error(zhai_case(short, 8, 2.5e-5)) < 1e-3


@pytest.mark.parametrize("build_model", [build, build_native], ids=["inextensible", "native"])
def test_initial_velocity_of_the_nodes_grows_linearly_to_three_metres_per_second(build_model):
    model = build_model(SCENE, 4)
    velocities = np.array([model.mbs.GetNodeParameter(node, "initialVelocities") for node in model.nodes])
    expected = np.zeros((5, 6))
    expected[:, 1] = np.linspace(0.0, 3.0, 5)
    expected[:, 4] = 3.0 / 1.8
    np.testing.assert_allclose(velocities, expected, atol=1e-12)
