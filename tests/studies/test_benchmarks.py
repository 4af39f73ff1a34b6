"""Studies of speed run in quick mode, and their files hold what they promise; no timing is asserted."""

import json
from dataclasses import replace

import numpy as np
import pytest

from studies import stretch
from studies.__main__ import main
from studies.harness import joined_scenes
from studies.harness.bars import Bar
from studies.harness.benchmark import Benchmark, Series, benchmark, varied
from studies.harness.memory import KINDS
from studies.harness.ratios import DEFAULT, ONE_SETTING, TUNED
from studies.harness.study import KEYS, Results, Study
from studies.harness.table import Table
from studies.harness.timing import Measurement, sampled
from studies.registry import find_study
from studies.speed import STUDIES, scene_cost, soak

DOCUMENT_KEYS = set(KEYS)


@pytest.fixture
def run_quick(tmp_path):
    """name -> rows of a quick run by kind; files are checked."""

    def run(name):
        assert main(["run", name, "--quick", "--output", str(tmp_path)]) == 0
        document = json.loads((tmp_path / f"{name}.json").read_text())
        assert set(document) == DOCUMENT_KEYS and document["quick"] is True
        report = (tmp_path / f"{name}.md").read_text()
        assert find_study(name).question in report
        assert all(sentence in report for sentence in document["conclusions"])
        assert all(f"({picture.name})" in report for picture in tmp_path.glob("*.png"))
        kinds = {row["kind"] for row in document["rows"]}
        return {kind: [row for row in document["rows"] if row["kind"] == kind] for kind in kinds}

    return run


def test_kernel_compares_steps_with_native_evaluations(run_quick):
    rows = run_quick("kernel")
    assert {(row["dimension"], row["elements"]) for row in rows["ratio"]} == {
        (2, 5),
        (2, 20),
        (3, 5),
        (3, 20),
    }
    assert {row["integrator"] for row in rows["ratio"]} == {"Zhai", "RATTLE"}
    for row in rows["ratio"]:
        assert row["ratio"] == pytest.approx(row["microseconds"] / row["nativeMicroseconds"])


def test_coupled_finds_the_cheapest_runs_and_steps_of_large_nets(run_quick, monkeypatch):
    """Nets in this process: those of `scaling` and `soak` have their own."""
    monkeypatch.setattr("studies.coupled.ask", lambda function, *arguments: function(*arguments))
    rows = run_quick("coupled")
    assert {row["formulation"] for row in rows["large"]} == {"inextensible", "native"}
    candidates = {row["label"]: row for row in rows["candidate"]}
    for row in rows["best"]:
        assert candidates[row["label"]]["error"] == row["error"] < row["bound"]
    found = {
        (row["scene"], row["formulation"], row["choice"]) for row in rows["best"] if row["bound"] == 1e-2
    }
    choices = [("native", TUNED), *(("inextensible", name) for name in (TUNED, DEFAULT, ONE_SETTING))]
    assert found == {(row["scene"], *choice) for row in rows["reference"] for choice in choices}


def test_stretch_compares_both_quadratures_and_finds_one_step_for_all_stiffnesses(run_quick):
    rows = run_quick("stretch")
    tuned = {row["formulation"] for row in rows["best"] if row["choice"] == "tuned" and row["bound"] == 1e-3}
    assert tuned == {"ours", stretch.FULL, stretch.LOBATTO}
    soft, stiff = rows["stiffness"]
    assert soft["found"] == pytest.approx(stiff["found"], rel=stretch.SAME)
    assert soft["native"] == pytest.approx(10**0.5 * stiff["native"], rel=stretch.SAME)
    assert soft["distance"] == pytest.approx(10 * stiff["distance"], rel=0.1)
    assert all(row["range"] < 1e-4 for row in rows["run"])


@pytest.mark.parametrize(("third", "verdict"), [(21.0, "kept"), (19.0, "MISSED"), (None, "MISSED")])
def test_stretch_keeps_its_bars_on_three_scenes(third, verdict, monkeypatch):
    ratios = {"pendulum": 30.0, "string": 25.0, "bungee": 0.5}
    rows = [{"scene": name, "within": "0.1 %", "full/ours": ratio} for name, ratio in ratios.items()]
    rows.append({"scene": "line", "within": "0.1 %", **({"full/ours": third} if third else {})})
    monkeypatch.setattr(stretch, "compared", lambda results: rows)
    sentence, *_ = stretch.STUDY.conclusions(Results(False, []))
    assert sentence.endswith(f"the bar of 20 is {verdict}.") and "bungee 0.500" in sentence


def test_scene_cost_takes_each_path_and_names_it(run_quick):
    rows = run_quick("scene_cost")["cost"]
    paths = {row["label"]: row["path"] for row in rows}
    assert "in one compiled call" in paths["cables alone"]
    assert "user functions may look" in paths["elements, watched"]
    assert all("in one compiled call" in paths[name] for name in ("springs", "bodies on joints"))
    assert len(rows) == 2 * len(scene_cost.SERIES)


