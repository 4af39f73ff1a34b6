"""Compiled steps alone give the motion that SolveExplicit gives."""

import math
from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext import ExplicitSettings
from reference_models.inextensible import Inextensible, inextensible_case
from reference_models.scenes import load_scene
from studies.harness.cases import compiled_case
from studies.harness.reference import from_data
from studies.harness.timing import measure


@pytest.mark.parametrize(
    ("name", "integrator"), [("planar_pendulum", "Zhai"), ("spatial_pendulum", "RATTLE")]
)
def test_the_motion_is_that_of_a_run_inside_exudyn(name, integrator):
    scene = replace(load_scene(name), end_time=0.3)
    settings = ExplicitSettings(integrator, stepSize=5e-3, massScaling=0.3, energyTolerance=math.inf)
    cases = [
        compiled_case(scene, integrator, 4, 5e-3, 0.3),
        inextensible_case(scene, Inextensible(4, settings)),
    ]
    (alone, own), (inside, other) = measure(cases, 1, from_data(scene).trajectory)
    assert alone["status"] == inside["status"] == "ok" and alone["steps"] == inside["steps"] == 60
    np.testing.assert_allclose(own.times, other.times, atol=1e-12)
    np.testing.assert_array_equal(own.positions, other.positions)
