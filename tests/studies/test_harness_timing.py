"""Timing: order of runs, what is timed, and what becomes of cases that fail."""

import gc

import numpy as np
import pytest

from exudyn_inext.errors import DivergenceError
from reference_models.trajectory import Case, Trajectory
from studies.harness.timing import in_turn, measure


def trajectory(value=0.0):
    return Trajectory(np.linspace(0.0, 1.0, 5), np.full((5, 3), value))


def rows_of(*cases, repeats=1, **options):
    """Rows of the cases, compared with a point at rest."""
    return [row for row, _ in measure(cases, repeats, trajectory(), **options)]


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
    rows = rows_of(*cases, repeats=3)
    assert order == list("abc" + "abc" + "bca" + "cab")  # each round begins with another one
    assert [row["repeats"] for row in rows] == [3, 3, 3]


def test_a_fixed_order_is_kept():
    order = []
    tasks = {name: lambda name=name: lambda: order.append(name) for name in "abc"}
    in_turn(tasks, 2, "fixed", turns=False)
    assert order == list("abc") * 3


def test_building_is_not_timed_and_running_is(burn):
    durations = iter([9.0, 3.0, 1.0, 4.0])
    prepare = lambda: burn(100.0) or (lambda: burn(next(durations)))  # noqa: E731
    measurement = in_turn({"a": prepare}, 3, "building")["a"]
    assert measurement.cpu_seconds == pytest.approx([3.0, 1.0, 4.0])
    assert (min(measurement.cpu_seconds), measurement.median) == pytest.approx((1.0, 3.0))
    assert measurement.warm_up == pytest.approx(9.0)


def test_what_a_run_returns_to_be_called_later_is_not_timed(burn):
    run = lambda: burn(2.0) or (lambda: burn(100.0) or trajectory(7.0))  # noqa: E731
    ((row, found),) = measure([case("later", run)], 1, trajectory())
    assert row["cpuSeconds"] == pytest.approx(2.0)
    assert (found.positions == 7.0).all() and row["errorMax"] == pytest.approx(7.0 * np.sqrt(3.0))


def test_garbage_collection_is_off_inside_and_on_again_afterwards():
    states = []
    rows_of(case("a", lambda: states.append(gc.isenabled()) or trajectory()))
    assert states == [False, False]
    assert gc.isenabled()


def test_failing_cases_keep_their_place_and_are_not_repeated():
    calls = []
    rows = rows_of(
        case("raises", lambda: calls.append(1) or raising(RuntimeError("no way"))()),
        case("diverges", raising(DivergenceError("too fast"))),
        case("nan", lambda: trajectory(float("nan"))),
        case("good", trajectory),
        repeats=2,
    )
    assert [row["status"] for row in rows] == [
        "failed: RuntimeError: no way",
        "diverged: too fast",
        "diverged",
        "ok",
    ]
    assert len(calls) == 1
    assert [row["cpuSeconds"] is None for row in rows] == [True, True, True, False]


def test_a_case_that_cannot_be_built_is_kept_too():
    (row,) = rows_of(case("a", trajectory, build=raising(ValueError("bad mesh"))))
    assert row["status"] == "failed: ValueError: bad mesh"


def test_a_task_that_is_no_case_fails_aloud():
    with pytest.raises(RuntimeError, match="no way"):
        in_turn({"a": lambda: raising(RuntimeError("no way"))}, 1, "aloud")


def test_garbage_collections_between_runs_see_new_objects_alone():
    frozen = []

    def run():
        frozen.append(gc.get_freeze_count())
        return trajectory()

    rows_of(case("a", run), repeats=2)
    assert min(frozen) > 1000 and gc.get_freeze_count() == 0
