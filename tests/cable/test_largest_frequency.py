"""The largest frequency equals that of a dense eigenvalue solve on the constraints' null space."""

from dataclasses import replace

import numba
import numpy as np
import pytest
from scipy.linalg import eigvalsh

from exudyn_inext.cable import frequency
from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.frequency import largest_frequency
from exudyn_inext.cable.implicit_bending import ImplicitBending
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import no_loads, record
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.system import index_reduced_rates
from tests.cables import (
    DIMENSIONS,
    LINKS,
    MEASURES,
    State,
    dense_largest_frequency,
    dense_mass,
    linked_state,
    mass_matrix,
    planar_pendulum,
    random_state,
    stiffness_matrix,
    straight_cable,
    with_resting_anchors,
)

both_measures = pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)
both_dimensions = pytest.mark.parametrize("dim", DIMENSIONS)


def frequency_of(state, mass_scaling=0.0):
    system = cable_system(state.cable, 100.0, ImplicitBending(mass_scaling))
    return largest_frequency(system, state.inputs, state.q)


def at_rest(cable, q=None):
    zero = np.zeros_like(cable.reference)
    return State(cable, cable.reference if q is None else q, zero, zero)


@both_measures
@both_dimensions
@pytest.mark.parametrize("number", [1, 2, 5, 11, 20])
def test_straight_cable_agrees_with_the_dense_eigenvalue_solve(measure, dim, number):
    for supports in ("free", "pinned", "clamped"):
        state = at_rest(straight_cable(number, dim, supports, measure=measure))
        if number > 1 or supports != "clamped":
            expected = dense_largest_frequency(state)
            assert frequency_of(state) == pytest.approx(expected, rel=1e-6)


@pytest.mark.kernel
@both_dimensions
@pytest.mark.parametrize("links", LINKS)
def test_linked_cable_under_load_agrees_with_the_dense_eigenvalue_solve(dim, links):
    for number in (5,) if numba.config.DISABLE_JIT else (5, 12):
        state = with_resting_anchors(linked_state(43, number, dim, MEASURES[0], links))
        assert frequency_of(state) == pytest.approx(dense_largest_frequency(state), rel=1e-6)


@pytest.mark.kernel
@both_measures
@both_dimensions
@pytest.mark.parametrize("number", [2, 5, 11] if numba.config.DISABLE_JIT else [2, 5, 11, 20])
def test_curved_cable_under_load_agrees_with_the_dense_eigenvalue_solve(measure, dim, number):
    for n_bar in (0, 1, number):
        state = random_state(41, number, dim, measure, n_bar, "pinned")
        expected = dense_largest_frequency(state)
        assert frequency_of(state) == pytest.approx(expected, rel=1e-6)


def test_chains_of_few_elements_have_accurate_frequencies_too():
    for number in (2, 3, 4, 5, 8):
        straight = at_rest(straight_cable(number, 3, "clamped"))
        for state in (straight, random_state(43, number, 2, MEASURES[0], 1, "clamped")):
            assert frequency_of(state) == pytest.approx(dense_largest_frequency(state), rel=1e-6)


@both_dimensions
def test_mass_scaling_lowers_the_frequency_as_the_dense_solve_says(dim):
    state = random_state(42, 12, dim, MEASURES[0], 12, "pinned")
    found = frequency_of(state, 0.01)
    assert found == pytest.approx(dense_largest_frequency(state, 0.01), rel=1e-6)
    assert found < 0.5 * frequency_of(state)


@pytest.mark.parametrize("mass_scaling", [1.0, 1e2, 1e4])
def test_mass_scaling_of_long_steps_agrees_with_the_dense_solve(mass_scaling):
    """All that the iteration leaves is then a cluster of frequencies, and round-off off the constraints."""
    for seed in (42, 43):
        state = random_state(seed, 12, 2, MEASURES[0], 12, "pinned")
        assert frequency_of(state, mass_scaling) == pytest.approx(
            dense_largest_frequency(state, mass_scaling), rel=1e-3
        )


@both_dimensions
def test_spin_raises_the_frequency_by_the_tension_of_the_centrifugal_force(dim):
    cable, _ = planar_pendulum(8, dim)
    spin = 40.0
    q = cable.reference
    v = np.zeros_like(q)
    v[..., 1] = spin * q[..., 0]
    centrifugal = (dense_mass(cable) @ (spin**2 * q).ravel()).reshape(q.shape)
    found = largest_frequency(cable_system(cable, 100.0), np.zeros(q.size), q, v)
    assert found == pytest.approx(frequency_of(State(cable, q, np.zeros_like(q), centrifugal)), rel=1e-9)
    assert found > 1.02 * frequency_of(at_rest(cable))


