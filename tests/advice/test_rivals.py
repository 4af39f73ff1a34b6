"""Conventional cables are refined as long as it pays, and judged by the right solution."""

import pytest

from exudyn_inext.advice.pilot import CONVENTIONAL
from exudyn_inext.advice.rivals import climb, judge_by_themselves, judge_rivals
from exudyn_inext.advice.search import Search
from exudyn_inext.advice.survey import survey_meshes
from tests.advice.analytic import Analytic

NUMBERS = (4, 6, 8, 12, 16, 24)


@pytest.fixture
def problem():
    return Analytic(mesh=1.0, step=4.0)


@pytest.fixture
def survey(problem):
    return survey_meshes(problem, 1e-5, NUMBERS, 20.0)


def test_mesh_and_step_are_refined_together(problem, survey):
    choices = [pilot.choice for pilot in climb(problem, survey, float("inf"))]
    assert [choice.elements for choice in choices] == list(NUMBERS)
    steps = [choice.step_size for choice in choices]
    assert steps == pytest.approx([problem.period / 2**rung for rung in range(len(NUMBERS))])
    assert {choice.formulation for choice in choices} == {CONVENTIONAL}


def test_the_climb_ends_before_what_is_too_expensive(problem, survey):
    everything = climb(problem, survey, float("inf"))
    most = everything[3].seconds
    climbed = climb(problem, survey, most)
    assert 1 < len(climbed) < len(everything)
    assert all(pilot.seconds <= most for pilot in climbed[1:])
    assert len(climb(problem, survey, 0.0)) == 1


def test_beside_inextensible_runs_their_finest_one_judges(problem, survey):
    search = Search(1e-3, survey)
    pilots = climb(problem, survey, float("inf"))
    judge_rivals(search, pilots)
    for pilot, tried in zip(pilots, search.tried, strict=True):
        true = problem.error(pilot.choice)
        assert true <= tried.error <= true + 2.0 * survey.uncertainty + 1e-12


def test_by_themselves_their_errors_are_near_the_true_ones(problem, survey):
    pilots = climb(problem, survey, float("inf"))
    for tried in judge_by_themselves(pilots):
        true = problem.error(tried.pilot.choice)
        assert true <= 1.01 * tried.error <= 1.5 * true


def test_those_that_fail_judge_nobody(survey):
    shaky = Analytic(mesh=1.0, step=4.0, failing=lambda c: c.elements == NUMBERS[-1])
    pilots = climb(shaky, survey, float("inf"))
    judged = judge_by_themselves(pilots)
    assert [tried.pilot for tried in judged if tried.works] == pilots[:-1]
    assert judge_by_themselves(pilots[-1:]) == [] == judge_by_themselves(pilots[:1])
