"""What became worse than in an earlier report is found beyond noise, and only that."""

import pytest

from studies.__main__ import main
from studies.harness.study import Study
from studies.report import command
from studies.report.compare import compare, machine_factor, match_rows
from studies.report.quantities import LIMIT, QUOTIENT, TIME, noise, quantity
from studies.report.sentences import compare_sentences, masked
from tests.studies.documents import ROWS, SENTENCES, document, row, store


def beside(old, new, **entries):
    """Of one study with these rows, then and now."""
    return compare({"a": document("a", old, **entries)}, {"a": document("a", new, **entries)})


def scaled(factor, rows=ROWS, **others):
    """All times by a factor; cases by a factor of their own."""
    return [
        r | {key: r[key] * factor * others.get(r["label"].replace(" ", ""), 1.0)
             for key in ("cpuSeconds", "cpuSecondsMin")}
        for r in rows
    ]  # fmt: skip


def test_equal_reports_have_no_changes():
    found = beside(ROWS, ROWS)
    assert not found.is_worse and len(found.changes) == 2 * len(ROWS) and found.times == len(ROWS)
    assert (found.slower, found.less_accurate, found.better, found.flipped) == ([], [], [], [])


def test_another_machine_makes_nothing_slower_and_its_factor_is_said():
    found = beside(ROWS, scaled(2.5))
    assert found.factor == pytest.approx(2.5) and not found.is_worse
    assert any("2.50, the median over 7 times" in sentence for sentence in found.summary)


def test_what_is_slower_than_the_others_is_found_on_another_machine():
    found = beside(ROWS, scaled(2.5, case3=1.3, case4=1.05, case5=0.5))
    assert [(c.row, c.key) for c in found.slower] == [("case 3", "cpuSeconds")]
    assert found.slower[0].factor == pytest.approx(1.3)
    assert [c.row for c in found.better] == ["case 5"] and found.is_worse


def test_native_rows_tell_the_machine_from_the_code():
    natives = [r | {"label": r["label"] + "n", "formulation": "conventional"} for r in ROWS[:3]]
    rows = match_rows({"a": document("a", natives + ROWS)}, {"a": document("a", natives + scaled(2.0))}).rows
    assert machine_factor(rows) == (pytest.approx(2.0), 10)
    assert machine_factor(rows, native_only=True) == (pytest.approx(1.0), 3)


def test_noise_follows_the_spread_of_the_repeats_and_is_larger_in_quick_runs():
    meaning = quantity(ROWS[0], "cpuSeconds")
    calm, restless = row("a", 1.0, cpuSecondsMin=0.99), row("a", 1.0, cpuSecondsMin=0.8)
    assert noise(meaning, calm, "cpuSeconds", False) == pytest.approx(0.1)
    assert noise(meaning, restless, "cpuSeconds", False) == pytest.approx(0.6)
    assert noise(meaning, calm, "cpuSeconds", True) == pytest.approx(0.2)
    restless_rows = [r | {"cpuSecondsMin": 0.8 * r["cpuSeconds"]} for r in ROWS]
    assert beside(restless_rows, scaled(1.0, restless_rows, case3=1.3)).slower == []


@pytest.mark.parametrize(("factor", "is_found"), [(1.005, False), (1.02, True), (0.9, False)])
def test_errors_count_from_one_percent(factor, is_found):
    found = beside(ROWS, [r | {"errorMax": r["errorMax"] * factor} for r in ROWS])
    assert bool(found.less_accurate) == is_found and not found.slower


def test_the_same_key_means_what_its_kind_of_row_says():
    assert (
        quantity({"kind": "ratio"}, "ratio").kind == QUOTIENT and quantity({"kind": "zeta"}, "ratio") is None
    )
    assert quantity({"kind": "change"}, "seconds").kind == TIME
    assert quantity({"kind": "swing"}, "hours").kind == LIMIT
    assert quantity({"kind": "zeta"}, "value") is None
    for kind in ("alone", "among bodies"):
        assert quantity({"kind": kind}, "share").kind == QUOTIENT
    assert quantity({"kind": "share"}, "share") is None


def test_shares_below_their_bar_are_noise_and_above_it_they_count():
    old = [{"kind": "alone", "label": "2D, steady, Zhai", "elements": 5, "share": 0.002}]
    assert beside(old, [old[0] | {"share": 0.028}]).slower == []
    assert beside(old, [old[0] | {"share": -0.01}]).better == []
    assert [c.key for c in beside(old, [old[0] | {"share": 0.06}]).slower] == ["share"]


def test_what_advice_takes_is_compared_and_what_it_predicts_is_not():
    same = {"kind": "advice", "label": "rope", "what": "measured", "value": 1e-3, "achievedSeconds": 0.1}
    errors = {"predictedError": 1e-4, "achievedError": 1e-4, "ratio": 1.0}
    old = [same | errors | {"referenceUncertainty": 1e-5}]
    new = [old[0] | {"referenceUncertainty": 2e-5, "predictedError": 1e-2, "achievedError": 1e-2}]
    found = beside(old, new)
    assert [c.key for c in found.less_accurate] == ["referenceUncertainty"]
    assert len(found.changes) == 2 and found.times == 1


def test_a_smaller_stable_step_is_worse_and_rounding_is_nothing():
    old = [{"kind": "zeta", "label": "Zhai", "value": 10.0, "found": 1e-3, "violation": 1e-15}]
    new = [old[0] | {"found": 0.9e-3, "violation": 8e-15}]
    assert [c.key for c in beside(old, new).less_accurate] == ["found"]


