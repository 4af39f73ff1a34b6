"""What each choice of the parameters of the Zhai scheme does to an oscillator and to a decay."""

import numpy as np
import pytest

from exudyn_inext.integrators.integrator import LoadHistory, no_loads, record
from exudyn_inext.integrators.linear_stability import (
    LinearSystem,
    amplification_matrix,
    decay_limit,
    frequency_limit,
)
from exudyn_inext.integrators.zhai import INTEGRATOR, Zhai

PLAIN = Zhai()
DAMPED = Zhai(psi=0.0, phi=0.0, corrector=True)
CORRECTED = Zhai(corrector=True)


def by_hand(scheme, x):
    """(3, 3) step matrix on (q, v h, a_previous h^2) of the oscillator with h w = x, Eqs. (31)-(34)."""
    q, v, a_previous = np.eye(3)
    a = -(x**2) * q
    q_p = q + v + (0.5 + scheme.psi) * a - scheme.psi * a_previous
    v_p = v + (1.0 + scheme.phi) * a - scheme.phi * a_previous
    if scheme.corrector:
        gamma = scheme.gamma_newmark
        beta = 0.25 * (0.5 + gamma) ** 2
        a_p = -(x**2) * q_p
        q_p = q + v + (0.5 - beta) * a + beta * a_p
        v_p = v + (1.0 - gamma) * a + gamma * a_p
    return np.array([q_p, v_p, a])


def spectral_radius(matrix):
    return np.abs(np.linalg.eigvals(matrix)).max()


SCHEMES = [PLAIN, DAMPED, CORRECTED, Zhai(0.2, 0.7), Zhai(0.3, 0.1, True, 0.6)]


@pytest.mark.kernel
@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
@pytest.mark.parametrize("x", [0.1, 1.0, 1.9])
def test_one_step_is_the_formula_of_the_paper(scheme, x):
    step = amplification_matrix(INTEGRATOR, scheme, LinearSystem(x * x, 0.0))
    np.testing.assert_allclose(step, by_hand(scheme, x), atol=1e-13)


def test_plain_scheme_is_stable_up_to_two_over_the_frequency():
    assert frequency_limit(INTEGRATOR, PLAIN) == pytest.approx(2.0, abs=1e-3)
    assert spectral_radius(by_hand(PLAIN, 1.999)) == pytest.approx(1.0, abs=1e-12)
    assert spectral_radius(by_hand(PLAIN, 2.001)) > 1.0 + 1e-3


def test_plain_scheme_is_stable_up_to_one_over_the_stabilisation_rate():
    assert decay_limit(INTEGRATOR, PLAIN) == pytest.approx(1.0, abs=1e-3)


def test_corrector_with_zero_weights_is_stable_up_to_two_and_dissipates():
    assert frequency_limit(INTEGRATOR, DAMPED) == pytest.approx(2.0, abs=1e-3)
    for x in (0.5, 1.0, 1.9):
        assert spectral_radius(by_hand(DAMPED, x)) < 1.0 - 1e-4


def test_corrector_with_half_weights_is_weakly_unstable():
    for x in (0.1, 0.5, 1.0):
        growth = spectral_radius(amplification_matrix(INTEGRATOR, CORRECTED, LinearSystem(x * x, 0.0)))
        assert growth == pytest.approx(spectral_radius(by_hand(CORRECTED, x)), abs=1e-12)
        assert growth > 1.0 + 1e-7
    assert frequency_limit(INTEGRATOR, CORRECTED) < 0.06
    assert spectral_radius(by_hand(CORRECTED, 0.1)) < 1.0 + 1e-3


def run(scheme, system, loads, h, steps, initial):
    """(steps, 3) q, v, a after each step of one degree of freedom."""
    state = INTEGRATOR.allocate(1, 1)
    state.q[0], state.v[0] = initial
    INTEGRATOR.start(system, loads.constant + loads.factor[0, 0] @ loads.pattern, state)
    history = np.zeros((steps, 3, 1))
    record(INTEGRATOR, scheme, system, loads, state, h, 1, history)
    return history[:, :, 0]


def free(steps):
    return no_loads(1, 1)._replace(factor=np.zeros((steps, 1, 0)))


def test_energy_of_the_undamped_oscillator_stays_near_the_stability_limit():
    h, steps = 1.9, 4000
    q, v, _ = run(PLAIN, LinearSystem(1.0, 0.0), free(steps), h, steps, (1.0, 0.0)).T
    energy = q**2 + v**2
    first, last = energy[: steps // 2], energy[steps // 2 :]
    assert last.max() == pytest.approx(first.max(), rel=1e-3)
    assert last.mean() == pytest.approx(first.mean(), rel=2e-3)


def test_forced_oscillator_follows_the_closed_form():
    w, drive, h, steps = 3.0, 2.0, 1e-3, 4000
    t = h * np.arange(1, steps + 1)
    loads = LoadHistory(np.array([0.5]), np.array([[4.0]]), np.cos(drive * t).reshape(-1, 1, 1))
    state = INTEGRATOR.allocate(1, 1)
    INTEGRATOR.start(LinearSystem(w * w, 0.0), np.array([0.5 + 4.0]), state)
    history = np.zeros((steps, 3, 1))
    record(INTEGRATOR, PLAIN, LinearSystem(w * w, 0.0), loads, state, h, 1, history)
    amplitude, offset = 4.0 / (w**2 - drive**2), 0.5 / w**2
    q = amplitude * (np.cos(drive * t) - np.cos(w * t)) + offset * (1 - np.cos(w * t))
    v = amplitude * (w * np.sin(w * t) - drive * np.sin(drive * t)) + offset * w * np.sin(w * t)
    a = 0.5 + 4.0 * np.cos(drive * t) - w**2 * q
    np.testing.assert_allclose(history[:, :, 0], np.stack([q, v, a], axis=1), atol=1e-4)


def test_several_steps_an_interval_are_the_same_steps():
    system, loads = LinearSystem(4.0, 0.0), free(12)
    loads = LoadHistory(np.array([1.0]), np.array([[1.0]]), np.arange(12.0).reshape(12, 1, 1))
    each = run(PLAIN, system, loads, 0.1, 12, (0.3, 0.1))
    state = INTEGRATOR.allocate(1, 1)
    state.q[0], state.v[0] = 0.3, 0.1
    INTEGRATOR.start(system, np.array([1.0]), state)
    history = np.zeros((3, 3, 1))
    record(INTEGRATOR, PLAIN, system, loads, state, 0.1, 4, history)
    np.testing.assert_array_equal(history[:, :, 0], each[3::4])