def test_a_step_costs_what_a_longer_run_takes_longer_and_the_rest_is_the_start():
    case = {"label": "springs", "contents": joined_scenes.Contents(springs=1)}
    few, many = scene_cost.runs(case)
    path = "1 of 3: some path, as mbs contains a spring"
    found = {
        key: Measurement(None, [spell + key[-1] * 20e-6 for spell in (2e-3, 1e-3, 3e-3)], found=path)
        for key in (few, many)
    }
    row = scene_cost.row(case, found)
    assert row["microseconds"] == pytest.approx(20.0) and row["startMilliseconds"] == pytest.approx(2.0)
    assert row["path"] == "some path"


def test_growth_is_compared_over_both_halves_of_a_series():
    rows = [{"kind": "cost", "label": "elements", "elements": n, "microseconds": t} for n, t in
            ((10, 1.0), (20, 2.0), (40, 8.0))]  # fmt: skip
    (found,) = scene_cost.growth(Results(False, rows))
    assert found["more"] == pytest.approx(0.3) and found["bar"] == pytest.approx(0.15)


def test_the_ways_to_keep_the_length_agree(tmp_path):
    assert main(["run", "enforcement", "--quick", "--output", str(tmp_path)]) == 0
    document = json.loads((tmp_path / "enforcement.json").read_text())
    ways = [row.get("enforcement", "projection") for row in document["rows"]]
    assert ways == ["projection", "penaltyMass", "penaltyMass", "algebraic"]
    assert all(row["errorMax"] < 2e-3 and row["status"] == "ok" for row in document["rows"])
    assert len(document["conclusions"]) == 6 and document["pictures"] == ["enforcement_cost.png"]


def test_tasks_are_sampled_in_turn_after_a_warm_up():
    order = []
    tasks = {name: lambda times, name=name: order.append(name) for name in "ab"}
    found = sampled(tasks, rounds=3, least_seconds=0.0)
    assert order[-6:] == ["a", "b", "b", "a", "a", "b"]  # each round begins with another one
    assert [len(one.cpu_seconds) for one in found.values()] == [3, 3]


def speed_of(case):
    return {"label": f"task {case['n']}", "speed": case["n"], "bar": 2.5}


def test_an_entry_says_what_varies_what_is_timed_together_and_which_bars_are_kept():
    order = []
    series = Series(
        "speed",
        varied({"n": (1,)}, turn=("a", "b"), n=(1, 2, 3)),
        lambda case, found: speed_of(case) | {"rounds": len(found[case["n"]].cpu_seconds)},
        lambda case: {case["n"]: lambda: lambda: order.append((case["turn"], case["n"]))},
        turn=("turn",),
        rounds=(1, 2),
    )
    bars = [
        Bar("speed", "speed", "speeds", "bar"),
        Bar("speed", "speed", "{}: least", per="rounds", is_least=True),
    ]
    study = benchmark("tiny", "?", [series], bars, "speed: Speeds:\n    what: label | speed")
    rows = study.measure(False)
    assert [row["speed"] for row in rows] == [1, 2, 3] * 2 and all(row["rounds"] == 2 for row in rows)
    assert [turn for turn, _ in order] == ["a"] * 9 + ["b"] * 9
    assert order[:9] == [("a", n) for n in (1, 2, 3, 1, 2, 3, 2, 3, 1)]
    assert study.conclusions(Results(False, rows)) == [
        "speeds: at most 3.00 (task 3); the bar of 2.5 is MISSED by 2 of 6.",
        "2: least: at least 1.00 (task 1).",
    ]
    assert "undecided" in study.conclusions(Results(True, rows))[0]
    assert [row["rounds"] for row in study.measure(True)] == [1, 1]


def test_every_benchmark_shows_each_kind_of_its_rows():
    for study in STUDIES:
        assert [table.kind for table in study.tables] == [one.kind for one in study.measure.series]


def test_bars_may_be_lower_ones_over_the_least_and_of_figures_that_are_not_there():
    def said(bar, *rows):
        (sentence,) = bar.sentences(Results(False, [{"kind": "a", "label": "x"} | row for row in rows]))
        return sentence

    gain = Bar("a", "gain", "gain", 1.8, is_least=True)
    assert said(gain, {"gain": 1.9}, {"gain": None}) == "gain: at least 1.90 (x); the bar of 1.8 is kept."
    assert (
        said(gain, {"gain": 1.5}).endswith("MISSED.") and said(gain, {"gain": None}) == "gain: not measured."
    )
    spread = Bar("a", "t", "t", 1.25, over_least=True)
    assert "1.20 (x); the bar of 1.25 is kept" in said(spread, {"t": 5.0}, {"t": 6.0})
    control = {"label": "control, slow", "t": 1.0}
    assert said(Bar("a", "t", "t", 0.5), control).endswith("is exceeded, as it should be.")
    assert "NOT exceeded" in said(Bar("a", "t", "t", 2.0), control)
    assert said(Bar("a", "t", "t", 0.5), {"t": float("nan")}).endswith("MISSED.")


