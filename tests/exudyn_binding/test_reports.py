"""Returned reports are dicts, and print as a few lines that say what they hold."""

import inspect
import json
import pickle
import re
from importlib.metadata import version

import exudyn
import pytest

import exudyn_inext
from docs.extensions.docstrings import sections
from exudyn_inext import CreateInextensibleCable, EquilibriumError, InextensibleCable, StaticSettings
from exudyn_inext.exudyn_binding.reports import AdviceReport, EnsembleReport
from reference_models.model import quiet_settings, silence


@pytest.fixture
def mbs():
    system = exudyn.SystemContainer().AddSystem()
    pinned = [True, True, False, False]
    CreateInextensibleCable(
        system, [0, 0, 0], [1, 0, 0], 4, InextensibleCable(massPerLength=0.1, bendingStiffness=1e-2),
        gravity=[0, -9.81, 0], groundConstraintsStart=pinned,
    )  # fmt: skip
    system.Assemble()
    return system


def test_a_run_prints_what_was_done(mbs):
    report = exudyn_inext.SolveExplicit(mbs, quiet_settings(0.1, 10))
    said = str(report)
    assert said.startswith(
        f"SolveExplicit: {report['steps']} steps of RATTLE, h = {report['stepSize']:.4g} s"
    )
    assert f"stability limit: {report['bounds'].stability_limit:.4g} s" in said and report["path"] in said
    assert len(said.splitlines()) < 8 and "StepSizeBounds(" not in said and repr(report) == said
    assert re.search(r"keys: success, integrator, .*resumedAt$", said)


def test_a_report_stays_a_dict(mbs):
    report = exudyn_inext.SolveExplicit(mbs, quiet_settings(0.1, 10))
    assert isinstance(report, dict) and dict(report) == report
    assert pickle.loads(pickle.dumps(report)) == report
    assert json.loads(json.dumps(report, default=str))["steps"] == report["steps"]


OF_LONG_RUNS = {"stepOverLimit"}  # see 'drift' of SolveExplicit
NO_KEYS = {"ok"}  # a value


@pytest.mark.parametrize(
    "solve",
    [
        lambda mbs: exudyn_inext.SolveExplicit(mbs, quiet_settings(0.1, 10)),
        lambda mbs: exudyn_inext.SolveEquilibrium(mbs),
        lambda mbs: exudyn_inext.SolveEnsemble([mbs], quiet_settings(0.1, 10), derivatives=2, threads=1),
        lambda mbs: exudyn_inext.CableForces(mbs, 0),
    ],
    ids=["SolveExplicit", "SolveEquilibrium", "SolveEnsemble", "CableForces"],
)
def test_the_docstring_names_all_keys_of_a_result_and_no_others(mbs, solve, request):
    with silence():
        result = solve(mbs)
    solver = getattr(exudyn_inext, request.node.callspec.id)
    returned = dict(sections(inspect.getdoc(solver).splitlines()))["Returns"]
    described = set(re.findall(r"'(\w+)'", " ".join(returned)))
    within = [result.get("drift", {}), *result.get("cables", [])]
    assert set(result) <= described
    assert described - OF_LONG_RUNS - NO_KEYS <= set(result).union(*within)


def test_an_ensemble_prints_how_many_members_reached_the_end(mbs):
    result = exudyn_inext.SolveEnsemble([mbs, mbs], quiet_settings(0.1, 10), threads=1)
    said = str(result)
    assert said.startswith("SolveEnsemble: 2 of 2 members reached t = 0.1 s, RATTLE") and "array" not in said
    assert "(2, 11, 20) of (members, times, coordinates)" in said and isinstance(result, dict)
    failed = EnsembleReport(result, status=["ok", "diverged before t = 0.05 s"])
    assert "1 of 2 members" in str(failed) and "member 1: diverged before t = 0.05 s" in str(failed)


def test_an_equilibrium_prints_its_figures(mbs):
    with silence():
        report = exudyn_inext.SolveEquilibrium(mbs)
    lowest = report["smallestEigenvalue"] ** 0.5
    assert f"lowest natural frequency: {lowest:.4g} rad/s" in str(report)
    assert "timeIntegration.startTime = 0 s" in str(report) and report["time"] == 0.0
    assert "a stable equilibrium after" in str(report) and "array" not in str(report)


def test_a_search_without_an_end_says_so(mbs):
    with silence(), pytest.raises(EquilibriumError) as caught:
        exudyn_inext.SolveEquilibrium(mbs, staticSettings=StaticSettings(maxIterations=1))
    assert not caught.value.report["success"] and "no equilibrium after 1 iter" in str(caught.value.report)


def test_advice_prints_its_reasons():
    advice = AdviceReport(
        reasons=["RATTLE, 8 elements.", "It converges."], extrapolated=False, meetsTolerance=True,
        tried=[1, 2], predictedError=1e-3, predictedSeconds=0.5, pilotSeconds=3.0, explicitSettings=object(),
    )  # fmt: skip
    first, second, third, fourth, *_ = str(advice).splitlines()
    assert (first, second) == ("Advise: RATTLE, 8 elements.", "  It converges.")
    assert third == "  measured: error 0.001, within the tolerance; 0.5 s of CPU time a run"
    assert fourth == "  pilots: 2 runs, 3 s of CPU time" and "advice['explicitSettings']" in str(advice)


def test_the_version_is_that_of_the_package():
    assert exudyn_inext.__version__ == version("exudyn_inext")