def test_rows_are_matched_by_what_they_are_about():
    old = [{"kind": "k", "label": "a", "value": v, "microseconds": 1.0} for v in (1.0, 2.0)]
    new = [old[1] | {"microseconds": 1.0}, {"kind": "k", "label": "a", "value": 3.0, "microseconds": 9.0}]
    found = beside(old, new)
    matched = found.matched
    assert (len(matched.rows), matched.added, matched.vanished) == (1, 1, 1) and found.slower == []


def test_a_row_that_fails_now_is_named():
    lost = [*ROWS[:-1], ROWS[-1] | {"status": "diverged: at 1 s", "cpuSeconds": None, "errorMax": None}]
    found = beside(ROWS, lost)
    assert [(r.label, old, new) for r, old, new in found.statuses] == [("case 7", "ok", "diverged")]
    assert found.is_worse and not beside(lost, ROWS).is_worse


@pytest.mark.parametrize(
    ("old", "new", "outcome"),
    [
        ("bar of 0.5 is kept (0.3)", "bar of 0.5 is kept (0.4)", (0, 0, 1, 0)),
        ("bar of 0.5 is kept (0.3)", "bar of 0.5 is MISSED (0.6)", (1, 0, 0, 0)),
        ("bar of 0.5 is MISSED (0.6)", "bar of 0.5 is kept (0.3)", (1, 0, 0, 0)),
        ("bar of 0.5 is kept (0.3)", "bar of 0.5 is undecided within noise (0.49)", (0, 1, 0, 0)),
        ("at most 0.3 (RK4); bar of 0.5 kept", "at most 0.3 (Zhai, N = 9); bar of 0.5 kept", (0, 0, 0, 1)),
        ("at most 0.3 (RK4); bar of 0.5 kept", "at most 0.6 (Zhai, N = 5); bar of 0.5 MISSED", (1, 0, 0, 0)),
        ("the limit is linear, up to 8", "the limit is NOT linear, up to 8", (1, 0, 0, 0)),
        ("pendulum: survives (1e+06 steps)", "pendulum: DIVERGES after 99.9 s (3e+04 steps)", (1, 0, 0, 0)),
    ],
)  # fmt: skip
def test_conclusions_are_compared_without_their_numbers(old, new, outcome):
    common = "3D: 17.3 us a step, 2.1e-3 m off."
    found = compare_sentences("a", [common, old], [common, new])
    assert (len(found.flipped), len(found.undecided), found.kept - 1, found.reworded) == outcome
    assert (found.added, found.vanished) == (0, 0)


def test_sentences_on_other_things_do_not_flip_each_other():
    found = compare_sentences("a", ["memory NOT flat over 6 scenes"], ["the motions are equal bit for bit"])
    assert (found.flipped, found.added, found.vanished) == ([], 1, 1)


def test_numbers_are_masked_but_not_within_names():
    assert masked("N = 1,000, 2.5e-3 s: -0.6 of RK44 (1e+06)") == "N = #, # s: # of RK44 (#)"


def test_another_machine_and_other_versions_are_named():
    old = document("a") | {"machine": {"cpu": "old one"}}
    old["versions"] = old["versions"] | {"numpy": "1.0", "commit": "0123456789abcdef"}
    text = " ".join(compare({"a": old}, {"a": document("a")}).summary)
    assert "old one" in text and "numpy 1.0" in text and "commit 0123456789" in text


@pytest.fixture
def run(tmp_path, monkeypatch):
    """(old rows, options) -> exit code of the report on ROWS."""
    new = store(tmp_path / "new", document("a"))
    monkeypatch.setattr(command, "find_studies", lambda: {"a": Study("a", "", None)})

    def run(rows, *options, old="old", quick=False):
        store(tmp_path / "old", document("a", rows, quick=quick))
        return main(["report", "--output", str(new), "--compare", str(tmp_path / old), *options])

    return run


def test_the_report_shows_what_changed(run, tmp_path, capsys):
    assert run(scaled(1.0, case3=0.5)) == 0
    assert "1 figures slower" in capsys.readouterr().out
    for name in ("report.md", "report.html"):
        text = (tmp_path / "new" / name).read_text()
        assert "Slower beyond noise:" in text and "case 3" in text and "2.000" in text


def test_strict_turns_what_is_worse_into_the_exit_code(run):
    slower = scaled(1.0, case3=0.5)
    assert run(slower, "--strict") == 1 and run(slower) == 0 and run(ROWS, "--strict") == 0


def test_files_of_an_earlier_report_do_as_well(run):
    assert run(ROWS, old="old/a.json") == 0


@pytest.mark.parametrize(
    ("old", "message"),
    [("no_such", "no such folder"), ("new/report.md", "NAME.json files"), ("empty", "holds no results")],
)
def test_what_is_no_report_is_refused(run, tmp_path, old, message, capsys):
    (tmp_path / "empty").mkdir()
    (tmp_path / "new" / "report.md").write_text("")
    assert run(ROWS, old=old) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("old", ["old", "old/a.json"])
def test_quick_and_full_results_are_not_compared(run, old, capsys):
    assert run(ROWS, old=old, quick=True) == 2
    assert "quick" in capsys.readouterr().err


def test_strict_without_an_earlier_report_is_refused(run, tmp_path, capsys):
    assert main(["report", "--output", str(tmp_path / "new"), "--strict"]) == 2
    assert "--strict" in capsys.readouterr().err


def test_sentences_of_a_report_are_part_of_it(run, tmp_path):
    run(ROWS)
    assert all(s.split("|")[0] in (tmp_path / "new" / "report.md").read_text() for s in SENTENCES)