def test_a_benchmark_runs_from_the_command_line(monkeypatch, tmp_path, capsys):
    tiny = Study(
        name="tiny",
        question="How fast is nothing?",
        measure=lambda quick: [{"kind": "speed", "label": "nothing", "time": 0.5}],
        tables=(Table("speed", "Speeds:", "what: label | t [s]: time"),),
        conclusions=lambda figures: [f"{len(figures.of_kind('speed'))} speed"],
    )
    monkeypatch.setattr("studies.__main__.find_study", lambda name: tiny)
    assert main(["run", "tiny", "--output", str(tmp_path)]) == 0
    assert "nothing  0.500\n" in capsys.readouterr().out
    document = json.loads((tmp_path / "tiny.json").read_text())
    assert set(document) == DOCUMENT_KEYS and document["conclusions"] == ["1 speed"]


def test_scaling_measures_cost_memory_and_accuracy(run_quick, monkeypatch):
    """Memory of the first chain."""
    study = find_study("scaling")
    cost, memory, accuracy = study.measure.series
    first = replace(memory, cases=lambda quick: memory.cases(quick)[:1])
    study = replace(study, measure=Benchmark([cost, first, accuracy]))
    monkeypatch.setattr("studies.__main__.find_study", lambda name: study)
    rows = run_quick("scaling")
    chains = {"2D", "3D", "2D, closed"}
    assert {row["label"] for row in rows["cost"]} == {f"{c}, {i}" for c in chains for i in ("Zhai", "RATTLE")}
    assert all(row["microseconds"] > 0 and row["megabytes"] > 0 for row in rows["cost"])
    for row in rows["memory"]:
        assert row["librariesMegabytes"] < row["modelMegabytes"] <= row["peakMegabytes"] < 1000
    assert all(row["status"] == "ok" and row["errorMax"] < 1e-3 for row in rows["accuracy"])


def test_realtime_gives_the_distribution_of_single_steps(run_quick):
    rows = run_quick("realtime")["step"]
    steps = {(row["elements"], row["garbageCollection"]) for row in rows if row["what"] == "step"}
    assert steps == {(5, collects) for collects in (True, False)}
    for row in rows:
        assert 0 <= row["median"] <= row["percentile999"] <= row["worst"]
        assert row["samples"] == 2000 and 0 <= row["lateShare"] <= 1


def test_soak_watches_energy_constraints_and_memory(run_quick, monkeypatch):
    monkeypatch.setattr(soak, "SCENES", (4, None))
    monkeypatch.setattr(soak, "WARM_UP", (2, None))
    rows = run_quick("soak")
    undamped, control = rows["run"]
    assert undamped["range"] < 1e-3 and undamped["violation"] < 1e-9 and undamped["rate"] < 1e-9
    assert control["steps"] == undamped["steps"] // 10
    for row in rows["run"]:
        assert len(row["times"]) == len(row["energies"]) and np.isfinite(row["energies"]).all()
    assert {row["label"] for row in rows["memory"]} == set(soak.QUICK) < set(KINDS)
    for row in rows["memory"]:
        assert row["scenes"] == 4 and len(row["megabytes"]) == 6
        assert 10.0 < row["firstMegabytes"] < 1000.0
    kilobytes = {row["label"]: row["kilobytesAScene"] for row in rows["memory"]}
    assert kilobytes["control: compiled steps, kept"] > 50.0 + kilobytes["joined to bodies"]


def test_soak_finds_a_drift_and_memory_that_grows():
    drifting = {"kind": "run"} | soak.watched_run({"label": "damped", "damping": 1e-5, "steps": 20_000})
    assert soak.drift_of(drifting) > soak.DRIFT and drifting["drift"] < 0.0
    assert soak.drift_of(drifting | {"drift": 0.01 * drifting["range"]}) == pytest.approx(0.01)
    memory = soak.memory_row("scenes", [300_000_000 + 1_000_000 * k for k in range(40)], 20)
    assert memory["firstMegabytes"] == pytest.approx(320.5)
    assert memory["growthPercent"] == pytest.approx(100.0 * (338.5 / 320.5 - 1.0))
    rows = [drifting, memory | {"kind": "memory"}]
    drift, violation, growth = find_study("soak").conclusions(Results(False, rows))
    assert "MISSED" in drift and "kept" in violation and "MISSED" in growth
    control = [row | {"label": "control"} for row in rows]
    assert find_study("soak").conclusions(Results(False, control))[0].endswith("exceeded, as it should be.")
    assert "undecided" in find_study("soak").conclusions(Results(True, control))[2]
