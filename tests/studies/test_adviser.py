"""What is said of advice follows from the rows: what was kept, the misses, and what could not be judged."""

import pytest

from exudyn_inext import AdviceSettings, InputError
from reference_models.scenes import Scene
from studies import adviser
from studies.adviser import validation_scenes
from studies.harness.study import Results


def row(achieved, predicted=1e-3, tolerance=2e-3, promises=True, **entries):
    return {
        "kind": "advice", "label": "rope", "what": "measured", "value": tolerance, "choice": "a choice",
        "status": "ok", "meetsTolerance": promises, "predictedError": predicted, "achievedError": achieved,
        "ratio": achieved / predicted, **entries,
    }  # fmt: skip


def unjudged(status):
    return {"kind": "advice", "label": "rope", "what": "measured", "value": 1e-3, "status": status}


def conclude(*rows):
    return adviser.conclude(Results(False, rows))


def test_all_kept():
    total, near, kept = conclude(*[row(8e-4)] * 10)
    assert "10 cases: 10 judged, 0 refused, 0 failed" in total
    assert "in 10 of 10 cases (bar of 100 % kept)" in near and "in 10 of 10 cases" in kept


@pytest.mark.parametrize("achieved", [4e-3, 3e-4])
def test_an_error_further_than_a_factor_3_from_the_prediction_is_a_miss(achieved):
    _, near, _, miss = conclude(*[row(8e-4)] * 9, row(achieved, tolerance=1e-2))
    assert "in 9 of 10 cases (bar of 100 % MISSED)" in near
    assert miss.startswith("Miss: rope (measured), tolerance 0.01: a choice, predicted 0.001, achieved")


def test_one_of_ten_may_exceed_the_tolerance_and_two_may_not():
    within, beyond = row(8e-4), row(2.5e-3)
    *_, kept, miss = conclude(*[within] * 9, beyond)
    assert "in 9 of 10 cases that were said to be (bar of 90 % kept)" in kept and "achieved 0.0025" in miss
    sentences = conclude(*[within] * 8, beyond, beyond)
    assert "in 8 of 10" in sentences[2] and "MISSED" in sentences[2] and len(sentences) == 5


def test_what_was_not_promised_is_not_broken():
    _, _, kept = conclude(row(8e-4), row(2.5e-3, promises=False))
    assert "in 1 of 1 cases" in kept


def test_refusals_and_failures_are_counted_and_not_judged():
    rows = [unjudged("refused: too far"), unjudged("FAILED: diverged"), unjudged("not judged: too uncertain")]
    assert "4 cases: 1 judged, 1 refused, 1 failed" in conclude(row(8e-4), *rows)[0]
    assert conclude(*rows) == ["None of 3 cases could be judged."]


def test_validation_scenes_are_of_many_kinds_and_differ_from_each_other():
    scenes = validation_scenes()
    assert all(isinstance(scene, Scene) for scene in scenes)
    assert len({scene.name for scene in scenes}) == len(scenes) >= 10


def test_a_row_holds_what_was_promised_and_what_came_of_it(monkeypatch):
    """Coarser reference, fewer pilots."""
    monkeypatch.setattr(adviser, "FINE", 12)
    monkeypatch.setattr(adviser, "COARSER", 10)
    monkeypatch.setattr(adviser, "AdviceSettings", lambda: AdviceSettings(numbersOfElements=(4, 6, 8)))
    rope = validation_scenes()[1]
    judged, few = adviser._rows_of(rope, [1e-2])
    assert (judged["label"], judged["what"], few["what"]) == (rope.name, "measured", "few meshes")
    assert judged["value"] == 1e-2 * rope.cable.length and judged["status"] == "ok"
    assert judged["ratio"] == pytest.approx(judged["achievedError"] / judged["predictedError"])
    assert judged["achievedError"] <= judged["value"] and judged["meetsTolerance"]
    assert judged["achievedSeconds"] > 0 and judged["pilotSeconds"] > 0
    monkeypatch.setattr(adviser, "LEAST_OVER_UNCERTAINTY", 1e6)
    uncertain, _ = adviser._rows_of(rope, [1e-2])
    assert uncertain["status"].startswith("not judged") and "achievedError" not in uncertain


def test_advice_that_is_refused_is_a_row_with_the_reason(monkeypatch):
    def refuse(*arguments, **options):
        raise InputError("too far")

    monkeypatch.setattr(adviser, "advise_scene", refuse)
    rows = adviser._rows_of(validation_scenes()[1], [1e-2])
    assert [r["status"] for r in rows] == ["refused: too far"] * 2
