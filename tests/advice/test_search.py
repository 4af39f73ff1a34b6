"""On a problem in closed form, the advice is what trying everything gives."""

from itertools import product

import pytest

from exudyn_inext.advice.cost import predicted_seconds
from exudyn_inext.advice.pilot import INEXTENSIBLE, Choice
from exudyn_inext.advice.search import (
    FAMILIES,
    FINEST_EXTRAPOLATION,
    expected_error,
    extrapolated,
    most_accurate,
    try_families,
)
from exudyn_inext.advice.survey import survey_meshes
from exudyn_inext.errors import InputError, SceneError
from tests.advice.analytic import Analytic

NUMBERS = (4, 6, 8, 12, 16, 24, 32, 48)


def surveyed(problem, tolerance, numbers=NUMBERS, budget=20.0):
    return survey_meshes(problem, tolerance, numbers, budget)


def searched(problem, tolerance, **survey):
    search = surveyed(problem, tolerance, **survey)
    try_families(problem, search)
    return search


def all_choices(problem, survey):
    """All families on all meshes of the survey, and its own."""
    numbers = [pilot.choice.elements for pilot in survey.meshes]
    families = [
        Choice(INEXTENSIBLE, name, n, min(share * problem.step_limit(n, name), problem.period), theta)
        for n, (name, theta, share) in product(numbers, FAMILIES)
    ]
    return families + [pilot.choice for pilot in survey.meshes]


@pytest.mark.parametrize("mesh", [0.2, 1.0, 30.0])
@pytest.mark.parametrize("step", [0.0, 40.0, 2000.0])
@pytest.mark.parametrize("costs", [{}, {"Zhai": 0.8}, {"Zhai": 1.3}], ids=str)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_the_best_is_the_cheapest_of_all_families_within_the_tolerance(mesh, step, costs, tolerance):
    problem = Analytic(mesh, step, costs=costs)
    search = searched(problem, tolerance)
    within = [c for c in all_choices(problem, search) if problem.error(c) + search.uncertainty <= tolerance]
    cheapest = min(map(problem.seconds, within))
    assert problem.error(search.best.choice) <= tolerance
    assert search.best.seconds <= 1.02 * cheapest


def test_what_cannot_be_cheaper_is_not_run():
    problem = Analytic(mesh=0.2)
    search = searched(problem, 1e-3)
    assert len(problem.runs) < len(all_choices(problem, search))


@pytest.mark.parametrize(("mesh", "step"), [(1.0, 40.0), (10.0, 1.0), (0.1, 400.0)])
def test_uncertainty_and_errors_bound_the_true_ones(mesh, step):
    problem = Analytic(mesh, step)
    search = searched(problem, 1e-3)
    true = problem.error(search.finest.choice)
    assert true <= search.uncertainty <= 0.2 * 1e-3
    for tried in search.tried:
        true = problem.error(tried.choice)
        assert true <= tried.error <= true + 2.0 * search.uncertainty


def test_a_mesh_that_is_hopeless_is_run_but_once():
    problem = Analytic(mesh=30.0)
    search = searched(problem, 1e-3)
    hopeless = {t.choice.elements for t in search.tried if t.error > 5.0 * search.tolerance}
    assert len(hopeless) >= 3
    assert [c.elements for c in problem.runs if c.elements in hopeless] == sorted(hopeless)


def test_the_survey_ends_with_the_mesh_that_is_good_enough_and_not_later():
    problem = Analytic()
    ends = [surveyed(problem, tolerance).finest.choice.elements for tolerance in (1e-1, 1e-2, 1e-3, 1e-4)]
    assert ends == sorted(ends) and ends[0] == 8 < ends[-1] < NUMBERS[-1]


def test_the_survey_ends_with_its_budget():
    problem = Analytic()
    full, short = surveyed(problem, 1e-5), surveyed(problem, 1e-5, budget=0.02)
    assert 3 <= len(short.meshes) < len(full.meshes)
    assert sum(pilot.seconds for pilot in short.meshes) <= 0.02


@pytest.mark.parametrize("tolerance", [2e-4, 5e-5])
def test_error_and_seconds_of_an_extrapolated_mesh_are_near_the_true_ones(tolerance):
    problem = Analytic()
    survey = surveyed(problem, tolerance, numbers=(4, 6, 8))
    choice = extrapolated(problem, survey, tolerance)
    assert choice.elements > 8 and choice.step_size < problem.step_limit(choice.elements, "RATTLE")
    true, expected = problem.error(choice), expected_error(survey, choice)
    assert true <= expected <= tolerance and expected < 5.0 * true
    seconds = predicted_seconds(survey.meshes, choice, problem.end_time)
    assert seconds == pytest.approx(problem.seconds(choice), rel=0.02)


