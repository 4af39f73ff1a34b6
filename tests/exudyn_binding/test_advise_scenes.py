"""Advise on scenes with bodies and joints: what it predicts holds when it is followed."""

import numpy as np
import pytest

from examples import crane, net, slider_crank, tethered_bodies
from exudyn_inext import AdviceSettings, Advise
from exudyn_inext.exudyn_binding.advising.pilot_runs import PilotRuns
from reference_models.conventional.native_cables import NativeCables
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import trajectory

SCENES = [(crane, 0.5, 1e-3), (tethered_bodies, 0.4, 5e-4), (slider_crank, 0.3, 1e-4), (net, 0.3, 2e-3)]
SAMPLES = 100
AXIAL = 1e6  # EA of native twins [N]


@pytest.fixture
def builder(new_mbs, add_sensor):
    """scene -> f(N) -> (mbs, sensor of a node of its first cable), also with other cables."""

    def of_scene(scene, **arguments):
        def build(elements):
            mbs = new_mbs()
            nodes = scene.build(mbs, elements=elements, **arguments)["cables"][0]["nodes"]
            sensor = add_sensor(mbs, nodes[len(nodes) // 2])
            mbs.Assemble()
            return mbs, sensor

        return build

    return of_scene


@pytest.fixture
def counted(monkeypatch):
    """CPU times are those of the pilots' steps, so that a busy machine has no say."""
    run_once = PilotRuns._run_once

    def with_steps(self, choice):
        pilot = run_once(self, choice)
        pilot.seconds = 1e-6 * pilot.steps * (10 + pilot.choice.elements)
        return pilot

    monkeypatch.setattr(PilotRuns, "_run_once", with_steps)


@pytest.mark.parametrize(("scene", "end", "tolerance"), SCENES)
def test_error_and_cost_are_those_predicted(builder, solve, counted, scene, end, tolerance):
    def run(elements, **explicit):
        mbs, sensor = builder(scene)(elements)
        report = solve(mbs, settings=quiet_settings(end, SAMPLES, end / SAMPLES), **explicit)
        return report, trajectory(mbs, sensor)[:, 1:]

    advice = Advise(builder(scene), tolerance, end, settings=AdviceSettings(samplePeriod=end / SAMPLES))
    _, exact = run(24, integrator="RATTLE", stepSize=5e-5)
    elements = advice["numberOfElements"]
    report, path = run(elements, **vars(advice["explicitSettings"]))
    achieved = np.linalg.norm(path - exact, axis=1).max()
    assert advice["predictedError"] / 2.0 < achieved < 2.0 * advice["predictedError"] <= 2.0 * tolerance
    cost = 1e-6 * report["steps"] * (10 + elements)
    assert cost == pytest.approx(advice["predictedSeconds"], rel=0.05)


def test_native_cables_are_weighed_among_bodies(builder, solve):
    """Stretch does not matter, so that they move alike within 1 %."""
    settings = AdviceSettings(
        samplePeriod=0.002,
        axialStiffness=AXIAL,
        buildConventional=builder(crane, addCable=NativeCables(AXIAL)),
    )
    with silence():
        advice = Advise(builder(crane), 1e-3, 0.4, settings=settings)
    native = [row for row in advice["tried"] if row["formulation"] == "conventional"]
    mbs, sensor = builder(crane)(6)
    solve(mbs, settings=quiet_settings(0.4, 20))
    assert min(row["error"] for row in native) < 0.01 * np.ptp(trajectory(mbs, sensor)[:, 1:], axis=0).max()
    assert advice["meetsTolerance"]
    assert any("what is observed differs by" in reason for reason in advice["reasons"])
