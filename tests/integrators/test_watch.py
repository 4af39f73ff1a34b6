"""What a watch over a run sees, and what it does not mistake for trouble."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_inext.cable.chain import build_chain
from exudyn_inext.cable.index_reduction import CableSystem
from exudyn_inext.called_system import called
from exudyn_inext.compiled import placed
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.integrators.integrator import LoadHistory, record
from exudyn_inext.loads.gravity import gravity_force
from exudyn_inext.run.watch import (
    ALL_IS_WELL,
    ENERGY,
    FAILED,
    NOT_FINITE,
    STEPS_WITH_POWER,
    build_watch,
    go_back,
    open_account,
    record_watched,
)
from exudyn_inext.system import KINETIC, report_energy
from tests.cables import planar_pendulum

TOLERANCE, MOST = 0.003, 0.009


class WatchedPendulum:
    """The planar pendulum, N = 5, with a watch that inspects every `every` steps."""

    def __init__(self, name, every=STEPS_WITH_POWER, damping=0.0, force=None):
        cable, gravity = planar_pendulum(5)
        cable = replace(cable, section=replace(cable.section, bending_damping=damping))
        self.integrator = INTEGRATORS[name]
        self.system = CableSystem(build_chain(cable), 100.0)
        self.called = called(self.system, *self.integrator.calls, report_energy)
        self.constant = gravity_force(cable, gravity).ravel()
        self.pattern = np.zeros((int(force is not None), self.constant.size))
        self.pattern[:, -3] = 1.0
        self.force = force
        self.state = self.integrator.allocate(self.constant.size, self.constant.size)
        self.state.q[:] = cable.reference.ravel()
        self.integrator.start(self.system, self.constant, self.state)
        self.watch = build_watch(self.state, every, TOLERANCE, self.pattern, most=MOST)
        report_energy(
            self.system, self.constant, *self.state[:3], self.watch.force, self.watch.present_report
        )
        open_account(self.watch, self.state, 1e-12, self.watch.present_report[KINETIC])
        self.account = self.watch.account[0]

    def loads(self, h, steps):
        times = h * np.add.outer(np.arange(steps), self.integrator.stages)
        factor = np.zeros((*times.shape, 0)) if self.force is None else self.force(times)[..., None]
        return LoadHistory(self.constant, self.pattern, factor)

    def run(self, h, steps):
        """Steps that went well, and q, v, a after each of them."""
        history = np.zeros((steps, 3, self.constant.size))
        scheme, loads = self.integrator.scheme(), self.loads(h, steps)
        good = record_watched(scheme, self.called, loads, self.state, h, 1, history, placed(self.watch))
        if good < steps:
            go_back(self.watch, self.state)
        return good, history[:good]


def unwatched(name, h, steps):
    plain = WatchedPendulum(name)
    history = np.zeros((steps, 3, plain.constant.size))
    record(
        plain.integrator,
        plain.integrator.scheme(),
        plain.system,
        plain.loads(h, steps),
        plain.state,
        h,
        1,
        history,
    )
    return history


def test_the_slow_growth_of_zhai_is_stopped_long_before_the_run_explodes(fault):
    h, steps = 2.5e-3, 14_000
    good, history = WatchedPendulum("Zhai").run(h, steps)
    exploded = int(np.argmin(np.isfinite(unwatched("Zhai", h, steps)).all(axis=(1, 2))))
    assert good < exploded - 1000
    slopes = history[:, 0].reshape(-1, 6, 2, 2)[:, :, 1]
    assert np.abs((slopes**2).sum(axis=2) - 1.0).max() < 0.02
    fault(
        "Zhai gains energy slowly, near its stability limit",
        f"stopped {exploded - good} steps before it would have exploded, after {good}",
    )


def test_slow_growth_is_called_by_its_name_and_leaves_the_last_good_state():
    pendulum = WatchedPendulum("Zhai")
    good, history = pendulum.run(2.5e-3, 14_000)
    assert pendulum.account.trouble == ENERGY
    assert MOST < pendulum.watch.account[FAILED].error < 2 * MOST
    assert good % STEPS_WITH_POWER == 0
    for field, last in zip(("q", "v", "a"), history[-1], strict=True):
        np.testing.assert_array_equal(getattr(pendulum.state, field), last)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_a_violent_divergence_is_stopped_within_a_few_inspections(name, fault):
    pendulum = WatchedPendulum(name)
    good, _ = pendulum.run(5e-3, 2000)
    assert pendulum.account.trouble != ALL_IS_WELL
    broken = ~(np.abs(unwatched(name, 5e-3, 2000)[:, 0]).max(axis=1) < 1e3)
    assert good <= int(np.argmax(broken)) < 200
    assert np.isfinite(pendulum.state.q).all() and np.abs(pendulum.state.q).max() < 2.0
    fault(
        f"{name}: a step of 5e-3 s, far above the stability limit",
        f"last good state kept, after {good} steps",
    )


def test_what_is_not_finite_is_stopped_at_the_next_inspection(fault):
    pendulum = WatchedPendulum("RATTLE", force=lambda t: np.where(t > 0.1, np.nan, 0.0))
    good, _ = pendulum.run(1e-3, 200)
    assert pendulum.account.trouble == NOT_FINITE
    assert 100 - STEPS_WITH_POWER <= good <= 100
    fault("a load that becomes NaN at step 100", f"last good state kept, after {good} steps")


@pytest.mark.parametrize("name", INTEGRATORS)
def test_damping_takes_energy_that_is_accounted_for(name):
    """Bending damping takes 0.005 J of a swing of 0.55 J; the account is balanced 30 times better."""
    pendulum = WatchedPendulum(name, damping=2e-4)
    start = pendulum.account.start
    good, _ = pendulum.run(2.5e-4, 16_000)
    lost = start + pendulum.account.work - (pendulum.watch.energy_report[0] + pendulum.watch.energy_report[1])
    by_gravity = pendulum.constant @ (pendulum.state.q - planar_pendulum(5)[0].reference.ravel())
    damped = by_gravity - pendulum.account.work
    assert good == 16_000
    assert damped > 0.005
    assert abs(lost) < damped / 30


@pytest.mark.parametrize("name", INTEGRATORS)
def test_work_of_a_force_in_time_is_accounted_for(name):
    pendulum = WatchedPendulum(name, force=lambda t: 0.05 * np.sin(8.0 * t))
    good, _ = pendulum.run(1e-3, 4000)
    energy = pendulum.watch.energy_report[0] + pendulum.watch.energy_report[1]
    by_gravity = pendulum.constant @ (pendulum.state.q - planar_pendulum(5)[0].reference.ravel())
    assert good == 4000
    assert energy - pendulum.account.start == pytest.approx(pendulum.account.work, abs=1e-3)
    assert abs(pendulum.account.work - by_gravity) > 0.02  # what the force did


@pytest.mark.parametrize("every", [1, 7, 64])
@pytest.mark.parametrize("name", INTEGRATORS)
def test_watching_changes_no_bit(name, every):
    _, watched = WatchedPendulum(name, every).run(2e-3, 100)
    np.testing.assert_array_equal(watched, unwatched(name, 2e-3, 100))


def test_intervals_longer_and_shorter_than_those_between_inspections_give_the_same():
    ends = []
    for steps in (1, 5, 50, 500):
        pendulum = WatchedPendulum("RATTLE")
        history = np.zeros((500 // steps, 3, pendulum.constant.size))
        scheme, loads = pendulum.integrator.scheme(), pendulum.loads(2e-3, 500)
        good = record_watched(
            scheme, pendulum.called, loads, pendulum.state, 2e-3, steps, history, placed(pendulum.watch)
        )
        assert good == len(history)
        ends.append(history[-1])
    for end in ends[1:]:
        np.testing.assert_array_equal(end, ends[0])
