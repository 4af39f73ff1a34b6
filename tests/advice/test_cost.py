"""The cost model finds a + steps (b + c N) from pilots."""

import pytest

from exudyn_inext.advice.cost import predicted_seconds
from exudyn_inext.advice.pilot import INEXTENSIBLE, Choice
from tests.advice.analytic import Analytic


def choice(elements, step, integrator="RATTLE"):
    return Choice(INEXTENSIBLE, integrator, elements, step)


PILOTS = [choice(4, 1e-2), choice(6, 4e-3), choice(8, 2e-3), choice(12, 8e-4)]


@pytest.mark.parametrize("wanted", [choice(5, 5e-3), choice(20, 2e-3), choice(100, 1e-4)], ids=str)
def test_seconds_of_another_run_are_those_of_the_model(wanted):
    problem = Analytic()
    pilots = [problem.run(c) for c in PILOTS]
    assert predicted_seconds(pilots, wanted, problem.end_time) == pytest.approx(problem.seconds(wanted), 1e-6)


def test_an_integrator_that_has_run_is_judged_by_its_own_runs():
    problem = Analytic(costs={"RATTLE": 2.0})
    same, other = choice(8, 1e-5, "Zhai"), choice(32, 2e-5, "Zhai")  # overhead does not matter
    pilots = [problem.run(c) for c in [*PILOTS, same]]
    for wanted in (same, other):
        seconds = predicted_seconds(pilots, wanted, problem.end_time)
        assert seconds == pytest.approx(problem.seconds(wanted), 0.02)
    unknown = choice(16, 5e-4, "RK4")
    seconds = predicted_seconds(pilots[:-1], unknown, problem.end_time)
    assert seconds == pytest.approx(problem.seconds(choice(16, 5e-4)), 1e-6)


def test_no_part_of_the_cost_is_negative():
    problem = Analytic()
    pilots = [problem.run(c) for c in (choice(4, 1e-3), choice(8, 1e-3))]
    assert predicted_seconds(pilots, choice(1, 1.0), problem.end_time) >= 0.0
    tiny = predicted_seconds(pilots, choice(1, 1e-3), problem.end_time)
    assert 0.0 < tiny < pilots[0].seconds
