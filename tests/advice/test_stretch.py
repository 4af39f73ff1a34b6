"""What stretch moves is estimated within a factor of known answers."""

import numpy as np
import pytest

from exudyn_inext.advice.stretch import Tension, stretch_error

LENGTH, RHO, G = 2.0, 0.3, 9.81


def tension(force):
    return Tension(rms=force, largest=force, length=LENGTH)


def swing(length, amplitude, times):
    """(T, 2) of a pendulum with w = sqrt(g / length), small angles."""
    angle = amplitude * np.cos(np.sqrt(G / length) * times)
    return length * np.column_stack([np.sin(angle), -np.cos(angle)])


@pytest.mark.parametrize("periods", [0.5, 3.0, 30.0, 300.0])
@pytest.mark.parametrize("amplitude", [0.02, 0.2])
@pytest.mark.parametrize("strain", [1e-5, 1e-4])
def test_a_pendulum_that_is_longer_and_slower(periods, amplitude, strain):
    end = periods * 2.0 * np.pi * np.sqrt(LENGTH / G)
    times = np.linspace(0.0, end, max(400, int(100 * periods)))
    stiff, soft = (swing(length, amplitude, times) for length in (LENGTH, LENGTH * (1.0 + strain)))
    measured = np.linalg.norm(stiff - soft, axis=1).max()
    estimate = stretch_error(tension(50.0), 50.0 / strain, stiff)
    assert 0.5 * measured < estimate < 2.0 * measured


def test_a_cable_that_hangs_in_its_own_weight_and_one_with_a_weight_at_its_end():
    """rho_A g L^2 / (2 EA) and m g L / EA: the estimate takes the largest tension everywhere."""
    at_rest = np.zeros((10, 3))
    stiffness, weight = 1e4, RHO * G * LENGTH
    own = stretch_error(tension(weight), stiffness, at_rest)
    assert own == pytest.approx(2.0 * (0.5 * weight * LENGTH / stiffness))
    heavy = stretch_error(tension(70.0), stiffness, at_rest)
    assert heavy == pytest.approx(70.0 * LENGTH / stiffness)
