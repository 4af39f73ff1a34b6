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
    near, within, judged = conclude(*[row(8e-4)] * 10)
    assert near.endswith("the bar of 3 is kept.") and within.endswith("the bar of 1 is kept.")
    assert judged == "10 of 10 cases could be judged; 0 were refused."


@pytest.mark.parametrize("achieved", [4e-3, 3e-4])
def test_an_error_further_than_a_factor_3_from_the_prediction_is_a_miss(achieved):
    near, *_ = conclude(*[row(8e-4)] * 9, row(achieved, tolerance=1e-2))
    assert near.endswith("the bar of 3 is MISSED by 1 of 10.")


def test_one_of_ten_may_exceed_the_tolerance_and_two_may_not():
    within, beyond = row(8e-4), row(2.5e-3)
    assert conclude(*[within] * 9, beyond)[1].endswith("the bar of 1 is kept, missed by 1 of 10.")
    assert conclude(*[within] * 8, beyond, beyond)[1].endswith("the bar of 1 is MISSED by 2 of 10.")


def test_what_was_not_promised_is_not_broken():
    assert conclude(row(8e-4), row(2.5e-3, promises=False))[1].endswith("the bar of 1 is kept.")


def test_failures_are_told_and_refusals_counted():
    rows = [unjudged("refused: too far"), unjudged("failed: diverged"), unjudged("not judged: too uncertain")]
    failed, *_, judged = conclude(row(8e-4), *rows)
    assert failed.startswith("FAILED: rope") and judged == "1 of 4 cases could be judged; 1 were refused."
    assert "not measured" in conclude(*rows)[1]


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
