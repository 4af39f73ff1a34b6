"""What became worse than in an earlier report is found beyond noise, and only that."""

import pytest

from studies.__main__ import main
from studies.harness.study import Study
from studies.report import command
from studies.report.compare import compare
from tests.studies.documents import ROWS, SENTENCES, document, store


def beside(old, new, **entries):
    """Of one study with these rows, then and now."""
    return compare({"a": document("a", old, **entries)}, {"a": document("a", new, **entries)})


def scaled(factor, **others):
    """All times by a factor; cases by a factor of their own."""
    return [
        r | {"cpuSeconds": r["cpuSeconds"] * factor * others.get(r["label"].replace(" ", ""), 1.0)}
        for r in ROWS
    ]


def test_equal_reports_have_no_changes():
    found = beside(ROWS, ROWS)
    assert not found.is_worse and (found.worse, found.better, found.adverse) == ([], [], [])
    assert (found.matched, found.added, found.vanished) == (len(ROWS), 0, 0)


def test_what_is_slower_than_the_others_is_found_on_another_machine():
    found = beside(ROWS, scaled(2.5, case3=1.3, case4=1.2, case5=0.5))
    assert found.factor == pytest.approx(2.5) and "2.50" in found.summary[1]
    ((row, key, factor),) = [(c.row, c.key, c.factor) for c in found.worse]
    assert (row, key) == ("case 3, N = 5", "cpuSeconds") and factor == pytest.approx(1.3)
    assert [c.row for c in found.better] == ["case 5, N = 5"] and found.is_worse


def test_noise_is_larger_in_quick_runs():
    assert beside(ROWS, scaled(1.0, case3=1.3), quick=True).worse == []
    assert beside(ROWS, scaled(1.0, case3=1.6), quick=True).worse


@pytest.mark.parametrize(("factor", "is_found"), [(1.005, False), (1.02, True), (0.9, False)])
def test_errors_count_from_one_percent(factor, is_found):
    assert bool(beside(ROWS, [r | {"errorMax": r["errorMax"] * factor} for r in ROWS]).worse) == is_found


def test_a_smaller_stable_step_is_worse():
    old = [{"kind": "zeta", "label": "Zhai", "value": 10.0, "found": 1e-3}]
    assert [c.key for c in beside(old, [old[0] | {"found": 0.9e-3}]).worse] == ["found"]
    assert beside(old, [old[0] | {"found": 1.1e-3}]).worse == []


def test_rows_are_matched_by_what_they_are_about():
    old = [{"kind": "k", "label": "a", "value": v, "microseconds": 1.0} for v in (1.0, 2.0)]
    new = [old[1], {"kind": "k", "label": "a", "value": 3.0, "microseconds": 9.0}]
    found = beside(old, new)
    assert (found.matched, found.added, found.vanished) == (1, 1, 1) and found.worse == []


def test_a_row_that_fails_now_is_named():
    lost = [*ROWS[:-1], ROWS[-1] | {"status": "diverged: at 1 s", "cpuSeconds": None, "errorMax": None}]
    found = beside(ROWS, lost)
    assert found.statuses == [("case 7, N = 5", "a", "ok", "diverged")]
    assert found.is_worse and not beside(lost, ROWS).is_worse


@pytest.mark.parametrize(
    ("old", "new", "is_found"),
    [
        ("bar of 0.5 is MISSED (0.6)", "bar of 0.5 is MISSED (0.7)", False),
        ("bar of 0.5 is kept (0.3)", "bar of 0.5 is MISSED (0.6)", True),
        ("bar of 0.5 is MISSED (0.6)", "bar of 0.5 is kept (0.3)", False),
    ],
)
def test_conclusions_that_are_adverse_now_are_found_whatever_their_numbers(old, new, is_found):
    then, now = (document("a", conclusions=[text]) for text in (old, new))
    assert compare({"a": then}, {"a": now}).is_worse is is_found


@pytest.fixture
def run(tmp_path, monkeypatch):
    """(old rows, options) -> exit code of the report on ROWS."""
    new = store(tmp_path / "new", document("a"))
    monkeypatch.setattr(command, "find_studies", lambda: {"a": Study("a", "", None)})

    def run(rows, *options, old="old", quick=False):
        store(tmp_path / "old", document("a", rows, quick=quick))
        return main(["report", "--output", str(new), "--compare", str(tmp_path / old), *options])

    return run


def test_the_report_shows_what_changed_and_strict_makes_it_the_exit_code(run, tmp_path, capsys):
    slower = scaled(1.0, case3=0.5)
    assert run(slower) == 0 and run(slower, "--strict") == 1 and run(ROWS, "--strict") == 0
    assert "1 figures worse" in capsys.readouterr().out
    run(slower, old="old/a.json")
    for name in ("report.md", "report.html"):
        text = (tmp_path / "new" / name).read_text()
        assert "Worse beyond noise:" in text and "case 3" in text and "2.000" in text
    assert all(s.split("|")[0] in (tmp_path / "new" / "report.md").read_text() for s in SENTENCES)


@pytest.mark.parametrize(("old", "message"), [("no_such", "cannot be read"), ("empty", "holds no results")])
def test_what_is_no_report_is_refused(run, tmp_path, old, message, capsys):
    (tmp_path / "empty").mkdir()
    assert run(ROWS, old=old) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("old", ["old", "old/a.json"])
def test_quick_and_full_results_are_not_compared(run, old, capsys):
    assert run(ROWS, old=old, quick=True) == 2
    assert "full runs" in capsys.readouterr().err


def test_strict_without_an_earlier_report_is_refused(run, tmp_path, capsys):
    assert main(["report", "--output", str(tmp_path / "new"), "--strict"]) == 2
    assert "--strict" in capsys.readouterr().err
