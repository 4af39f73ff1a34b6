"""The parameter variation: periods of slender cantilevers, from Exudyn's ParameterVariation."""

import numpy as np
import pytest
from exudyn.processing import ParameterVariation

from examples import parameter_variation as example
from reference_models.model import silence

FIRST_ROOT = 1.8751040687  # of cos x cosh x = -1


def test_periods_are_those_of_slender_cantilevers():
    varied = {"bendingStiffness": example.STIFFNESSES}
    with silence():
        parameters, found = ParameterVariation(example.simulate, varied, showProgress=False)
    assert list(parameters["bendingStiffness"]) == example.STIFFNESSES
    density_over_stiffness = example.DENSITY / np.array(example.STIFFNESSES)
    exact = 2 * np.pi * (example.LENGTH / FIRST_ROOT) ** 2 * np.sqrt(density_over_stiffness)
    assert [period for period, *_ in found] == pytest.approx(exact, rel=5e-3)
