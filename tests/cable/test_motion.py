"""What a moving cable must do: decay of constraint errors, conservation of energy."""

import numpy as np
import pytest

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import LoadHistory, record
from exudyn_inext.integrators.zhai import Zhai
from exudyn_inext.loads.gravity import gravity_force
from tests.cables import (
    DIMENSIONS,
    MEASURES,
    State,
    bending_energy,
    dense_constraints,
    dense_rates,
    fine_quadrature,
    hermite,
    kinetic_energy,
    planar_pendulum,
    random_state,
)


def move(state, zeta, h, steps, every=1, scheme=None, name="Zhai"):
    """(steps / every, 3, n, 2, dim) history of a cable under a constant force."""
    integrator = INTEGRATORS[name]
    system = CableSystem(build_chain(state.cable), zeta)
    loads = LoadHistory(state.external.ravel(), np.zeros((0, state.q.size)), np.zeros((steps, 1, 0)))
    memory = integrator.allocate(state.q.size, state.q.size)
    memory.q[:], memory.v[:] = state.q.ravel(), state.v.ravel()
    integrator.start(system, state.external.ravel(), memory)
    history = np.zeros((steps // every, 3, state.q.size))
    record(integrator, scheme or integrator.scheme(), system, loads, memory, h, every, history)
    return history.reshape(-1, 3, *state.q.shape)


def pendulum_at_rest(number, **changes):
    cable, gravity = planar_pendulum(number, **changes)
    return State(
        cable,
        cable.reference.copy(),
        np.zeros_like(cable.reference),
        gravity_force(cable, gravity),
    )


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)
@pytest.mark.parametrize("dim", DIMENSIONS)
def test_violated_constraints_decay_exponentially(measure, dim):
    zeta, h, steps = 20.0, 1e-4, 1500
    state = random_state(61, 5, dim, measure, 3, "pinned")
    history = move(State(state.cable, state.q, 0 * state.v, 0 * state.q), zeta, h, steps, 250)
    first = dense_constraints(state.cable, state.q, state.v).value
    assert np.abs(first).max() > 0.01
    for t, (q, v, _) in zip(h * 250 * np.arange(1, 7), history, strict=True):
        found = dense_constraints(state.cable, q, v)
        np.testing.assert_allclose(
            found.value, first * np.exp(-zeta * t), atol=0.01 * np.abs(first).max() * np.exp(-zeta * t)
        )


def test_violated_velocity_constraints_decay_exponentially():
    zeta, h, steps = 20.0, 1e-4, 1000
    cable, _ = planar_pendulum(5)
    v = 1e-6 * np.random.default_rng(62).standard_normal(cable.reference.shape)
    v[0, 0] = 0.0
    state = State(cable, cable.reference, v, 0 * v)
    jacobian = dense_constraints(cable, state.q, v).jacobian
    (_, end, _) = move(state, zeta, h, steps, steps)[-1]
    first, last = jacobian @ v.ravel(), jacobian @ end.ravel()
    decay = np.exp(-zeta * h * steps)
    np.testing.assert_allclose(last, decay * first, atol=0.01 * decay * np.abs(first).max())


def slope_drift(history):
    squares = (history[:, 0, :, 1] ** 2).sum(axis=2)
    return np.abs(np.sqrt(squares) - 1.0).max(axis=1)


def test_projected_rate_keeps_slopes_ten_times_closer_to_unity():
    state = pendulum_at_rest(5)
    projected, plain = (
        slope_drift(move(state, 100.0, 2.5e-3, 2000, 10, Zhai(projected_rate=choice)))
        for choice in (True, False)
    )
    assert projected.max() < 0.1 * plain.max()
    assert projected[-1] < 0.1 * plain[-1]


def potential_energy(cable, q, gravity):
    """Bending energy and the weight's potential, by quadrature."""
    total = bending_energy(cable, q)
    for k, length in enumerate(cable.element_lengths):
        x, weight = fine_quadrature(length)
        points = np.array([p(x) for p in hermite(length)]).T @ np.concatenate([q[k], q[k + 1]])
        total -= cable.section.mass_per_length * weight @ points @ gravity
    return total


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.value)
def test_undamped_pendulum_keeps_its_energy_within_a_thousandth_of_its_swing(measure):
    state, (_, gravity) = pendulum_at_rest(5, measure=measure), planar_pendulum(5)
    history = move(state, 100.0, 2.5e-3, 2000, every=5)
    kinetic = np.array([kinetic_energy(state.cable, v) for _, v, _ in history])
    potential = np.array([potential_energy(state.cable, q, gravity) for q, _, _ in history])
    start = potential_energy(state.cable, state.q, gravity)
    assert kinetic.max() > 0.1
    assert np.abs(kinetic + potential - start).max() < 1e-3 * kinetic.max()


@pytest.mark.kernel
def test_one_step_is_the_taylor_step_of_the_dense_equations():
    h, zeta = 1e-3, 5.0
    state = random_state(63, 3, 2, MEASURES[0], supports="pinned")
    a, rate = (x.reshape(state.q.shape) for x in dense_rates(state, zeta)[:2])
    q, v, end = move(state, zeta, h, 1)[0]
    np.testing.assert_allclose(q, state.q + h * rate + 0.5 * h * h * a, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(v, state.v + h * a, rtol=1e-12, atol=1e-12)
    expected, *_ = dense_rates(State(state.cable, q, v, state.external), zeta)
    np.testing.assert_allclose(end.ravel(), expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_a_planar_motion_is_the_same_in_two_and_three_dimensions():
    two, three = (move(pendulum_at_rest(5, dim=d), 100.0, 2.5e-3, 200, 200)[-1] for d in DIMENSIONS)
    np.testing.assert_allclose(three[..., :2], two, atol=1e-9)
    np.testing.assert_allclose(three[..., 2], 0.0, atol=1e-9)


@pytest.mark.parametrize("name", [n for n, i in INTEGRATORS.items() if not i.stabilised])
def test_position_level_schemes_stay_on_the_constraint_manifold(name):
    state = pendulum_at_rest(5)
    q, v, _ = move(state, 100.0, 2.5e-3, 400, 400, name=name)[-1]
    found = dense_constraints(state.cable, q, v)
    assert np.abs(found.value).max() < 1e-9
    assert np.abs(found.jacobian @ v.ravel()).max() < 1e-11 * np.abs(v).max()


@pytest.mark.parametrize("name", [n for n, i in INTEGRATORS.items() if not i.stabilised])
def test_position_level_schemes_run_backwards_to_where_they_started(name):
    state = pendulum_at_rest(5)
    q, v, _ = move(state, 100.0, 2.5e-3, 400, 400, name=name)[-1]
    turned = State(state.cable, q.copy(), -v, state.external)
    back, rest, _ = move(turned, 100.0, 2.5e-3, 400, 400, name=name)[-1]
    assert np.abs(q - state.q).max() > 1.0
    np.testing.assert_allclose(back, state.q, atol=1e-7)
    np.testing.assert_allclose(rest, 0.0, atol=1e-5)