def test_the_coarsest_mesh_that_does_is_extrapolated():
    problem = Analytic()
    survey = surveyed(problem, 1e-4, numbers=(4, 6, 8))
    choice = extrapolated(problem, survey, 1e-4)
    coarser = Choice(INEXTENSIBLE, "RATTLE", choice.elements - 1, choice.step_size)
    assert expected_error(survey, coarser) > 1e-4 / 1.5 >= expected_error(survey, choice)


def test_a_mesh_that_cannot_be_built_is_not_extrapolated():
    tolerances = [1e-4, 9e-5, 8e-5, 7e-5]
    for tolerance in tolerances:
        problem = Analytic(buildable=lambda n: n % 4 == 0 or n == 6)
        survey = surveyed(problem, tolerance, numbers=(4, 6, 8))
        choice = extrapolated(problem, survey, tolerance)
        assert choice.elements % 4 == 0
        free = extrapolated(Analytic(), survey, tolerance)
        assert 0 <= choice.elements - free.elements < 4
    stubborn = Analytic(buildable=lambda n: n <= 8)
    assert extrapolated(stubborn, survey, tolerances[0]) is None


def test_what_is_too_far_is_not_extrapolated():
    problem = Analytic()
    survey = surveyed(problem, 1e-9, numbers=(4, 6, 8))
    assert extrapolated(problem, survey, 1e-9) is None
    within = 1.6 * survey.uncertainty * FINEST_EXTRAPOLATION ** -min(survey.order, 4.0)
    assert extrapolated(problem, survey, within).elements <= FINEST_EXTRAPOLATION * 8
    assert searched(problem, 1e-9, numbers=(4, 6, 8)).best is None


def test_candidates_that_fail_are_kept_and_not_chosen():
    problem = Analytic(failing=lambda c: c.integrator == "Zhai" or c.mass_scaling > 0)
    search = searched(problem, 1e-3)
    failed = [tried for tried in search.tried if not tried.works]
    assert failed and all(tried.error == float("inf") for tried in failed)
    assert search.best.choice.integrator == "RATTLE" and search.best.works
    assert most_accurate(search.tried, 1e9).works


def test_surveyed_meshes_that_fail_are_kept_and_left_out():
    problem = Analytic(failing=lambda c: c.elements == 6)
    search = searched(problem, 1e-2)
    assert [pilot.choice.elements for pilot in search.tried if pilot.failure] == [6]
    assert 6 not in [pilot.choice.elements for pilot in search.meshes]


def test_numbers_that_cannot_be_built_are_left_out_until_too_few_are_left():
    even = Analytic(buildable=lambda n: n % 8 == 0)
    assert [pilot.choice.elements for pilot in surveyed(even, 1e-2).meshes] == [8, 16, 24]
    with pytest.raises(InputError, match=r"only 2 of numbersOfElements = \(7, 8, 9, 16\).*9 elements cannot"):
        surveyed(even, 1e-2, numbers=(7, 8, 9, 16))


def test_too_few_that_reach_their_end_are_refused_with_the_reason():
    problem = Analytic(failing=lambda c: c.elements > 6)
    with pytest.raises(InputError, match=r"only 2 of numbersOfElements.*diverged.*finer"):
        surveyed(problem, 1e-2)


def test_solutions_that_do_not_converge_are_refused_with_their_distances():
    problem = Analytic()
    calm = problem.values
    problem.values = lambda c: calm(c) + (0.1 if c.elements % 8 else -0.1)
    message = r"12 and 16 elements do not converge: they differ by 0\.\d+ and 0\.\d+.*shorten endTime"
    with pytest.raises(SceneError, match=message):
        surveyed(problem, 1e-6, numbers=(4, 6, 8, 12, 16))


def test_the_most_accurate_run_within_a_budget():
    problem = Analytic()
    tried = searched(problem, 1e-4).tried
    seconds = sorted(one.seconds for one in tried)
    middle = seconds[len(seconds) // 2]
    found = most_accurate(tried, middle)
    assert found.seconds <= middle
    assert found.error == min(one.error for one in tried if one.seconds <= middle)
    assert most_accurate(tried, 0.5 * seconds[0]) is None
    broken = problem.run(tried[0].choice)
    broken.error = 0.0
    assert most_accurate([broken], 1e9) is broken
