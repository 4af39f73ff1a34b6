"""Which step a run takes, and what it says about one that is too long."""

import contextlib

import numpy as np
import pytest

from exudyn_inext import CableShape, DivergenceError, InextensibleCable, StepSizeError


def test_the_rule_decides_over_the_steps_of_zhai(twin, solve):
    report = solve(twin().mbs, 0.1, integrator="Zhai")
    rule = 0.7 * 0.36**2 / (1.5 * np.pi) ** 2 * np.sqrt(0.0348 / 0.0866)
    assert report["decidedBy"] == "rule (37)"
    assert report["bounds"].rule == pytest.approx(rule, rel=1e-12)
    assert report["stepSize"] <= rule
    assert report["stepSize"] * report["steps"] == pytest.approx(0.1, rel=1e-12)


def test_the_output_period_is_a_multiple_of_the_step(twin, solve):
    for wanted in (1.1e-3, 7e-4, 2e-3):
        multiple = 0.01 / solve(twin().mbs, 0.1, stepSize=wanted)["stepSize"]
        assert multiple == pytest.approx(round(multiple), abs=1e-9)
        assert 0.01 / round(multiple) <= wanted < 0.01 / (round(multiple) - 1)


def test_a_large_stabilisation_rate_decides(twin, solve):
    report = solve(twin().mbs, 0.1, integrator="Zhai", stabilizationRate=2000.0)
    assert report["decidedBy"] == "stabilisation"
    assert report["stepSize"] <= report["bounds"].stabilisation == pytest.approx(5e-4, rel=1e-6)


def test_a_large_step_constant_leaves_the_decision_to_bending(twin, solve):
    report = solve(twin().mbs, 0.1, integrator="Zhai", stepConstant=0.9, stabilizationRate=10.0)
    assert report["decidedBy"] == "bending"
    assert report["stepSize"] <= 0.95 * report["bounds"].bending


def test_the_shortest_output_period_decides_where_it_is_shorter_than_the_bounds(twin, solve):
    built = twin(numberOfElements=2)
    report = solve(built.mbs, 0.1, integrator="Zhai", stabilizationRate=50.0)
    assert report["bounds"].rule > 0.01
    times = np.asarray(built.mbs.GetSensorStoredData(built.tip))[:, 0]
    np.testing.assert_allclose(times, np.arange(11) / 100, atol=1e-12)
    assert report["stepSize"] == pytest.approx(0.01)
    assert report["decidedBy"] == "output period"


@pytest.mark.parametrize(
    ("explicit", "culprit", "remedy"),
    [
        ({"stepSize": 4e-3}, r"w_max = 729\.\d+ rad/s of cable 'object0'", "fewer elements"),
        (
            {"integrator": "Zhai", "stepSize": 2e-3, "stabilizationRate": 1e3},
            "stabilisation",
            "stabilizationRate",
        ),
    ],
)
def test_a_step_above_the_limit_is_refused(twin, solve, contents, explicit, culprit, remedy):
    mbs = twin().mbs
    before = contents(mbs)
    with pytest.raises(StepSizeError, match=culprit) as caught:
        solve(mbs, 0.1, **explicit)
    message = str(caught.value)
    limit = "0.00274159" if "w_max" in message else "0.001 s"
    assert f"stepSize = {explicit['stepSize']:g} s" in message
    assert limit in message
    assert "reduce the step" in message
    assert remedy in message
    assert contents(mbs) == before


def test_an_unstable_step_that_the_user_insists_on_warns_and_diverges(twin, solve, without_smaller_steps):
    built = twin()
    with (
        pytest.warns(UserWarning, match=r"stepSize = 0\.005 s is above 0\.00274159 s"),
        pytest.raises(DivergenceError, match=r"diverged before t = [\d.]+ s\. cable 'object0'") as caught,
    ):
        solve(built.mbs, 5.0, stepSize=5e-3, allowUnstableStep=True)
    assert "reduce stepSize" in str(caught.value)
    data = built.mbs.systemData
    assert f"holds the last good output, that of t = {data.GetTime():.6g} s" in str(caught.value)
    for state in (data.GetODE2Coordinates(), data.GetODE2Coordinates_t()):
        assert np.isfinite(state).all()
    assert np.isfinite(built.mbs.GetSensorStoredData(built.tip)).all()


def test_a_step_within_the_limit_does_not_warn_even_if_unstable_ones_are_allowed(twin, solve):
    assert solve(twin().mbs, 0.1, stepSize=2e-3, allowUnstableStep=True)["decidedBy"] == "stepSize"


def test_the_default_step_is_never_above_the_stability_limit(twin, solve):
    """Neither stepConstant nor stepSafety lift the limit that a given stepSize has to keep."""
    try:
        report = solve(twin().mbs, 0.1, stepConstant=5.0, stepSafety=1.5)
    except ValueError as error:
        assert "stepSafety" in str(error)
    else:
        assert report["stepSize"] <= report["bounds"].stability_limit


def test_a_run_that_left_what_a_cable_can_do_is_no_success(mbs, add_cable, solve):
    """A bent cable released between two pins; without a check it ends at 1e8 m, still finite."""
    phi = np.linspace(-0.6, 0.6, 9)
    sine, cosine = np.sin(phi), np.cos(phi)
    pin = [True, True, False, False]
    add_cable(
        mbs,
        shape=CableShape(np.column_stack([sine, -cosine]), np.column_stack([cosine, sine])),
        beamTemplate=InextensibleCable(0.0348, 1e-3),
        groundConstraintsStart=pin,
        groundConstraintsEnd=pin,
    )
    mbs.Assemble()
    with contextlib.suppress(DivergenceError):
        solve(mbs, 0.3)
    assert np.abs(mbs.systemData.GetODE2Coordinates()).max() < 2.0
