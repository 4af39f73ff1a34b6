"""A chain that hangs: w_k = j_k / 2 sqrt(g / L), j_k the zeros of the Bessel function J_0.

D. Bernoulli, 1732: (T u')' + rho_A w^2 u = 0, T the weight below, is solved by
u = J_0(j_k sqrt(z / L)), z from the free end. Small EI raises w_k^2 by EI int u''^2 / (rho_A int u^2).
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import factorial, jn_zeros

from exudyn_inext.cable.cable import Section
from exudyn_inext.loads.gravity import gravity_force
from tests.cables import State, straight_cable
from tests.known_answers.vibrations import (
    natural_frequencies,
    observed_order,
    sampled_frequency,
    squared_frequencies,
)
from tests.moving import move

LENGTH, RHO, G = 2.5, 0.4, 9.81
ZEROS = jn_zeros(0, 3)
EXACT = 0.5 * ZEROS * np.sqrt(G / LENGTH)
WEIGHT = RHO * G * LENGTH


def hanging(number, stiffness):
    """A chain along -y from the origin, EI over weight and length squared given, and its weight."""
    section = Section(RHO, stiffness * WEIGHT * LENGTH**2)
    cable = straight_cable(number, 2, "pinned", LENGTH, section=section)
    cable.reference[:] = np.flip(cable.reference, axis=2) * [1.0, -1.0]
    return cable, gravity_force(cable, np.array([0.0, -G]))


def mode_shape(k):
    """u over z / L: J_0(2 sqrt(x)) = sum (-x)^m / m!^2 at x = j_k^2 z / (4 L)."""
    m = np.arange(40)
    return np.polynomial.Polynomial((-0.25 * ZEROS[k] ** 2) ** m / factorial(m) ** 2)


def relative_rise(k):
    """d ln(w_k) / d(EI over weight and length squared), first order."""
    u = mode_shape(k)
    bending = quad(lambda z: u.deriv(2)(z) ** 2, 0.0, 1.0)[0]
    square = quad(lambda z: u(z) ** 2, 0.0, 1.0)[0]
    return 0.5 * bending / square * G / LENGTH / EXACT[k] ** 2


def rises(number, stiffness):
    """(3,) relative rise of the lowest frequencies above those without stiffness."""
    found, _ = natural_frequencies(*hanging(number, stiffness))
    return found[:3] / EXACT - 1.0


def test_mode_shapes_vanish_at_the_support_and_the_first_frequency_is_the_textbooks():
    np.testing.assert_allclose([mode_shape(k)(1.0) for k in range(3)], 0.0, atol=1e-12)
    assert EXACT[0] == pytest.approx(1.2024 * np.sqrt(G / LENGTH), rel=1e-4)


def test_frequencies_approach_the_bessel_zeros_from_above_in_proportion_to_the_stiffness(known_answer):
    """Layers at the support and the free end, where the chain straightens, make the rise a little smaller."""
    stiffness = np.array([6.4e-5, 1.6e-5, 4e-6])
    found = np.array([rises(40, x) for x in stiffness])
    of_first_order = found / np.multiply.outer(stiffness, [relative_rise(k) for k in range(3)])
    assert (np.diff(of_first_order, axis=0) > 0.0).all()
    assert (of_first_order < 1.0).all()
    assert (of_first_order[-1] > [0.95, 0.85, 0.7]).all()
    assert (np.abs(found[-1]) < [4e-6, 3e-4, 2.5e-3]).all()
    orders = observed_order(found[:, 0]) / 2.0  # the stiffness falls by 4
    np.testing.assert_allclose(orders, 1.0, atol=0.05)
    known_answer("hanging chain, lowest Bessel zero, N = 40, as EI -> 0", abs(found[-1, 0]), orders.mean())


def test_a_chain_pushed_in_its_lowest_mode_swings_with_the_frequency_of_bernoulli(known_answer):
    cable, weight = hanging(20, 1.6e-5)
    w, modes = natural_frequencies(cable, weight)
    mode = modes[0] / np.abs(modes[0]).max()
    state = State(cable, cable.reference, 1e-4 * mode, weight)
    h, every = 2e-3, 80
    history = move(state, h, 48 * every, every)  # 3 periods
    samples = np.tensordot(history[:, 0] - cable.reference, mode, 3)
    found = sampled_frequency(samples, h * every)
    assert found == pytest.approx(w[0], rel=(h * w[0]) ** 2)
    assert found == pytest.approx(EXACT[0], rel=5e-5)
    known_answer("hanging chain: frequency of a run, N = 20", abs(found / EXACT[0] - 1.0))


def test_a_free_end_hangs_straight_only_if_the_stiffness_holds_its_last_element():
    """A limit of the element: the end's nodal multiplier is a pressure of rho_A g l^2 / 24.

    Below EI = 0.0077 rho_A g l^3, whatever the mesh, the straight chain is an unstable equilibrium.
    """
    for number in (5, 20):
        limit = 0.00769 * RHO * G * (LENGTH / number) ** 3 / (WEIGHT * LENGTH**2)
        stable, unstable = (squared_frequencies(*hanging(number, x * limit))[0][0] for x in (1.01, 0.99))
        assert stable > 0.0 > unstable
