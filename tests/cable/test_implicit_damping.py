"""Bending damping in the matrix on the left: against dense formulas and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from exudyn_inext.cable.cable import Section
from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.element.bending import stiffness_matrix
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.system import REPORTED, accelerate_and_project, index_reduced_rates, report_energy
from tests.cables import (
    MEASURES,
    State,
    bending_force,
    damping_force,
    dense_constraints,
    dense_form,
    dense_mass,
    random_state,
    relative_error,
    straight_cable,
    with_section,
)
from tests.moving import move, on_constraints

LAG, THETA = 0.02, 0.3  # h/2 [s]
DAMPING = 0.3
ZETA = 5.0


def damped(dim, supports="clamped"):
    return with_section(random_state(71, 5, dim, MEASURES[0], 3, supports), bending_damping=DAMPING)


def implicit_system(cable, zeta=0.0):
    return cable_system(cable, zeta, ImplicitBending(THETA * 4.0 * LAG**2, LAG))


def expected_acceleration(state, velocity, gamma):
    """Two passes: with all of the matrix D_c on the left, and with what of it is no damping put back."""
    cable, size = state.cable, state.q.size
    of_curvature = dense_form(cable, stiffness_matrix)
    left = dense_mass(cable, 4.0 * THETA * LAG**2 + LAG * DAMPING / cable.section.bending_stiffness)
    c = dense_constraints(cable, state.q, state.v)
    matrix = np.block([[left, c.jacobian.T], [c.jacobian, np.zeros((len(c.value), len(c.value)))]])
    force = state.external + bending_force(cable, state.q) + damping_force(cable, state.q, velocity)

    def solve(forces):
        return np.linalg.solve(matrix, np.concatenate([forces.ravel(), gamma(c)]))[:size]

    first = solve(force)
    all_of_it = DAMPING * of_curvature @ first
    taken = -damping_force(cable, state.q, first.reshape(state.q.shape))
    return solve(force + LAG * (all_of_it.reshape(state.q.shape) - taken))


@pytest.mark.kernel
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("supports", ["clamped", "free"])
def test_rattle_damps_at_the_half_step_behind(dim, supports):
    """It hands in v_(n+1/2) and h/2: the damping acts at v_(n+1/2), the rest of it is on the left."""
    state = damped(dim, supports)
    a, end = np.random.default_rng(3).standard_normal(state.q.size), np.zeros(state.q.size)
    system = implicit_system(state.cable)
    accelerate_and_project(system, state.inputs, state.q.ravel(), state.v.ravel(), LAG, a, end)
    assert relative_error(a, expected_acceleration(state, state.v, lambda c: c.gamma)) < 1e-9


@pytest.mark.kernel
@pytest.mark.parametrize("dim", [2, 3])
def test_zhai_damps_at_the_half_step_behind(dim):
    """It hands in v_n and the last acceleration: v_(n-1/2) = v_n - h/2 a_(n-1)."""
    state = damped(dim)
    last = np.random.default_rng(4).standard_normal(state.q.shape)
    a, rate = last.ravel().copy(), np.zeros(state.q.size)
    index_reduced_rates(
        implicit_system(state.cable, ZETA), state.inputs, state.q.ravel(), state.v.ravel(), a, rate
    )
    expected = expected_acceleration(state, state.v - LAG * last, lambda c: c.gamma - ZETA * c.rate)
    assert relative_error(a, expected) < 1e-9


@pytest.mark.kernel
def test_the_damping_on_the_left_is_no_mass_of_the_kinetic_energy():
    state = damped(2)
    energy_report, force = np.zeros(REPORTED), np.zeros(state.q.size)
    system = implicit_system(state.cable)
    flat = [array.ravel() for array in (state.q, state.v, state.v)]
    report_energy(system, state.inputs, *flat, force, energy_report)
    mass = dense_mass(state.cable, THETA * 4.0 * LAG**2)
    v = np.where(state.cable.fixed[:, :, None], 0.0, state.v).ravel()
    assert energy_report[0] == pytest.approx(0.5 * v @ mass @ v, rel=1e-10)


LENGTH, SECTION = 1.0, Section(0.1, 1.0)
AUTOMATIC = 0.01 / 11  # step of a cantilever of 16 elements under its weight, outputs at 100 Hz [s]


def transverse_modes(cable, axis=1):
    """Frequencies [rad/s] and shapes (n, 2, modes) of a straight beam whose first node is clamped."""
    mass, stiffness = dense_mass(cable), cable.section.bending_stiffness * dense_form(cable, stiffness_matrix)
    across = np.arange(mass.shape[0])[axis :: cable.dimension][2:]  # of positions and slopes behind the clamp
    squared, shapes = eigh(stiffness[np.ix_(across, across)], mass[np.ix_(across, across)])
    full = np.zeros((mass.shape[0], len(squared)))
    full[across] = shapes
    return np.sqrt(squared), full, mass


def amplitudes(cable, shape, mass, h, steps):
    """(steps, 2) amplitude of a mode and its rate, released from 1e-6 m; see `transverse_modes`."""
    bend = shape / np.abs(shape).max() * 1e-6
    zero = np.zeros(cable.reference.size)
    q = cable.reference + bend.reshape(cable.reference.shape)
    state = State(cable, q, np.zeros_like(q), zero.reshape(q.shape))
    history = move(state, h, steps, mass_scaling=THETA * h**2, lag=0.5 * h)
    moved = (history[:, 0] - cable.reference).reshape(steps, -1)
    rates = history[:, 1].reshape(steps, -1)
    return np.stack([moved @ mass @ shape, rates @ mass @ shape], axis=1)


@pytest.mark.parametrize("ratio", [0.02, 0.2, 1.0])  # D / EI [s]
@pytest.mark.parametrize("mode", range(5))
@pytest.mark.parametrize(("dim", "axis"), [(2, 1), (3, 1), (3, 2)])
def test_decay_rates_are_right_at_the_automatic_step(ratio, mode, dim, axis, known_answer):
    """q_tt + r w^2 q_t + w^2 q = 0: the envelope, or the slower exponential where it is overdamped."""
    section = replace(SECTION, bending_damping=ratio * SECTION.bending_stiffness)
    cable = straight_cable(16, dim, "clamped", LENGTH, section=section)
    steps = 1000
    frequencies, shapes, mass = transverse_modes(cable, axis)
    found, w = amplitudes(cable, shapes[:, mode], mass, AUTOMATIC, steps), float(frequencies[mode])
    half = 0.5 * ratio * w**2
    times = AUTOMATIC * np.arange(1, steps + 1)
    if half > w:
        exact, size = half - np.sqrt(half**2 - w**2), np.abs(found[:, 0])
        settled = 8.0 / (2.0 * (half - exact))  # the faster exponential is gone
    else:
        exact, settled = half, 0.0
        size = np.hypot(np.sqrt(w**2 - half**2) * found[:, 0], found[:, 1] + half * found[:, 0])
    first = np.searchsorted(times, max(settled, 20 * AUTOMATIC))
    last = np.searchsorted(times, min(times[first] + 5.0 / exact, times[-1])) - 1
    rate = np.log(size[first] / size[last]) / (times[last] - times[first])
    assert rate == pytest.approx(exact, rel=1e-3)
    known_answer(
        f"decay of mode {mode + 1}, axis {axis} of {dim}D, D = {ratio:g} EI", abs(rate / exact - 1.0)
    )


@pytest.mark.parametrize("ratio", [0.02, 0.2, 1.0])  # D / EI [s]
@pytest.mark.parametrize(("dim", "axis"), [(2, 1), (3, 1), (3, 2)])
def test_all_overdamped_modes_decay_at_their_rate_at_the_automatic_step(ratio, dim, axis):
    """Up to the fastest one of the mesh, h w = 50: they creep back, all at nearly EI / D."""
    section = replace(SECTION, bending_damping=ratio * SECTION.bending_stiffness)
    cable = straight_cable(16, dim, "clamped", LENGTH, section=section)
    frequencies, shapes, mass = transverse_modes(cable, axis)
    for mode in np.flatnonzero(ratio * frequencies > 4.0):
        half, w = 0.5 * ratio * frequencies[mode] ** 2, frequencies[mode]
        split = np.sqrt(half**2 - w**2)  # the faster of both exponentials has died away after some 5 / split
        first = max(20, int(5.0 / (split * AUTOMATIC)))
        last = first + 40
        found = amplitudes(cable, shapes[:, mode], mass, AUTOMATIC, last + 1)
        exact = w**2 / (half + split)
        rate = np.log(found[first, 0] / found[last, 0]) / ((last - first) * AUTOMATIC)
        assert rate == pytest.approx(exact, rel=1e-3), mode


@pytest.mark.parametrize("name", ["RATTLE", "Zhai"])
def test_order_is_kept_in_the_plane(name):
    """A cantilever that is bent far, released under its weight."""
    section = replace(SECTION, bending_damping=0.1)
    cable = straight_cable(6, 2, "clamped", LENGTH, section=section)
    force = np.zeros(cable.reference.shape)
    force[1:, 0, 1] = -3.0
    state = State(cable, cable.reference.copy(), np.zeros_like(force), force)
    paths = []
    for h in (4e-4, 2e-4, 1e-4, 1.25e-5):
        settings = {"name": name, "zeta": 50.0, "mass_scaling": THETA * h**2, "lag": 0.5 * h}
        paths.append(move(state, h, round(0.4 / h), round(0.02 / h), **settings)[:, 0])
    gaps = [np.abs(path - paths[-1]).max() for path in paths[:-1]]
    assert np.log2(gaps[0] / gaps[1]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(gaps[1] / gaps[2]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("name", ["RATTLE", "Zhai"])
@pytest.mark.parametrize("ratio", [0.02, 0.2, 1.0])  # D / EI [s]
def test_order_is_kept_in_space(name, ratio):
    """A cantilever that is pushed sideways and falls: its bending turns. Steps near the automatic one."""
    section = replace(SECTION, bending_damping=ratio * SECTION.bending_stiffness)
    cable = straight_cable(8, 3, "clamped", LENGTH, section=section)
    share, v = np.linspace(0.0, 1.0, 9), np.zeros(cable.reference.shape)
    v[:, :, 1] = 0.3 * np.stack([share**3, 3.0 * share**2], axis=1)
    v[:, :, 2] = 0.5 * np.stack([share**2, 2.0 * share], axis=1)
    weight = gravity_force(cable, np.array([0.0, -9.81, 0.0]))
    state = on_constraints(State(cable, cable.reference.copy(), v, weight))
    paths = []
    for h in (2e-3, 1e-3, 5e-4, 6.25e-5):
        settings = {"name": name, "zeta": 50.0, "mass_scaling": THETA * h**2, "lag": 0.5 * h}
        paths.append(move(state, h, round(0.4 / h), round(0.02 / h), **settings)[:, 0])
    gaps = [np.abs(path - paths[-1]).max() for path in paths[:-1]]
    assert gaps[0] < 1e-4
    assert np.log2(gaps[0] / gaps[1]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(gaps[1] / gaps[2]) == pytest.approx(2.0, abs=0.2)
