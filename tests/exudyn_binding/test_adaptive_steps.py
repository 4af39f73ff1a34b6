"""Steps that follow the stability limit, violent starts, and iterations that give up."""

import numpy as np
import pytest

from exudyn_inext import (
    CableShape,
    DivergenceError,
    ExplicitSettings,
    InputError,
    Rattle,
)
from exudyn_inext.cable.frequency import FrequencyTracker, largest_frequency
from exudyn_inext.cable.linked_cable import cable_system
from exudyn_inext.integrators import find_integrator
from exudyn_inext.integrators.integrator import no_loads, record
from exudyn_inext.integrators.linear_stability import LinearSystem
from exudyn_inext.run.cable_run import CableRun
from exudyn_inext.run.step_control import FrequencyFollower, StepControl, StepRule
from exudyn_inext.run.time_grid import TimeGrid
from exudyn_inext.system import index_reduced_rates
from tests.cables import linked_state, planar_pendulum, random_state
from tests.exudyn_binding.items import load_node, trajectory

PULL = 80.0  # [N]


@pytest.fixture
def pulled_ring(new_mbs, add_cable, add_sensor, solve):
    """(settings) -> report and path of the node where a ring of 1 m is pulled apart within 0.3 s."""

    def run(**explicit):
        mbs = new_mbs()
        ring = add_cable(mbs, shape=CableShape.Circle([0, 0], 0.5, 20), gravity=[0, 0, 0])

        def pull(sign):
            def force(mbs, t, load):
                return [sign * PULL * np.sin(np.pi * t / 0.6) ** 2, 0, 0]

            return force

        for place, sign in ((0, 1), (10, -1)):
            load_node(mbs, ring["nodes"][place], [1, 0, 0], loadVectorUserFunction=pull(sign))
        sensor = add_sensor(mbs, ring["nodes"][0])
        mbs.Assemble()
        return solve(mbs, 0.3, **explicit), trajectory(mbs, sensor)

    return run


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai"])
def test_adaptive_steps_survive_where_a_ring_loses_the_margin_of_its_curvature(
    pulled_ring, integrator, fault, without_smaller_steps
):
    report, exact = pulled_ring(integrator="RATTLE", stepSize=2e-5)
    step = 0.97 * report["bounds"].bending
    with pytest.raises(DivergenceError):
        pulled_ring(integrator=integrator, stepSize=step)
    report, path = pulled_ring(integrator=integrator, stepSize=step, adaptiveStep=True)
    assert report["stepSize"] < 0.9 * step
    assert 0.3 / step < report["steps"] < 1.3 * 0.3 / step
    assert np.ptp(exact[:, 1]) > 0.2
    np.testing.assert_allclose(path, exact, atol=1e-3)
    fault(
        f"{integrator}: a ring pulled tight, its stability limit falls below the step",
        f"stopped; with adaptiveStep it goes on, down to {report['stepSize'] / step:.0%} of the step",
    )


