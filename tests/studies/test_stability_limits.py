"""Predicted limits of the step are those that runs show; the maps run in quick mode."""

import json
import math
from dataclasses import replace

import pytest

from studies import stability_limits
from studies.__main__ import main
from studies.harness.benchmark import Benchmark
from studies.harness.study import Results
from studies.stability import linear
from studies.stability.limits import largest_stable_step
from studies.stability.linear import run_linear
from studies.stability.violent import run_violent

SCENES = {
    "straight": {"elements": 4},
    "hanging": {"elements": 4, "gravity": 9.81},
    "sagging": {"elements": 6, "share": 0.9},
}
SCHEMES = ["Zhai", "Zhai, v_n", "Zhai, corrector, psi = phi = 0", "Zhai, corrector", "RATTLE", "RK4"]


def found(cable, scheme, given=None, **method):
    given = SCENES[cable] if given is None else given
    return run_linear(linear.case_of(cable, scheme, 0.0, given, **{"steps": 1000, **method}))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("cable", SCENES)
def test_linear_limit_is_the_predicted_one(cable, scheme):
    assert found(cable, scheme)["ratio"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("scheme", ["Zhai", "RATTLE", "RK4"])
def test_linear_limit_with_scaled_mass_is_the_predicted_one(scheme):
    row = found("hanging", scheme, theta=0.2)
    assert row["ratio"] == pytest.approx(1.0, abs=0.05)
    assert row["found"] > 1.5 * found("hanging", scheme)["found"]


def test_tension_rules_a_limp_cable_and_the_paper_s_rule_is_not_safe_there():
    limp = {"elements": 4, "gravity": 9.81, "stiffness": 1e-8}
    row = found("hanging", "RATTLE", limp)
    assert row["ruledBy"] == "tension" and row["ratio"] == pytest.approx(1.0, abs=0.05)
    assert row["ruleOverLimit"] > 10.0


def test_zeta_rules_where_it_is_large():
    row = found("straight", "Zhai", zeta=1e4)
    assert row["ruledBy"] == "zeta" and row["found"] == pytest.approx(1e-4, rel=0.05)


def test_spin_lowers_the_limit_of_zhai_and_not_that_of_rattle():
    given = {"elements": 10, "rate": 100.0}
    for scheme, is_that_of_frequency in (("Zhai", False), ("RATTLE", True)):
        row = run_linear(linear.case_of("spinning", scheme, 100.0, given, steps=500))
        assert (abs(row["ratio"] - 1.0) < 0.05) == is_that_of_frequency


def test_a_violent_start_costs_zhai_more_than_rattle():
    cases = [
        {"scheme": scheme, "zeta": 100.0, "value": 30.0, "duration": 0.1} for scheme in ("Zhai", "RATTLE")
    ]
    zhai, rattle = (run_violent(case) for case in cases)
    assert zhai["part"] < 0.5 * rattle["part"] <= 0.5


@pytest.mark.parametrize("limit", [1e-4, 0.97, 1.03, 17.0])
def test_bisection_finds_a_limit_from_either_side(limit):
    expected = 0.0 if limit < 1e-3 else limit
    assert largest_stable_step(lambda h: h < limit, 1.0) == pytest.approx(expected, rel=5e-3)
    assert math.isinf(largest_stable_step(lambda h: True, 1.0))


def test_limits_that_disagree_are_called_so():
    row = {
        "kind": "scheme", "scheme": "Zhai", "label": "Zhai, straight", "cable": "straight", "value": 0.0,
        "theta": 0.0, "predicted": 1.0, "found": 1.0, "ratio": 1.0, "rule": 0.9, "ruleOverLimit": 0.9,
        "ruledBy": "bending", "status": "ok",
    }  # fmt: skip

    def said(**changes):
        rows = [row | {"kind": "scheme"}, row | {"kind": "scheme"} | changes]
        return " ".join(stability_limits.STUDY.conclusions(Results(False, rows)))

    assert "0.05 is kept" in said() and "MISSED by 1 of 2" in said(found=1.1, ratio=1.1)
    assert "0.05 is kept" in said(found=None, predicted=None, ratio=None)
    assert "MISSED by 1 of 2" in said(found=1.1, predicted=None, ratio=None)
    assert "FAILED: Zhai, straight" in said(status="failed: ArithmeticError: x")


def test_a_rule_above_the_limit_is_not_safe():
    row = {
        "kind": "zeta", "scheme": "Zhai", "label": "Zhai, straight", "value": 1e4, "theta": 0.0, "ratio": 1.0,
        "ruleOverLimit": 2.0, "status": "ok",
    }  # fmt: skip
    said = stability_limits.STUDY.conclusions(Results(False, [row]))
    assert any("Zhai, zeta: rule (37)" in text and "MISSED" in text for text in said)


KINDS = {"scheme", "zeta", "stiffness", "elements", "curvature", "gravity", "spin", "violent"}


def test_it_runs_in_quick_mode(tmp_path, monkeypatch):
    """The first case of every map but those that need kernels of their own."""
    first = [
        replace(series, cases=lambda quick, series=series: list(series.cases(quick))[:1])
        for series in stability_limits.SERIES
    ]
    study = replace(stability_limits.STUDY, measure=Benchmark(first))
    monkeypatch.setattr("studies.__main__.find_study", lambda name: study)
    command = ["run", "stability_limits", "--quick", "--output", str(tmp_path)]
    assert main(command) == 0
    document = json.loads((tmp_path / "stability_limits.json").read_text())
    assert {row["kind"] for row in document["rows"]} == KINDS
    assert all(row["status"] == "ok" for row in document["rows"])
    report = (tmp_path / "stability_limits.md").read_text()
    assert all(sentence in report for sentence in document["conclusions"])
    assert document["pictures"] == ["stability_limits.png"] and "(stability_limits.png)" in report
