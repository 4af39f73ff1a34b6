"""What every integrator must fulfil: the declared order, on an equation and on a cable."""

import math
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import NamedTuple

import numba.core.caching
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.called_system import accelerates, implements
from exudyn_inext.compiled import plain
from exudyn_inext.errors import InputError
from exudyn_inext.integrators import INTEGRATORS, find_integrator
from exudyn_inext.integrators.integrator import LoadHistory, advance, record
from exudyn_inext.integrators.linear_stability import decay_limit, frequency_limit
from exudyn_inext.integrators.rattle import Rattle
from exudyn_inext.integrators.runge_kutta import RungeKutta4
from exudyn_inext.integrators.zhai import Zhai
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.system import accelerate_and_project, correct_position, index_reduced_rates
from tests.cables import planar_pendulum

every_integrator = pytest.mark.parametrize("integrator", INTEGRATORS.values(), ids=INTEGRATORS)


@pytest.fixture
def unsaved(monkeypatch):
    """Code compiled for types of this file must not reach the package's cache on disk."""
    monkeypatch.setattr(numba.core.caching.Cache, "save_overload", lambda *_: None)


class Pendulum(NamedTuple):
    """q'' = F(t) - w^2 sin q in each coordinate, without constraints."""

    squared_frequency: float


@accelerates(Pendulum)
def accelerate_pendulum(system, external, q, v, duration, stabilises, acceleration, rate):
    for i in range(len(q)):
        acceleration[i] = external[i] - system.squared_frequency * np.sin(q[i])
        rate[i] = v[i] + duration * acceleration[i]


@implements(correct_position, Pendulum)
def correct_pendulum(system, external, q, tolerance, learning, correction):
    correction[:] = 0.0
    return 0.0


TRIED = np.array([0.2, 0.5, 0.9, 0.99, 1.01, 1.05])  # in stability limits

CONSTANT = np.array([0.2, -0.5])
PATTERN = np.array([[1.0, 0.3], [0.0, 2.0]])
INITIAL = np.array([1.2, -0.4, 0.1, 0.9])
SQUARED_FREQUENCY = 4.0
END = 2.0


def factors(t):
    return np.array([np.sin(3.0 * t), np.cos(2.0 * t)])


def run_pendulum(integrator, steps):
    """q, v at `END`."""
    system, h = Pendulum(SQUARED_FREQUENCY), END / steps
    times = [[(step + stage) * h for stage in integrator.stages] for step in range(steps)]
    loads = LoadHistory(CONSTANT, PATTERN, np.array([[factors(t) for t in row] for row in times]))
    state = integrator.allocate(2, 2)
    state.q[:], state.v[:] = INITIAL[:2], INITIAL[2:]
    integrator.start(system, CONSTANT + factors(0.0) @ PATTERN, state)
    history = np.zeros((1, 3, 2))
    record(integrator, integrator.scheme(), system, loads, state, h, steps, history)
    return history[0, :2].ravel()


def exact_pendulum():
    def right_hand_side(t, y):
        force = CONSTANT + factors(t) @ PATTERN
        return np.concatenate([y[2:], force - SQUARED_FREQUENCY * np.sin(y[:2])])

    return solve_ivp(right_hand_side, (0, END), INITIAL, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]


@pytest.mark.kernel
@every_integrator
def test_observed_order_on_a_forced_nonlinear_equation_is_the_declared_one(integrator, unsaved):
    exact = exact_pendulum()
    errors = [np.abs(run_pendulum(integrator, steps) - exact).max() for steps in (200, 400, 800)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, integrator.order, atol=0.2)
    assert errors[-1] < 1e-4


