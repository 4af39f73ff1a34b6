"""Sentences say what was found, and stay sentences where something failed."""

from exudyn_inext.advice.advice import candidate_sentence, stretch_sentence
from exudyn_inext.advice.pilot import CONVENTIONAL, Choice, Pilot


def native(error, seconds=2.0, failure=""):
    choice = Choice(CONVENTIONAL, "generalizedAlpha", 8, 1e-3)
    return Pilot(choice, None, seconds, 100, failure, error)


def test_the_cheapest_rival_within_the_tolerance_is_compared():
    own = native(1e-4, seconds=0.5)
    said = candidate_sentence([native(1e-2, 1.0), native(5e-4, 3.0), native(1e-4, 4.0)], own, 1e-3)
    assert "takes 3 s" in said and "6 times the best explicit one" in said
    assert candidate_sentence([native(5e-4, 3.0)], None, 1e-3).endswith("takes 3 s.")


def test_rivals_that_are_not_good_enough_or_fail_are_said():
    assert "error of 0.01 after 1 s" in candidate_sentence([native(1e-2, 1.0), native(2e-2)], None, 1e-3)
    failed = [native(float("inf"), failure="Newton gave up")]
    assert candidate_sentence(failed, None, 1e-3) == "No conventional run reached its end: Newton gave up"


def test_stretch_is_compared_with_the_tolerance():
    wrong, right = (stretch_sentence(1e3, 0.01, 0.011, matters) for matters in (True, False))
    assert "axialStiffness = 1000 N, what is observed differs by 0.01, too much for the tolerance" in wrong
    assert "the inextensible model is the wrong one here" in wrong
    assert "within the tolerance of 0.011" in right
