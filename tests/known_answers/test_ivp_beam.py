"""The beam of the Test Set for IVP Solvers: inextensible, clamped, pushed at its end with F(t) (-1, 1).

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.1; F. Mazzia, C. Magherini, Test
Set for Initial Value Problem Solvers, release 2.4, University of Bari 2008, problem beam: n = 40 angles at
the middle of equal pieces, and their values at t = 5, computed to 1e-16. L = rho_A = EI = 1.

In the limit of many pieces this is the cable. `LIMIT` is extrapolated from n = 20, 40, 80, the last step of
which changes it by 1e-6; the tests repeat it from 10, 20, 40.
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from exudyn_inext.cable.cable import Section
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import LoadHistory, record
from tests.cables import straight_cable

END = 5.0
PIECES = np.array([1, 10, 20, 40]) - 1
PUBLISHED = [-0.5792366591285007e-2, -0.9119134654647947e-1, -0.1483595472463012, -0.1767201761075488]

LIMIT = np.array([0.9906417, -0.1267518])  # tip at t = 5
LIMIT_ERROR = 2e-6


def force(t):
    return np.where(t <= np.pi, 1.5 * np.sin(t) ** 2, 0.0)


@cache
def angles(n):
    """(n,) at t = 5: the published equations, their sums over all pieces written as matrices."""
    number = np.arange(1, n + 1)
    lever = n + 0.5 - np.maximum.outer(number, number)

    def right_hand_side(t, y):
        angle, rate = y[:n], y[n:]
        turn = np.subtract.outer(angle, angle)
        padded = np.concatenate([[-angle[0]], angle, [angle[-1]]])
        moment = n**4 * np.diff(padded, 2) + n**2 * force(t) * (np.cos(angle) + np.sin(angle))
        moment -= (lever * np.sin(turn)) @ rate**2
        return np.concatenate([rate, np.linalg.solve(lever * np.cos(turn), moment)])

    tolerance = 1e-8 if n == 40 else 1e-6  # as the values that are published, or for the order alone
    y = np.zeros(2 * n)
    for interval in ((0.0, np.pi), (np.pi, END)):  # the force is smooth in each
        y = solve_ivp(right_hand_side, interval, y, "Radau", rtol=tolerance, atol=tolerance).y[:, -1]
    return y[:n]


def tip_of_pieces(n):
    return np.array([np.cos(angles(n)).mean(), np.sin(angles(n)).mean()])


@cache
def tip_of_cable(number, steps, name="RATTLE"):
    """(2,) at t = 5."""
    cable = straight_cable(number, 2, "clamped", 1.0, section=Section(1.0, 1.0))
    system, integrator, h = cable_system(cable, 100.0), INTEGRATORS[name], END / steps
    pattern = np.zeros(cable.reference.size)
    pattern[-4:-2] = -1.0, 1.0  # on the position of the last node
    times = h * np.add.outer(np.arange(steps), np.array(integrator.stages))
    loads = LoadHistory(0.0 * pattern, pattern[None], force(times)[:, :, None])
    state = integrator.allocate(pattern.size, pattern.size)
    state.q[:] = cable.reference.ravel()
    integrator.start(system, 0.0 * pattern, state)
    history = np.zeros((1, 3, pattern.size))
    record(integrator, integrator.scheme(), system, loads, state, h, steps, history)
    return history[0, 0].reshape(cable.reference.shape)[-1, 0]


def test_equations_are_the_published_ones_and_converge_with_order_two_to_the_limit():
    np.testing.assert_allclose(angles(40)[PIECES], PUBLISHED, atol=1e-8)
    tips = np.array([tip_of_pieces(n) for n in (10, 20, 40)])
    np.testing.assert_allclose(np.log2((tips[:-1] - LIMIT) / (tips[1:] - LIMIT)), 2.0, atol=0.2)
    once = tips[1:] + (tips[1:] - tips[:-1]) / 3.0
    np.testing.assert_allclose(once[1] + (once[1] - once[0]) / 15.0, LIMIT, atol=2e-5)


def test_tip_of_the_cable_converges_to_the_limit_with_order_four_at_least(known_answer):
    errors = np.abs([tip_of_cable(number, 2500 * number**2) - LIMIT for number in (3, 6, 12)])
    assert (np.log2(errors[:-1] / errors[1:]) > 3.8).all()
    assert errors[-1].max() < 6e-6 + LIMIT_ERROR
    order = np.log2(errors[:-1] / errors[1:]).min()
    known_answer("beam of the IVP test set: tip at t = 5, N = 12", errors[-1].max(), order)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_all_integrators_arrive_at_the_same_tip(name):
    """What is left of six elements' error is theirs: the steps' own is far smaller."""
    np.testing.assert_allclose(tip_of_cable(6, 90000, name), tip_of_cable(6, 90000), atol=2e-7)
    np.testing.assert_allclose(tip_of_cable(6, 90000, name), LIMIT, atol=1.2e-4)