def run_cable(integrator, steps, duration=0.2, number=4, intervals=1, damping=0.0):
    """(intervals, 3, n_dof) history of the planar pendulum with N = 4."""
    cable, gravity = planar_pendulum(number)
    cable = replace(cable, section=replace(cable.section, bending_damping=damping))
    system = CableSystem(build_chain(cable), 100.0)
    force = gravity_force(cable, gravity).ravel()
    loads = LoadHistory(force, np.zeros((0, force.size)), np.zeros((0, len(integrator.stages), 0)))
    loads = loads._replace(factor=np.zeros((steps, len(integrator.stages), 0)))
    state = integrator.allocate(force.size, force.size)
    state.q[:] = cable.reference.ravel()
    integrator.start(system, force, state)
    history = np.zeros((intervals, 3, force.size))
    record(
        integrator, integrator.scheme(), system, loads, state, duration / steps, steps // intervals, history
    )
    return history


@every_integrator
@pytest.mark.parametrize("damping", [0.0, 2e-4])
def test_observed_order_on_a_cable_is_the_declared_one(integrator, damping):
    ends = [run_cable(integrator, steps, damping=damping)[-1, 0] for steps in (400, 800, 1600, 3200)]
    gaps = np.abs(np.diff(ends, axis=0)).max(axis=1)
    np.testing.assert_allclose(np.log2(gaps[:-1] / gaps[1:]), integrator.order, atol=0.2)


def test_all_integrators_converge_to_the_same_motion():
    ends = [run_cable(integrator, 4000)[-1] for integrator in INTEGRATORS.values()]
    for end in ends[1:]:
        np.testing.assert_allclose(end[0], ends[0][0], atol=2e-6)
        np.testing.assert_allclose(end[1], ends[0][1], atol=2e-4)


@pytest.mark.kernel
@every_integrator
def test_recorded_intervals_are_the_states_of_one_run(integrator):
    together = run_cable(integrator, 4, 0.004, intervals=1)[-1]
    apart = run_cable(integrator, 4, 0.004, intervals=4)
    assert np.ptp(apart[:, 0], axis=0).max() > 0.0
    np.testing.assert_allclose(apart[-1], together, rtol=1e-12, atol=1e-13)


class Springs:
    """q'' = -q, in plain Python.   asked: for which q."""

    def __init__(self):
        self.asked = []


@index_reduced_rates.register(Springs)
def rates_of_springs(system, external, q, v, acceleration, rate):
    system.asked.append(q.copy())
    acceleration[:] = -q
    rate[:] = v


@accelerate_and_project.register(Springs)
def accelerate_springs(system, external, q, v, duration, acceleration, end_velocity):
    rates_of_springs(system, external, q, v, acceleration, end_velocity)
    end_velocity += duration * acceleration


@correct_position.register(Springs)
def correct_springs(system, external, q, tolerance, learning, correction):
    return 0.0


ALL_SCHEMES = [*(integrator.scheme() for integrator in INTEGRATORS.values()), Zhai(corrector=True)]


@pytest.mark.parametrize("scheme", ALL_SCHEMES, ids=str)
def test_a_step_evaluates_as_often_as_declared_and_last_at_its_end(scheme):
    (integrator,) = [i for i in INTEGRATORS.values() if i.scheme is type(scheme)]
    system, state = Springs(), integrator.allocate(2, 1)
    state.q[:], state.v[:] = [1.0, 2.0], [0.3, 0.0]
    loads = LoadHistory(np.zeros(1), np.zeros((0, 1)), np.zeros((3, len(integrator.stages), 0)))
    plain(advance.dispatch(type(scheme)))(scheme, system, loads, state, 0.1, 3, np.zeros((1, 3, 2)))
    assert len(system.asked) == 3 * integrator.evaluations(scheme)
    np.testing.assert_array_equal(system.asked[-1], state.q)


@every_integrator
def test_stability_limits_are_positive_and_frequency_limit_is_finite(integrator):
    scheme = integrator.scheme()
    assert 0.0 < frequency_limit(integrator, scheme) < 4.0
    assert decay_limit(integrator, scheme) > 0.0
    assert np.isfinite(decay_limit(integrator, scheme)) == integrator.stabilised


