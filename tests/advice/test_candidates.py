"""Conventional cables are refined as long as it pays, and judged by the right solution."""

import pytest

from exudyn_inext.advice.candidates import FEWEST_STEPS, climb, coarsen
from exudyn_inext.advice.pilot import CONVENTIONAL
from exudyn_inext.advice.survey import survey_meshes
from tests.advice.analytic import Analytic

NUMBERS = (4, 6, 8, 12, 16, 24)


@pytest.fixture
def problem():
    return Analytic(mesh=1.0, step=4.0)


def test_mesh_and_step_are_refined_together(problem):
    choices = [pilot.choice for pilot in climb(problem, NUMBERS, float("inf"))]
    assert [choice.elements for choice in choices] == list(NUMBERS)
    steps = [choice.step_size for choice in choices]
    assert steps == pytest.approx([problem.period / 2**rung for rung in range(len(NUMBERS))])
    assert {choice.formulation for choice in choices} == {CONVENTIONAL}


def test_the_climb_ends_before_what_is_too_expensive(problem):
    everything = climb(problem, NUMBERS, float("inf"))
    most = everything[3].seconds
    climbed = climb(problem, NUMBERS, most)
    assert 1 < len(climbed) < len(everything)
    assert all(pilot.seconds <= most for pilot in climbed[1:])
    assert len(climb(problem, NUMBERS, 0.0)) == 1


def test_beside_inextensible_runs_their_finest_one_judges(problem):
    survey = survey_meshes(problem, 1e-5, NUMBERS, 20.0)
    assert [pilot.choice.elements for pilot in survey.meshes] == list(NUMBERS)
    pilots = climb(problem, NUMBERS, float("inf"))
    for pilot in pilots:
        survey.compare_with_finest(pilot)
        true = problem.error(pilot.choice)
        assert true <= pilot.error <= true + 2.0 * survey.uncertainty + 1e-12


@pytest.mark.parametrize(("step_error", "factors"), [(1e-6, (2, 4)), (0.015, (2,)), (1.0, ())])
def test_steps_grow_as_long_as_they_are_accurate_enough(step_error, factors):
    problem = Analytic(mesh=1e-4, step=step_error)
    survey = survey_meshes(problem, 1e-5, NUMBERS, 20.0)
    (first,) = climb(problem, NUMBERS, 0.0)
    survey.compare_with_finest(first)
    pilots = coarsen(problem, survey, first)
    assert [pilot.choice.step_size / problem.period for pilot in pilots] == pytest.approx(factors)
    assert all(pilot.error <= survey.tolerance for pilot in pilots[:-1])
    assert not pilots or pilots[-1].choice.step_size <= problem.end_time / FEWEST_STEPS
