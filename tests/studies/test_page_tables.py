"""Pages say what the committed results say; results that are missing, old or lucky are named."""

import json
import shutil
from argparse import Namespace

import numpy as np
import pytest

from exudyn_inext import InputError
from reference_models.inextensible import build
from reference_models.scenes import load_scene
from reference_models.trajectory import Case, Trajectory
from studies.__main__ import main
from studies.harness.cases import step_by_rule
from studies.harness.on_scene import add_halved
from studies.harness.provenance import ROOT
from studies.harness.ratios import DEFAULT
from studies.pages.command import PAGES, REPORT, remade, remake, write_pages
from studies.pages.results import FOLDER, Figures, reduced, store
from studies.pages.tables import comparison, noise, paper
from tests.studies.documents import document, row


@pytest.fixture
def copy(tmp_path):
    """Pages, report and results in another place: (root, folder)."""
    for name in (*PAGES, REPORT):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    for picture in (ROOT / REPORT.parent).glob("*.png"):
        (tmp_path / REPORT.parent / picture.name).touch()
    shutil.copytree(FOLDER, tmp_path / "docs/figures")
    return tmp_path, tmp_path / "docs/figures"


def pages_that_differ(root=ROOT, folder=FOLDER):
    """With figures other than those of the results."""
    return [path for path, text in remade(root, Figures(folder)).items() if text != path.read_text()]


def edit(path, **entries):
    path.write_text(json.dumps(json.loads(path.read_text()) | entries))


def test_all_pages_and_the_report_say_what_the_results_say(capsys):
    assert pages_that_differ() == []
    assert main(["figures"]) == 0 and capsys.readouterr().out == ""


def test_remake_runs_nothing_if_one_of_the_names_is_unknown(capsys):
    assert main(["remake", "table1", "no_such"]) == 2
    assert "study 'no_such' is unknown" in capsys.readouterr().err


@pytest.mark.parametrize("page", [*PAGES, REPORT])
def test_a_figure_that_was_typed_is_noticed_and_written_over(copy, page):
    root, folder = copy
    text = (root / page).read_text()
    block = text.index("<!-- figures") if "<!-- figures" in text else 0
    line = next(x for x in text[block:].splitlines() if x.startswith("| ") and any(map(str.isdigit, x)))
    (root / page).write_text(text.replace(line, line.replace(next(filter(str.isdigit, line)), "77", 1)))
    assert pages_that_differ(root, folder) == [root / page]
    write_pages(root, folder)
    assert (root / page).read_text() == text


def test_a_missing_result_names_the_study_to_run(copy):
    root, folder = copy
    (folder / "table1.json").unlink()
    with pytest.raises(InputError, match=r"table1.json' is missing.*python -m studies remake table1"):
        write_pages(root, folder)


def test_a_result_of_another_format_is_refused(copy):
    root, folder = copy
    edit(folder / "ring.json", format=0)
    with pytest.raises(InputError, match=r"ring.json' has format 0.*remake ring"):
        write_pages(root, folder)


def test_figures_of_an_older_commit_and_provisional_ones_are_named_below_their_table(copy):
    _, folder = copy
    old = json.loads((folder / "table3.json").read_text())["versions"] | {"commit": "0123456789abcdef"}
    edit(folder / "table3.json", versions=old, date="2020-01-01T00:00:00+00:00", provisional="too few rounds")
    said = paper(Figures(folder)).splitlines()[-1]
    assert "`table3`: 2020-01-01, commit 0123456789" in said and said.endswith("Provisional: too few rounds.")
    assert "table3." in said.partition("Older than the newest results")[2]


def test_a_row_within_a_bound_by_errors_that_cancel_is_marked_with_its_neighbour(copy):
    _, folder = copy
    rows = [
        row("lucky", 0.002, 5e-3, errorHalved=8.1e-3),
        row("default settings: sound", 0.003, 5e-3, errorHalved=4e-3, choice=DEFAULT),
        row("native", 0.03, 5e-3, formulation="conventional", integrator="generalizedAlpha"),
    ]
    store(reduced([document("table1", rows=rows)]), folder)
    lines = [line for line in comparison(Figures(folder)).splitlines() if line.startswith("| 0.006 m")]
    (lucky,) = (line for line in lines if "lucky" in line)
    assert r"0.005\* | 0.0081 |" in lucky and r"\*" not in "".join(line for line in lines if line != lucky)
    (native,) = (line for line in lines if ": native" in line and "default" not in line)
    assert native.endswith("| 10 | 15 |")  # over default settings, and over the lucky one


def test_runs_of_a_study_leave_how_far_their_times_differ(copy):
    _, folder = copy
    runs = [document("table1", rows=[row("a", 0.1 + x), row("b", 0.2)]) for x in (0.0, 0.01, 0.02)]
    stored = reduced(runs)
    assert stored["repeated"] == {
        "runs": 3,
        "median": pytest.approx(0.5 * 0.02 / 0.11),
        "largest": pytest.approx(0.02 / 0.11),
    }
    store(stored, folder)
    assert "`table1`, repeated 3 times: CPU times differ by 9.1 % in the median, by 18.2 % at most" in noise(
        Figures(folder)
    )


def test_remake_stores_what_a_study_gave_and_writes_the_pages(copy, tmp_path):
    root, folder = copy
    given = json.loads((folder / "scene_cost.json").read_text())
    given["rows"][0]["microseconds"] = 123.0
    results = tmp_path / "results"
    results.mkdir()
    (results / "scene_cost.json").write_text(json.dumps(given))
    for picture in given["pictures"]:
        (results / picture).write_text("a picture")
    wish = {"names": ["scene_cost"], "times": 1, "output": results, "stored": True, "provisional": ""}
    remake(Namespace(**wish), root, folder)
    assert "| 123 |" in (root / "docs/scenes.md").read_text()
    assert all((root / REPORT.parent / name).read_text() == "a picture" for name in given["pictures"])
    with pytest.raises(InputError, match="runs at least once"):
        remake(Namespace(**(wish | {"times": 0})), root, folder)


def resting(label, error, halved=None):
    path = Trajectory(np.linspace(0.0, 1.0, 5), np.full((5, 3), error / np.sqrt(3.0)))
    return Case(label, "inextensible", "RATTLE", 1, 0.1, 10, lambda: lambda: path, halved=halved)


def test_rows_of_the_front_are_run_again_with_half_the_step():
    asked = [resting("good", 1e-3, lambda: resting("", 2e-3)), resting("dearer and worse", 5e-3, pytest.fail)]
    rows = [row("good", 1.0, 1e-3), row("dearer and worse", 2.0, 5e-3)]
    add_halved(asked, rows, Trajectory(np.linspace(0.0, 1.0, 5), np.zeros((5, 3))))
    assert rows[0]["errorHalved"] == pytest.approx(2e-3) and "errorHalved" not in rows[1]


@pytest.mark.parametrize(("elements", "step"), [(5, 5e-3), (10, 1.4 * 0.18**2 / (1.5 * np.pi) ** 2)])
def test_the_step_of_the_one_setting_is_that_of_equation_37_with_twice_the_constant(elements, step):
    scene = load_scene("planar_pendulum")
    section = scene.cable.section
    inertia = np.sqrt(section.mass_per_length / section.bending_stiffness) if elements == 10 else 1.0
    assert step_by_rule(build(scene, elements).mbs) == pytest.approx(step * inertia, rel=1e-9)