def by_hand(x, ratio):
    """One step h = 1 of q'' = -x^2 q - ratio x q' on (q, v, a[, a_(n-1)]), read off the papers."""
    y = ratio * x
    # q' = q + v + a / 2;  a' = -x^2 q' - y (v + a);  v' = v + (a + a') / 2
    q = np.array([1.0, 1.0, 0.5])
    a = -(x**2) * q - y * np.array([0.0, 1.0, 1.0])
    rattle = np.array([q, [0.0, 1.0, 0.5] + 0.5 * a, a])
    # q' = q + v + a - b / 2;  v' = v + 3 a / 2 - b / 2;  a' = -x^2 q' - y v';  b' = a
    q, v = np.array([1.0, 1.0, 1.0, -0.5]), np.array([0.0, 1.0, 1.5, -0.5])
    zhai = np.array([q, v, -(x**2) * q - y * v, [0.0, 0.0, 1.0, 0.0]])
    a = np.array([[0.0, 1.0], [-(x**2), -y]])
    powers = [np.linalg.matrix_power(a, k) / math.factorial(k) for k in range(5)]
    return {"RATTLE": rattle, "Zhai": zhai, "RK4": sum(powers)}


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 2.0, 5.0])
@every_integrator
def test_frequency_limit_with_damping_is_that_of_the_step_by_hand(integrator, ratio):
    limit = frequency_limit(integrator, integrator.scheme(), ratio)
    radius = [np.abs(np.linalg.eigvals(by_hand(x, ratio)[integrator.name])).max() for x in limit * TRIED]
    below, above = np.array(radius)[TRIED < 1.0], np.array(radius)[TRIED > 1.0]
    assert below.max() < 1.0 + 1e-7
    assert above.min() > 1.0 + 1e-4


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 2.0, 5.0])
def test_frequency_limit_of_rattle_with_damping_has_a_closed_form(ratio):
    """A step changes the sign of everything where x^2 / 4 + ratio x = 1."""
    exact = 2.0 * (np.hypot(1.0, ratio) - ratio)
    assert frequency_limit(INTEGRATORS["RATTLE"], Rattle(), ratio) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize(("ratios", "exact"), [((0.3, 0.30004, 0.29996), 1.4881), ((0.0, 1e-9, 9e-5), 2.0)])
def test_frequency_limits_of_close_ratios_are_one(ratios, exact):
    """A study over the damping of a body searches for it once."""
    found = [frequency_limit(INTEGRATORS["RATTLE"], Rattle(), ratio) for ratio in ratios]
    assert len(set(found)) == 1
    assert found[0] == pytest.approx(exact, rel=1e-3)


def test_frequency_limits_of_rk4_are_the_textbooks():
    """On the imaginary axis 2 sqrt(2), on the real one (critical damping) 2.7853."""
    found = [frequency_limit(INTEGRATORS["RK4"], RungeKutta4(), ratio) for ratio in (0.0, 2.0)]
    np.testing.assert_allclose(found, [np.sqrt(8.0), 2.785293563], rtol=1e-5)


@every_integrator
def test_names_find_their_integrators(integrator):
    assert find_integrator(integrator.name) is integrator
    assert all(0.0 <= stage <= 1.0 for stage in integrator.stages)


def test_an_unknown_name_is_refused_and_the_known_ones_are_listed():
    with pytest.raises(InputError, match="integrator = 'Euler' is unknown") as refusal:
        find_integrator("Euler")
    assert all(name in str(refusal.value) for name in INTEGRATORS)


@pytest.mark.parametrize(
    ("protocol", "arguments"),
    [
        (index_reduced_rates, 5),
        (accelerate_and_project, 6),
        (correct_position, 5),
        (partial(advance, SimpleNamespace()), 5),
    ],
)
def test_a_type_that_implements_no_protocol_is_refused_by_name(protocol, arguments):
    with pytest.raises(NotImplementedError, match=r"no .* for (object|SimpleNamespace)"):
        protocol(*([object()] + [None] * arguments))