@pytest.mark.parametrize("links", [None, "closed with a moving hanger and a rod"])
def test_the_tracked_frequency_is_the_largest_one(links):
    measure = planar_pendulum(1)[0].measure
    state = linked_state(3, 6, 2, measure, links) if links else random_state(3, 6, 2, measure)
    system, shape = cable_system(state.cable, 0.0), state.q.shape
    tracker, rest = FrequencyTracker(system, shape), np.zeros(state.q.size)
    q, inputs = state.q.copy(), state.inputs.copy()
    inputs[rest.size :].reshape(-1, 3, 2)[:, 1] = 0.0
    for _ in range(12):
        q += 1e-3 * state.v
        expected = largest_frequency(system, inputs, q)
        a, rate = np.zeros(rest.size), np.zeros(rest.size)
        index_reduced_rates(system, inputs, q.ravel(), rest, a, rate)
        found = tracker.frequency(q, a.reshape(shape))
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("integrator", ["Zhai", "RATTLE", "RK4"])
def test_changes_of_the_step_keep_the_order(integrator):
    """Oscillator over 6 s in steps that double and halve."""
    scheme = find_integrator(integrator)
    errors = []
    for h in (0.01, 0.005):
        state, system = scheme.allocate(1, 1), LinearSystem(1.0, 0.0)
        state.q[0] = 1.0
        scheme.start(system, np.zeros(1), state)
        time, size = 0.0, h
        for step in range(round(8.0 / h)):
            ratio = (0.5, 2.0)[step % 2]
            scheme.change_step(state, ratio if step else 1.0)
            size = size * ratio if step else h
            loads = no_loads(1, len(scheme.stages))
            record(scheme, scheme.scheme(), system, loads, state, size, 1, np.zeros((1, 3, 1)))
            time += size
        errors.append(np.hypot(state.q[0] - np.cos(time), state.v[0] + np.sin(time)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(scheme.order, abs=0.3)


@pytest.fixture
def kinked(new_mbs, add_pendulum, add_sensor, solve):
    """(settings) -> path of the tip of two straight pieces with a right angle between them, released."""

    def run(**explicit):
        angles = np.repeat([0.0, 0.25 * np.pi, 0.5 * np.pi], [6, 1, 6])
        along = np.exp(0.5j * (angles[1:] + angles[:-1])) * np.sinc(np.diff(angles) / 2 / np.pi)
        places = np.append(0.0, np.cumsum(0.15 * along))
        positions, slopes = (np.stack([z.real, z.imag], axis=1) for z in (places, np.exp(1j * angles)))
        mbs = new_mbs()
        cable = add_pendulum(mbs, shape=CableShape(positions, slopes, elementLengths=0.15))
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        solve(mbs, 0.5, **explicit)
        return trajectory(mbs, sensor)

    return run


def test_a_kinked_start_survives_with_rattle_and_scaled_mass_where_zhai_fails(
    kinked, fault, without_smaller_steps
):
    exact = kinked(stepSize=1e-4)
    assert np.abs(exact[-1, 1:] - exact[0, 1:]).max() > 1.0
    for h, tolerance in ((1e-3, 4e-2), (5e-4, 1e-2)):
        np.testing.assert_allclose(kinked(stepSize=h, massScaling=0.25), exact, atol=tolerance)
    with pytest.warns(UserWarning, match="the energy has grown by 1"):  # and steps become shorter
        np.testing.assert_allclose(kinked(integrator="Zhai"), exact, atol=1e-2)
    for zhai in ({"stepSize": 2e-4}, {"stepSize": 1e-3, "massScaling": 0.25}):
        with pytest.raises(DivergenceError, match=r"diverged before t = 0\.0[12] s"):
            kinked(integrator="Zhai", **zhai)
    fault("a start with a right angle in it", "Zhai with a given step stops; RATTLE with scaled mass goes on")


def test_an_iteration_that_gives_up_says_where_and_keeps_the_last_good_state(mbs, add_pendulum, solve, fault):
    """At the smallest step."""
    add_pendulum(mbs)
    mbs.Assemble()
    message = (
        r"violated by \S+e-1\d after 3 iterations \(tolerance 1e-30\).*larger tolerance.*last good output"
    )
    with pytest.raises(DivergenceError, match=message):
        solve(mbs, 0.1, integrator=Rattle(tolerance=1e-30, iterations=3))
    assert np.isfinite(mbs.systemData.GetODE2Coordinates()).all()
    fault("a tolerance of RATTLE that round-off cannot reach", "stopped, with the violation that was reached")


def test_adaptive_steps_do_not_go_with_a_given_mass_scaling():
    with pytest.raises(InputError, match=r"massScaling = 0\.3 with adaptiveStep.*leave one"):
        ExplicitSettings(stepSize=1e-3, massScaling=0.3, adaptiveStep=True)


@pytest.mark.parametrize("frequency", [np.nan, np.inf])
def test_a_frequency_that_is_no_number_ends_the_run(frequency):
    control = StepControl(FrequencyFollower(StepRule(2.0, 0.95, 1e-3), lambda time: frequency))
    assert control.next(TimeGrid(0.0, 1, 10, 1e-3), 0, 1) is None


def test_the_frequency_is_looked_at_after_some_steps_only_and_after_rejections():
    looks, grid = [], TimeGrid(0.0, 20, 1, 1e-3)
    follower = FrequencyFollower(StepRule(2.0, 0.95, 1e-3), lambda time: looks.append(time) or 10.0, least=8)
    control = StepControl(follower)
    for interval in range(12):
        control.count(control.next(grid, interval, 1), 1, grid)
    control.reject()
    control.next(grid, 12, 1)
    np.testing.assert_allclose(looks, [0.0, 8e-3, 12e-3])


def test_looks_at_a_frequency_that_hardly_changes_become_rare_until_something_is_changed():
    looks, grid = [], TimeGrid(0.0, 200, 1, 1e-3)
    frequency = iter([10.0, 10.1, 10.2, 10.1, 10.1, 12.0, 12.1])
    follower = FrequencyFollower(
        StepRule(2.0, 0.95, 1e-3), lambda time: looks.append(time) or next(frequency), least=8, most=32
    )
    control = StepControl(follower)
    for interval in range(120):
        if interval == 100:  # 12 steps after the last look
            control.look_soon()
        control.count(control.next(grid, interval, 1), 1, grid)
    np.testing.assert_allclose(looks, [0.0, 8e-3, 24e-3, 56e-3, 88e-3, 100e-3, 108e-3])


def test_a_frequency_that_grows_without_end_is_named_as_the_cause(mbs, add_pendulum, solve, monkeypatch):
    frequencies = iter([700.0, np.inf])  # at the start, and after 32 steps
    monkeypatch.setattr(CableRun, "_present_frequency", lambda run, time: next(frequencies))
    add_pendulum(mbs)
    mbs.Assemble()
    with pytest.raises(DivergenceError, match="its fastest vibration asks for steps of a thousandth"):
        solve(mbs, 0.1, adaptiveStep=True)
