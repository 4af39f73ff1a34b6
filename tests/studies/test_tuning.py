"""A search for the cheapest candidate, by made-up runs; and the error that it looks at."""

import numpy as np
import pytest

from studies.harness.coupled_runs import distance
from studies.harness.tuning import Attempt, choose, search, vary

BOUNDS = (1e-2, 1e-3)


def attempts_of(errors, seconds=lambda candidate: 1.0):
    """What gives the attempt of a candidate, and a list of those that were asked for."""
    asked = []

    def attempt(candidate):
        asked.append(candidate)
        return Attempt(candidate, errors[candidate], seconds(candidate))

    return attempt, asked


def test_a_series_ends_where_smaller_steps_do_not_help():
    attempt, asked = attempts_of({"a": None, "b": 0.5, "c": 0.5, "d": 2e-2, "e": 1.99e-2, "f": 1e-4})
    search(["abcdef"], attempt, BOUNDS, "")
    assert asked == list("abcde")  # a failure and large errors are no reason to stop


def test_a_series_ends_where_its_runs_are_dear():
    seconds = {"a": 1.0, "b": 4.0, "c": 6.0, "d": 8.0}
    attempt, asked = attempts_of({"a": 9e-4, "b": 5e-2, "c": 3e-2, "d": 1e-2}, seconds.get)
    search(["a", "bcd"], attempt, BOUNDS, "")
    assert asked == list("abc")


def test_variants_are_tried_of_the_cheapest_runs_within_a_bound():
    found = [Attempt("a", 9e-3, 1.0), Attempt("b", 0.5, 0.1), Attempt("c", 5e-4, 3.0)]
    attempt, asked = attempts_of({"A": 1e-3, "C": 1e-3})
    vary(found, attempt, BOUNDS, lambda candidate: [candidate, candidate.upper()])
    assert asked == ["A", "C"]


def test_the_cheapest_run_within_a_bound_is_that_of_the_least_median(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("time.process_time", lambda: clock[0])
    times = {"a": iter([9.0, 3.0, 5.0, 4.0]), "b": iter([9.0, 1.0, 2.0, 7.0])}

    def prepare(candidate):
        return lambda: clock.append(clock.pop() + next(times[candidate]))

    found = [Attempt(name, 5e-3, seconds) for name, seconds in (("a", 1.0), ("b", 1.2), ("c", 2.0))]
    groups = {"any": ([*found, Attempt("d", 0.5, 0.1)], 1e-2), "a": (found[:1], 1e-2), "none": (found, 1e-4)}
    best = {"any": Attempt("b", 5e-3, 2.0), "a": Attempt("a", 5e-3, 4.0)}
    assert choose(groups, prepare, 3) == best


def test_errors_are_of_displacements_over_the_largest_one():
    times = np.linspace(0.0, 1.0, 5)
    path = np.stack([times, 2.0 * times, 0 * times, 0 * times], axis=1)[:, None]
    shifted, half = path + np.array([0, 0, 7.0, 0]), path * [1, 0.5, 1, 1]
    assert distance(shifted, path) == 0.0
    assert distance(half, path) == pytest.approx(np.sqrt((times**2).mean()) / 2)
    assert distance(path + np.array([1e-3, 0, 0, 0]), path) is None and distance(path[:-1], path) is None
    assert distance(path * np.nan, path) is None