@both_dimensions
def test_tension_raises_the_frequency_as_the_dense_solve_says(dim):
    cable, gravity = planar_pendulum(8, dim)
    hanging = np.ascontiguousarray(cable.reference[:, :, [1, 0, 2][:dim]] * [1, -1, 1][:dim])
    for factor in (1.0, 1e3):
        external = factor * gravity_force(cable, gravity)
        state = State(cable, hanging, np.zeros_like(hanging), external)
        assert frequency_of(state) == pytest.approx(dense_largest_frequency(state), rel=1e-6)
    assert frequency_of(state) > 1.05 * frequency_of(at_rest(cable, hanging))


@pytest.mark.kernel
def test_free_straight_cable_of_five_elements_has_the_known_frequency():
    found = frequency_of(at_rest(straight_cable(5, 2)))
    assert found == pytest.approx(61.17, abs=5e-3)


def beam_frequency(number):
    """Largest frequency of the textbook's transversely vibrating beam, l = rho_A = EI = 1."""
    size = 2 * (number + 1)
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for k in range(0, size - 2, 2):
        mass[k : k + 4, k : k + 4] += mass_matrix(1.0)
        stiffness[k : k + 4, k : k + 4] += stiffness_matrix(1.0)
    return np.sqrt(eigvalsh(stiffness, mass)[-1])


@both_dimensions
@pytest.mark.parametrize("number", [1, 5, 30])
def test_straight_cable_vibrates_like_a_linear_beam(dim, number):
    found = frequency_of(at_rest(straight_cable(number, dim)))
    assert found == pytest.approx(beam_frequency(number), rel=1e-5)


def test_long_straight_cable_has_the_known_frequency():
    # without free ends, which add a localised mode
    found = frequency_of(at_rest(straight_cable(300, 2, "pinned within")))
    assert found == pytest.approx(beam_frequency(300), rel=1e-3)


def test_frequency_scales_with_section_and_element_length():
    cable, _ = planar_pendulum(5)
    section, length = cable.section, cable.element_lengths[0]
    unit = np.sqrt(section.bending_stiffness / section.mass_per_length) / length**2
    free = straight_cable(5, 2, length=cable.length, section=section)
    assert frequency_of(at_rest(free)) / unit == pytest.approx(61.17, abs=5e-3)


def test_bending_grows_above_two_over_the_largest_frequency_and_not_below():
    cable = straight_cable(6, 2)
    limit = 2.0 / dense_largest_frequency(at_rest(cable))
    assert growth(cable, 0.99 * limit) < 10.0
    assert growth(cable, 1.01 * limit) > 1e3


def growth(cable, h):
    """Ratio of the final to the initial disturbance of a straight cable, 300 steps of size h."""
    zhai = INTEGRATORS["Zhai"]
    system, state = (
        CableSystem(build_chain(cable), 1.0),
        zhai.allocate(cable.reference.size, cable.reference.size),
    )
    state.q[:] = cable.reference.ravel()
    v = state.v.reshape(cable.reference.shape)
    v[:, 0, 1] = 1e-9 * (-1.0) ** np.arange(len(v))
    disturbance = np.abs(v[:, 0, 1]).max()
    zhai.start(system, np.zeros(state.q.size), state)
    history = np.zeros((1, 3, state.q.size))
    record(zhai, zhai.scheme(), system, no_loads(state.q.size, 1), state, h, 300, history)
    return np.abs(v[:, 0, 1]).max() / disturbance


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
@both_dimensions
def test_a_frequency_that_is_not_finite_is_not_zero(dim, bad):
    cable, gravity = planar_pendulum(5, dim)
    system = cable_system(cable, 100.0)
    force = gravity_force(cable, gravity)
    force[3, 0, 0] = bad
    found = largest_frequency(system, force.ravel(), cable.reference.copy())
    assert not np.isfinite(found) or found > 1e100
    q = cable.reference.copy()
    q[3, 1, 0] = bad
    assert np.isnan(largest_frequency(system, gravity_force(cable, gravity).ravel(), q))


def test_a_cable_that_is_held_everywhere_has_none():
    cable, _ = planar_pendulum(2)
    cable = replace(cable, fixed=np.ones_like(cable.fixed), length_constraints=0)
    assert largest_frequency(cable_system(cable, 100.0), np.zeros(12), cable.reference.copy()) == 0.0


@pytest.mark.parametrize("lost", [0.0, -3.0, np.nan])
@both_dimensions
def test_a_tracker_that_has_lost_the_fastest_vibration_finds_it_again(dim, lost, monkeypatch):
    cable, gravity = planar_pendulum(8, dim)
    system, force = cable_system(cable, 100.0), gravity_force(cable, gravity).ravel()
    q = cable.reference
    expected = largest_frequency(system, force, q.copy())
    a, rate = np.zeros(q.size), np.zeros(q.size)
    index_reduced_rates(system, force, q.ravel(), np.zeros(q.size), a, rate)
    monkeypatch.setattr(frequency, "_power_iteration", lambda *_: lost)
    tracker = frequency.FrequencyTracker(system, q.shape)
    for _ in range(2):
        assert tracker.frequency(q, a.reshape(q.shape)) == pytest.approx(expected, rel=1e-6)
