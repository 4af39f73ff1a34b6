"""A string under pretension, pinned straight between two points: its axial stiffness gives the tension.

Transverse vibrations of a pinned beam under tension T have w^2 = (k pi / L)^2 (T + EI (k pi / L)^2) / rho_A,
axial ones w = k pi / L sqrt(EA / rho_A).
"""

import numpy as np
import pytest

from exudyn_inext.cable.cable import Cable, CurvatureMeasure, Section
from tests.known_answers.vibrations import natural_frequencies

LENGTH, DENSITY, BENDING, AXIAL, STRAIN = 1.8, 0.035, 2e-3, 4e3, 0.01


@pytest.fixture(scope="module", params=[2, 3])
def modes(request):
    """Frequencies and modes [rad/s, (m, n, 2, dim)] of 24 elements."""
    number, dim = 24, request.param
    q = np.zeros((number + 1, 2, dim))
    q[:, 0, 0], q[:, 1, 0] = np.linspace(0.0, LENGTH, number + 1), 1.0
    fixed = np.zeros((number + 1, 2), dtype=bool)
    fixed[[0, -1], 0] = True
    section = Section(DENSITY, BENDING, axial_stiffness=AXIAL, axial_strain=-STRAIN)
    lengths = np.full(number, LENGTH / number)
    return natural_frequencies(Cable(q, lengths, section, CurvatureMeasure.SECOND_DERIVATIVE, number, fixed))


def test_its_first_five_frequencies_are_those_of_a_beam_under_tension(modes):
    frequencies, shapes = modes
    across = np.abs(shapes[:, :, 0, 1]).max(axis=1) > 1e-6
    wave = np.arange(1, 6) * np.pi / LENGTH
    exact = wave * np.sqrt((AXIAL * STRAIN + BENDING * wave**2) / DENSITY)
    found = frequencies[across][:: shapes.shape[3] - 1][:5]  # in space each comes twice
    np.testing.assert_allclose(found, exact, rtol=1e-5)


def test_its_axial_waves_are_those_of_a_bar(modes):
    frequencies, shapes = modes
    along = np.abs(shapes[:, :, 0, 0]).max(axis=1) > 0.99 * np.abs(shapes[:, :, 0]).max(axis=(1, 2))
    exact = np.arange(1, 6) * np.pi / LENGTH * np.sqrt(AXIAL / DENSITY)
    np.testing.assert_allclose(frequencies[along][:5], exact, rtol=1e-3)
