"""A straight cable that whirls about its pinned end: tension rho_A omega^2 (L^2 - x^2) / 2.

Without stiffness it vibrates out of the plane with w_k^2 = k (2k - 1) omega^2 in the shape of the Legendre
polynomial P_(2k-1)(x / L).
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial.legendre import Legendre

from exudyn_inext.cable.cable import Section
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.cable.section_forces import SectionPoints, SolvedState, section_forces
from exudyn_inext.system import index_reduced_rates
from tests.cables import State, hermite, straight_cable
from tests.known_answers.vibrations import natural_frequencies, sampled_frequency
from tests.moving import move

LENGTH, RHO, OMEGA = 1.4, 0.6, 7.0
UNIT = RHO * OMEGA**2 * LENGTH**4  # of bending stiffness [N m^2]


def whirling(number, dim, stiffness):
    """Along x, turning about z; bending stiffness in `UNIT`s."""
    cable = straight_cable(number, dim, "pinned", LENGTH, section=Section(RHO, stiffness * UNIT))
    v = np.zeros_like(cable.reference)
    v[:, 0, 1], v[:, 1, 1] = OMEGA * cable.reference[:, 0, 0], OMEGA
    return State(cable, cable.reference, v, 0.0 * v)


def tension(state, points):
    """(m,) at arc lengths (m,)."""
    system = cable_system(state.cable, 0.0)
    a, rate = np.zeros(state.q.size), np.zeros(state.q.size)
    index_reduced_rates(system, state.inputs, state.q.ravel(), state.v.ravel(), a, rate)
    solved = SolvedState(
        state.q, state.v, a.reshape(state.q.shape), system.chain.elements["multiplier"][:, 0]
    )
    no_load = np.zeros(state.cable.dimension)
    return section_forces(SectionPoints(state.cable, points), system.chain, solved, no_load).tension


@pytest.mark.parametrize("dim", [2, 3])
def test_run_of_rattle_stays_straight_under_its_tension_and_turns_by_the_angle_of_its_step(dim, known_answer):
    """A rotor's step is asin(h omega): a chord of length h v / cos(angle / 2) between two tangents."""
    state, h, steps = whirling(6, dim, 1e-3), 2e-3, 900  # two turns
    q, v, _ = move(state, h, steps, steps)[-1]
    angle = steps * np.arcsin(h * OMEGA)
    direction = np.array([np.cos(angle), np.sin(angle), 0.0][:dim])
    across = np.array([-np.sin(angle), np.cos(angle), 0.0][:dim])
    x = state.q[:, 0, 0]
    np.testing.assert_allclose(q[:, 0], np.outer(x, direction), atol=1e-7)
    np.testing.assert_allclose(v[:, 0], np.outer(OMEGA * x, across), atol=1e-6)
    points = np.linspace(0.0, LENGTH, 21)
    expected = 0.5 * RHO * OMEGA**2 * (LENGTH**2 - points**2)
    found = tension(replace(state, q=q.copy(), v=v.copy()), points)
    np.testing.assert_allclose(found, expected, atol=1e-9 * expected[0])
    error = np.abs(found - expected).max() / expected[0]
    known_answer(f"whirling cable in {dim}D: centrifugal tension after two turns", error)


def centrifugal_force(cable):
    """(n, 2, 2) of the density rho_A omega^2 x along x."""
    force = np.zeros(cable.reference.shape)
    for k, length in enumerate(cable.element_lengths):
        density = RHO * OMEGA**2 * np.polynomial.Polynomial([cable.reference[k, 0, 0], 1.0])
        force[k : k + 2, :, 0] += np.reshape([(p * density).integ()(length) for p in hermite(length)], (2, 2))
    return force


def vibrations(number, stiffness):
    """(3,) w out of the plane, and modes (3, n, 2) of z and its slope.

    Those of the resting cable under the centrifugal load, which sets the tension; across x all directions are
    alike, so that a planar cable will do.
    """
    cable = whirling(number, 2, stiffness).cable
    found, modes = natural_frequencies(cable, centrifugal_force(cable))
    return found[:3], modes[:3, :, :, 1]


def rise(k):
    """d(w_k^2) / d(stiffness in units), first order: int P''^2 / int P^2 omega^2."""
    shape = Legendre.basis(2 * k - 1)
    integrals = [(p**2).integ()(1.0) - (p**2).integ()(0.0) for p in (shape.deriv(2), shape)]
    return OMEGA**2 * integrals[0] / integrals[1]


def test_frequencies_out_of_the_plane_approach_those_of_legendre_in_proportion_to_the_stiffness():
    exact = np.array([1.0, 6.0, 15.0]) * OMEGA**2
    stiffness = np.array([1.6e-5, 4e-6])
    found = np.array([vibrations(30, x)[0] ** 2 - exact for x in stiffness])
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-9 * exact[0])  # a rigid motion at any stiffness
    of_first_order = found[:, 1:] / np.multiply.outer(stiffness, [rise(2), rise(3)])
    assert (of_first_order[1] > of_first_order[0]).all()
    assert (of_first_order[1] > [0.9, 0.75]).all()
    assert (of_first_order < 1.0).all()
    assert (found[1, 1:] < 3e-3 * exact[1:]).all()


@pytest.mark.parametrize(("k", "tolerance"), [(1, 2e-5), (2, 1e-3)])
def test_a_whirling_cable_pushed_out_of_its_plane_swings_with_the_frequency_of_legendre(
    k, tolerance, known_answer
):
    state, h, every = whirling(12, 3, 1.6e-5), 1e-3, 24
    w, modes = vibrations(12, 1.6e-5)
    mode = modes[k - 1] / np.abs(modes[k - 1]).max()
    state.v[:, :, 2] = 1e-4 * mode
    history = move(state, h, 48 * every, every)
    found = sampled_frequency(np.einsum("tka,ka->t", history[:, 0, :, :, 2], mode), h * every)
    assert found == pytest.approx(w[k - 1], rel=2e-5)  # (h w)^2 / 24 = 1.2e-5
    legendre = np.sqrt(k * (2 * k - 1)) * OMEGA
    assert found == pytest.approx(legendre, rel=tolerance)
    known_answer(f"whirling cable: frequency {k} out of the plane (Legendre)", abs(found / legendre - 1.0))
