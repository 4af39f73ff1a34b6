"""One report from all documents: complete, self-contained, never mixed."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from studies.__main__ import main
from studies.harness.provenance import present_code
from studies.harness.study import Study
from studies.harness.table import Table
from studies.report import command
from studies.report.documents import gather
from tests.studies.documents import LONG, SENTENCES, document, store


def bench(name, rows=(1.0,)):
    """A study of microseconds; without rows it fails."""

    def measure(order):
        if not rows:
            raise RuntimeError("no rows")
        return [{"kind": "speed", "label": f"row {n}", "microseconds": x} for n, x in enumerate(rows)]

    tables = (Table("speed", "Speeds:", "what: label | t [us]: microseconds"),)
    conclusions = lambda figures: [f"{len(figures.rows)} rows, quick: {figures.quick}"]  # noqa: E731
    return Study(name, f"What of {name}?", measure, conclusions, tables)


@pytest.fixture
def studies(monkeypatch):
    """Registered instead of the real ones."""
    registered = {name: bench(name) for name in ("first", "second")}
    monkeypatch.setattr(command, "find_studies", lambda: registered)
    return registered


@pytest.fixture
def folder(studies, tmp_path):
    return store(tmp_path / "results", document("first"), document("second"))


def report(folder, *options):
    return main(["report", "--output", str(folder), *options])


class Page(HTMLParser):
    """What a page refers to, its anchors, and its text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.references, self.anchors, self.text = [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        for name, value in attributes:
            if name in ("src", "href", "srcset", "data", "poster", "action", "background"):
                self.references.append((tag, value))
            if name == "id":
                self.anchors.append(value)

    def handle_data(self, data):
        self.text += data


def page_of(folder):
    text = (folder / "report.html").read_text(encoding="utf-8")
    return text, Page(text)


def outside(page, text):
    """References that are neither embedded nor to an anchor of the page, also those of the style sheet."""
    of_tags = [
        value
        for tag, value in page.references
        if not value.startswith("data:image/png;base64," if tag == "img" else "#")
    ]
    return of_tags + re.findall(r"@import[^;]*|url\([^)]*\)", text)


def test_the_page_needs_nothing_from_elsewhere(folder):
    assert report(folder) == 0
    text, page = page_of(folder)
    assert outside(page, text) == []
    assert page.tags.count("img") == 2 and not {"script", "link", "iframe"} & set(page.tags)


def test_what_is_elsewhere_is_noticed():
    text = '<img src="a.png"><a href="https://x.org">x</a><style>b { background: url(c.png) }</style>'
    assert outside(Page(text), text) == ["a.png", "https://x.org", "url(c.png)"]


def test_every_link_of_the_page_leads_to_an_anchor_and_every_study_has_one(folder):
    report(folder)
    _, page = page_of(folder)
    links = {value[1:] for tag, value in page.references if tag == "a"}
    assert links <= set(page.anchors) and len(page.anchors) == len(set(page.anchors))
    assert {"first", "second", "headline", "findings", "machine-and-versions"} <= links


def test_both_forms_hold_conclusions_tables_ratios_machine_and_commit(folder):
    report(folder)
    _, page = page_of(folder)
    code = present_code()
    for text in (page.text, (folder / "report.md").read_text()):
        for part in (*SENTENCES, "47.3", "2.42", "at equal accuracy, the closest: tuned", "5.60", "A note."):
            assert part in text
        assert code["versions"]["commit"] in text and code["versions"]["exudyn"] in text
        assert f"r_{LONG - 1}" in text and document()["date"][:10] in text
    assert "![first](first.png)" in (folder / "report.md").read_text()
    assert "b" not in page.tags  # HTML within a sentence is shown


def test_adverse_findings_are_listed_and_long_tables_folded_in(folder):
    report(folder)
    text, page = page_of(folder)
    assert "Missed, limited or failed (2)" in page.text
    assert text.count(f"({LONG} rows)</summary>") == 2


def test_a_missing_study_is_run(studies, tmp_path):
    folder = store(tmp_path, document("first"))
    assert report(folder) == 0
    assert json.loads((folder / "second.json").read_text())["quick"] is False
    assert "1 rows, quick: False" in page_of(folder)[1].text


def test_a_quick_report_has_a_folder_of_its_own_and_runs_everything_each_time(folder, studies):
    assert report(folder, "--quick") == 0
    names = {path.name for path in (folder / "quick").iterdir()}
    assert {"first.json", "second.json", "report.md", "report.html"} <= names
    assert json.loads((folder / "first.json").read_text())["quick"] is False
    studies["first"] = bench("first", (1.0, 2.0))
    assert report(folder, "--quick") == 0
    assert "2 rows, quick: True" in page_of(folder / "quick")[1].text


@pytest.mark.parametrize("stored", [document("second", quick=True), {**document("second"), "pictures": None}])
def test_results_that_do_not_belong_into_the_report_are_made_anew(folder, stored):
    (folder / "second.json").write_text(
        json.dumps({key: value for key, value in stored.items() if value is not None})
    )
    assert report(folder) == 0
    assert json.loads((folder / "second.json").read_text())["rows"][0]["label"] == "row 0"


def test_a_quick_report_leaves_out_what_is_too_long_unless_asked_for(folder, studies, monkeypatch):
    studies["first"] = replace(studies["first"], not_in_quick_report="it takes an hour")
    monkeypatch.setattr(command, "find_study", studies.get)
    assert report(folder, "--quick") == 0
    text = page_of(folder / "quick")[1].text
    assert "first: it takes an hour." in text and "What of second?" in text and "What of first?" not in text
    assert report(folder, "--quick", "--only", "first") == 0
    assert "What of first?" in page_of(folder / "quick")[1].text


def test_a_study_that_fails_leaves_its_reason_and_the_others_go_on(studies, tmp_path, capsys):
    studies["first"] = bench("first", ())
    assert report(tmp_path) == 1
    text = page_of(tmp_path)[1].text
    assert "FAILED: RuntimeError: no rows" in text and "What of second?" in text


def test_a_study_that_fails_anew_does_not_leave_its_old_result(studies, folder):
    studies["first"] = bench("first", ())
    assert report(folder, "--fresh") == 1
    assert not (folder / "first.json").exists() and (folder / "second.json").exists()


def test_a_picture_that_is_gone_is_named(folder):
    (folder / "first.png").unlink()
    assert report(folder) == 0
    assert "The picture first.png is not there." in page_of(folder)[1].text


def test_results_of_other_commits_are_shown_with_their_commit(folder):
    versions = document("second")["versions"] | {"commit": "0123456789abcdef"}
    store(folder, document("second") | {"versions": versions})
    assert report(folder) == 0
    text = page_of(folder)[1].text
    assert "commit 0123456789." in text and f"commit {present_code()['versions']['commit'][:10]}" in text


def test_fresh_runs_all_anew(folder):
    assert report(folder, "--fresh") == 0
    assert json.loads((folder / "second.json").read_text())["rows"][0]["label"] == "row 0"


def test_only_takes_the_named_studies(tmp_path, capsys):
    """A real study, run in quick mode."""
    assert report(tmp_path, "--quick", "--only", "enforcement") == 0
    text, page = page_of(tmp_path / "quick")
    assert "CPU time over that of SolveExplicit" in page.text and outside(page, text) == []
    assert page.anchors == ["contents", "findings", "enforcement", "machine-and-versions"]


def test_an_unknown_name_is_refused_before_anything_runs(folder, capsys):
    assert report(folder, "--only", "no_such") == 2
    assert "'no_such' is unknown" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["{", "[]", '{"study": "second"}', "\udcff"])
def test_a_damaged_file_is_named(folder, text, capsys):
    (folder / "second.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    assert report(folder) == 2
    assert "second.json" in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_refused(studies, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert report(tmp_path / "file") == 2
    assert "cannot be written" in capsys.readouterr().err


def test_libraries_that_are_not_installed_are_named_with_the_extra(folder, monkeypatch, capsys):
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    assert report(folder) == 2
    message = capsys.readouterr().err
    assert "markdown_it" in message and "exudyn_inext[report]" in message


def test_nothing_at_all_gives_an_empty_report(tmp_path):
    found = gather({}, tmp_path)
    assert found.documents == {} and found.absent == {}
