"""Timing: order of runs, what is timed, and what becomes of cases that fail."""

import gc

import numpy as np
import pytest

from exudyn_inext.errors import DivergenceError
from reference_models.trajectory import Case, Trajectory
from studies.harness.timing import measure


def trajectory(value=0.0):
    return Trajectory(np.array([0.0, 1.0]), np.full((2, 3), value))


def case(label, run, build=lambda: None):
    def prepare():
        build()
        return run

    return Case(label, "conventional", "generalizedAlpha", 1, 0.1, 10, prepare)


def raising(error):
    def run():
        raise error

    return run


@pytest.fixture
def burn(monkeypatch):
    """burn(seconds) on a clock of its own, so that no busy machine can upset a test."""
    clock = [0.0]
    monkeypatch.setattr("time.process_time", lambda: clock[0])

    def burn(seconds):
        clock[0] += seconds

    return burn


def test_cases_are_warmed_up_and_then_repeated_in_turn():
    order = []
    cases = [case(name, lambda name=name: order.append(name) or trajectory()) for name in "abc"]
    measurements = measure(cases, repeats=5)
    assert order == list("abc") * 6
    assert [len(measurement.cpu_seconds) for measurement in measurements] == [5, 5, 5]


def test_building_is_not_timed_and_running_is(burn):
    durations = iter([9.0, 3.0, 1.0, 4.0])
    run = lambda: burn(next(durations)) or trajectory()  # noqa: E731
    (measurement,) = measure([case("a", run, build=lambda: burn(100.0))], repeats=3)
    assert measurement.cpu_seconds == pytest.approx([3.0, 1.0, 4.0])
    assert (measurement.minimum, measurement.median) == pytest.approx((1.0, 3.0))
    assert measurement.warm_up == pytest.approx(9.0)


def test_what_a_run_returns_to_be_called_later_is_not_timed(burn):
    run = lambda: burn(2.0) or (lambda: burn(100.0) or trajectory(7.0))  # noqa: E731
    (measurement,) = measure([case("later", run)], repeats=1)
    assert measurement.cpu_seconds == pytest.approx([2.0])
    assert (measurement.trajectory.positions == 7.0).all()


def test_garbage_collection_is_off_inside_and_on_again_afterwards():
    states = []
    measure([case("a", lambda: states.append(gc.isenabled()) or trajectory())], repeats=1)
    assert states == [False, False]
    assert gc.isenabled()


def test_failing_cases_keep_their_place_and_are_not_repeated():
    calls = []
    cases = [
        case("raises", lambda: calls.append(1) or raising(RuntimeError("no way"))()),
        case("diverges", raising(DivergenceError("too fast"))),
        case("nan", lambda: trajectory(float("nan"))),
        case("good", trajectory),
    ]
    measurements = measure(cases, repeats=2)
    assert [measurement.status for measurement in measurements] == [
        "failed: RuntimeError: no way",
        "diverged: too fast",
        "diverged",
        "ok",
    ]
    assert len(calls) == 1
    assert [measurement.median is None for measurement in measurements] == [True, True, True, False]


def test_a_case_that_cannot_be_built_is_kept_too():
    (measurement,) = measure([case("a", trajectory, build=raising(ValueError("bad mesh")))], 1)
    assert measurement.status == "failed: ValueError: bad mesh"


def test_progress_hears_of_every_run():
    heard = []
    measure([case("a", trajectory), case("b", raising(RuntimeError()))], 2, heard.append)
    assert heard == ["a", "b"] * 3


def test_garbage_collections_between_runs_see_new_objects_alone():
    frozen = []

    def run():
        frozen.append(gc.get_freeze_count())
        return trajectory()

    measure([case("a", run)], 2)
    assert min(frozen) > 1000 and gc.get_freeze_count() == 0
