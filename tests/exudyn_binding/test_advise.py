"""Advise on short scenes: what it promises is what a run gives, and why is said."""

import re
from functools import partial

import numpy as np
import pytest
from exudyn.utilities import InertiaCuboid, LoadForceVector, MarkerNodePosition

from exudyn_inext import AdviceSettings, Advise, AttachToBody, InextensibleCable
from exudyn_inext.advice.pilot import CONVENTIONAL, EXTENSIBLE, INEXTENSIBLE, Choice
from exudyn_inext.exudyn_binding.advising.pilot_runs import PilotRuns
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import native_cable, solve_native, trajectory

END, TOLERANCE = 0.4, 2e-3
LINE = {"positionEnd": [0.6, 0, 0]}
SECTION = {"massPerLength": 0.08, "bendingStiffness": 0.02}
FEW = (4, 6, 8)
FEW_SAMPLES = 0.01  # [s]


@pytest.fixture
def build(new_mbs, add_pendulum, add_sensor):
    """N -> (mbs, sensor) of a short pendulum, released when horizontal; `built` holds all mbs."""

    def build(elements):
        mbs = new_mbs()
        cable = add_pendulum(
            mbs, **LINE, numberOfElements=elements, beamTemplate=InextensibleCable(**SECTION)
        )
        sensor = add_sensor(mbs, cable["nodes"][-1], build.quantity)
        mbs.Assemble()
        build.built.append((elements, mbs))
        return mbs, sensor

    build.built, build.quantity = [], "Position"
    return build


@pytest.fixture
def build_native(new_mbs, add_sensor, build):
    """(EA, N) -> (mbs, sensor) of the same with native cables."""

    def build_it(axial_stiffness, elements):
        mbs = new_mbs()
        pinned = {"groundConstraintsStart": [True, True, False, False]}
        cable = native_cable(mbs, 2, elements, SECTION, axial_stiffness, **LINE, **pinned)
        sensor = add_sensor(mbs, cable["nodes"][-1], build.quantity)
        mbs.Assemble()
        return mbs, sensor

    return build_it


@pytest.fixture
def tip_of(build, solve):
    """(N, settings) -> (T, 3) path of the tip."""

    def run(elements, end=END, **explicit):
        mbs, sensor = build(elements)
        settings = quiet_settings(end, 100)
        settings.solution.sensors.writePeriod = end / 100
        solve(mbs, settings=settings, **explicit)
        return trajectory(mbs, sensor)[:, 1:]

    return run


def sentence(advice, words):
    return any(words in reason for reason in advice["reasons"])


def test_the_achieved_error_is_near_the_predicted_one_and_within_the_tolerance(build, tip_of):
    advice = Advise(build, TOLERANCE, END)
    assert advice["formulation"] == INEXTENSIBLE and advice["dimension"] == 2
    assert advice["meetsTolerance"] and advice["meetsBudget"] and not advice["extrapolated"]
    number, explicit = advice["numberOfElements"], advice["explicitSettings"]
    assert advice["numberOfLengthConstraints"] == number
    assert (advice["integrator"], advice["stepSize"]) == (explicit.integrator, explicit.stepSize)
    fine = tip_of(48, integrator="Zhai")
    path = tip_of(number, **vars(explicit))
    achieved = np.linalg.norm(path - fine, axis=1).max()
    assert achieved <= TOLERANCE
    assert advice["predictedError"] / 3.0 < achieved < 3.0 * advice["predictedError"]
    cheapest = min(row["seconds"] for row in advice["tried"] if row["error"] <= TOLERANCE)
    assert advice["predictedSeconds"] == cheapest
    assert advice["pilotSeconds"] == pytest.approx(sum(row["seconds"] for row in advice["tried"]))


def test_an_extrapolated_mesh_keeps_the_tolerance(build, tip_of):
    tolerance = 3e-5
    advice = Advise(build, tolerance, END, settings=AdviceSettings(numbersOfElements=FEW))
    assert advice["extrapolated"] and advice["numberOfElements"] > FEW[-1]
    assert advice["meetsTolerance"] and sentence(advice, "extrapolated from coarser meshes")
    path = tip_of(advice["numberOfElements"], stepSize=advice["stepSize"])
    fine = tip_of(48, integrator="Zhai")
    achieved = np.linalg.norm(path - fine, axis=1).max()
    assert achieved <= advice["predictedError"] <= tolerance
    assert np.linalg.norm(tip_of(FEW[-1]) - fine, axis=1).max() > tolerance  # it had to be finer


def test_each_pilot_has_a_scene_of_its_own_and_those_of_the_user_stay_as_they_are(build, contents):
    mine, _ = build(6)
    before = contents(mine)
    build.built.clear()
    advice = Advise(build, TOLERANCE, 0.1, settings=AdviceSettings(numbersOfElements=FEW))
    assert contents(mine) == before
    assert len(build.built) > len(advice["tried"])
    assert len({id(mbs) for _, mbs in build.built}) == len(build.built)
    assert {elements for elements, _ in build.built} == set(FEW)


def test_a_budget_that_is_too_small_gives_the_most_accurate_run_within_it(build):
    settings = AdviceSettings(numbersOfElements=FEW)
    free = Advise(build, 1e-4, END, settings=settings)
    none = Advise(build, 1e-4, END, budget=1e-9, settings=settings)
    assert free["meetsBudget"] and not none["meetsBudget"]
    assert sentence(none, "No pilot took less than the budget of 1e-09 s")


@pytest.mark.parametrize("tolerance", [1.2e-4, 2e-5], ids=["measured", "extrapolated"])
def test_within_a_budget(build, monkeypatch, tolerance):
    """CPU times are replaced by the steps of a run, so that a busy machine has no say."""
    run_once = PilotRuns._run_once

    def counted(self, choice):
        pilot = run_once(self, choice)
        object.__setattr__(pilot, "seconds", 1e-3 * pilot.steps * pilot.choice.elements)
        return pilot

    monkeypatch.setattr(PilotRuns, "_run_once", counted)
    settings = AdviceSettings(numbersOfElements=FEW)
    free = Advise(build, tolerance, END, settings=settings)
    budget = 0.7 * free["predictedSeconds"]
    advice = Advise(build, tolerance, END, budget, settings)
    affordable = [row for row in advice["tried"] if row["seconds"] <= budget]
    assert advice["meetsBudget"] and not advice["meetsTolerance"] and not advice["extrapolated"]
    assert advice["predictedError"] == min(row["error"] for row in affordable)
    assert sentence(advice, "more than the budget") and free["extrapolated"] == (tolerance < 1e-4)


def test_rubber_is_given_its_axial_stiffness(build, build_native, new_mbs, add_pendulum, add_sensor, solve):
    """What is advised, followed, moves as fine native cables do."""
    advice = Advise(build, 5e-3, END, settings=AdviceSettings(axialStiffness=50.0, numbersOfElements=FEW))
    assert advice["formulation"] == EXTENSIBLE and advice["axialStiffness"] == 50.0
    assert advice["meetsTolerance"] and advice["numberOfLengthConstraints"] is None
    assert sentence(advice, "axialStiffness = 50 N, what is observed differs by") and sentence(
        advice, "With it a step costs"
    )
    rigid = [row["error"] for row in advice["tried"] if row["formulation"] == INEXTENSIBLE]
    assert min(rigid) > 5e-3  # stretch is an error of theirs
    mbs = new_mbs()
    template = InextensibleCable(**SECTION, axialStiffness=advice["axialStiffness"])
    cable = add_pendulum(mbs, **LINE, numberOfElements=advice["numberOfElements"], beamTemplate=template)
    tip = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    solve(mbs, END, steps=40, **vars(advice["explicitSettings"]))
    native, sensor = build_native(50.0, 24)
    solve_native(native, END, 5e-4)
    fine = trajectory(native, sensor)[:, 1:]
    assert np.linalg.norm(trajectory(mbs, tip)[:, 1:] - fine, axis=1).max() < 5e-3


def test_scenes_whose_cables_stretch_are_taken_as_they_are(new_mbs, add_pendulum, add_sensor, build_native):
    def build(elements):
        mbs, template = new_mbs(), InextensibleCable(**SECTION, axialStiffness=50.0)
        cable = add_pendulum(mbs, **LINE, numberOfElements=elements, beamTemplate=template)
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return mbs, tip

    native = AdviceSettings(
        FEW_SAMPLES, FEW, axialStiffness=50.0, buildConventional=partial(build_native, 50.0)
    )
    advice = Advise(build, 5e-3, END, settings=native)
    assert {row["formulation"] for row in advice["tried"]} == {EXTENSIBLE, CONVENTIONAL}
    assert {row["integrator"] for row in advice["tried"]} == {"RATTLE", "generalizedAlpha"}
    assert advice["meetsTolerance"] and not sentence(advice, "what is observed differs by")


def test_a_stiff_cable_stays_inextensible_beside_native_ones(build, build_native):
    settings = AdviceSettings(
        axialStiffness=1e6, buildConventional=partial(build_native, 1e6), numbersOfElements=FEW
    )
    advice = Advise(build, 2e-3, END, settings=settings)
    assert advice["formulation"] == INEXTENSIBLE and sentence(advice, "within the tolerance of 0.002")
    assert any(row["formulation"] == CONVENTIONAL for row in advice["tried"])


def test_native_scenes_that_fail_are_kept_and_said(build, build_native):
    def stops(elements):
        mbs, sensor = build_native(1e4, elements)
        mbs.SetPreStepUserFunction(lambda mbs, t: t < 0.1)
        return mbs, sensor

    settings = AdviceSettings(buildConventional=stops, numbersOfElements=FEW)
    advice = Advise(build, TOLERANCE, END, settings=settings)
    failed = [row for row in advice["tried"] if row["failure"]]
    assert failed and {row["formulation"] for row in failed} == {CONVENTIONAL}
    assert advice["formulation"] == INEXTENSIBLE and sentence(advice, "reached its end: stopped at t = 0.1")


@pytest.mark.parametrize("quantity", ["Position", "Velocity"])
def test_what_stretch_moves_is_what_native_cables_show(build, build_native, quantity):
    """It was an estimate for positions."""
    build.quantity, stiffness = quantity, 200.0
    settings = AdviceSettings(
        axialStiffness=stiffness, numbersOfElements=(6, 9, 12), samplePeriod=FEW_SAMPLES
    )
    advice = Advise(build, 5.0, END, settings=settings)
    (said,) = (reason for reason in advice["reasons"] if "axialStiffness = 200 N" in reason)
    soft, stiff = (
        PilotRuns(build, partial(build_native, scale * stiffness), END, FEW_SAMPLES) for scale in (1.0, 100.0)
    )
    native = Choice(CONVENTIONAL, "generalizedAlpha", 8, 1e-3)
    measured = soft.run(native).distance(stiff.run(native))
    assert float(re.search(r"differs by ([\d.e+-]+),", said)[1]) == pytest.approx(measured, rel=0.15)
    assert measured > 1e-3 and "within the tolerance of 5" in said


def test_a_body_on_the_end_of_the_cable(new_mbs, add_pendulum, add_sensor, solve):
    def build(elements):
        mbs = new_mbs()
        cable = add_pendulum(mbs, numberOfElements=elements)
        body = mbs.CreateRigidBody(
            referencePosition=[1.85, 0, 0],
            inertia=InertiaCuboid(1000, [0.1, 0.02, 0.02]),
            gravity=[0, -9.81, 0],
            returnDict=True,
        )
        AttachToBody(mbs, cable, "end", body["bodyNumber"], [-0.05, 0, 0])
        sensor = add_sensor(mbs, body["nodeNumber"])
        mbs.Assemble()
        return mbs, sensor

    settings = AdviceSettings(samplePeriod=5e-3, numbersOfElements=(2, 3, 4), axialStiffness=1e5)
    advice = Advise(build, 1e-2, 0.1, settings=settings)
    assert advice["meetsTolerance"] and sentence(advice, "what is observed differs by")
    mbs, _ = build(advice["numberOfElements"])
    with silence():
        assert solve(mbs, 0.1, **vars(advice["explicitSettings"]))["success"]


def test_runs_are_sampled_alike_whatever_the_period(build, build_native):
    """A period that does not divide the end time is made to."""
    runs = PilotRuns(build, partial(build_native, 1e5), 0.1, 0.03)
    assert runs.period == pytest.approx(0.1 / 3.0)
    own = runs.run(Choice(INEXTENSIBLE, "RATTLE", 4, 1e-3))
    native = runs.run(Choice(CONVENTIONAL, "generalizedAlpha", 4, runs.period / 2))
    assert own.values.shape == native.values.shape == (4, 3)
    assert own.distance(native) < 0.01


def test_a_step_that_is_refused_is_a_failure_of_that_choice(build):
    pilot = PilotRuns(build, None, 0.1, 0.1).run(Choice(INEXTENSIBLE, "RATTLE", 8, 0.05))
    assert "above" in pilot.failure and "stability limit" in pilot.failure


def test_step_functions_are_to_be_called_as_often_as_by_the_pilots(new_mbs, add_pendulum, add_sensor, solve):
    """Fewer steps of the loop change the motion, whatever the step of the integrator."""

    def build(elements):
        mbs = new_mbs()
        cable = add_pendulum(
            mbs, **LINE, numberOfElements=elements, beamTemplate=InextensibleCable(**SECTION)
        )
        tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
        load = mbs.AddLoad(LoadForceVector(markerNumber=tip))

        def push(mbs, t):
            mbs.SetLoadParameter(load, "loadVector", [0.5 * np.sin(40.0 * t), 0, 0])
            return True

        mbs.SetPreStepUserFunction(push)
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return mbs, sensor

    advice = Advise(build, TOLERANCE, END)
    (said,) = (reason for reason in advice["reasons"] if "step functions" in reason)
    steps = int(re.search(r"numberOfSteps = (\d+) or more", said)[1])

    def path(steps, elements, **explicit):
        mbs, sensor = build(elements)
        settings = quiet_settings(END, steps)
        settings.solution.sensors.writePeriod = END / 10
        solve(mbs, settings=settings, **explicit)
        return trajectory(mbs, sensor)[:, 1:]

    exact = path(4000, 24)
    advised = advice["numberOfElements"], vars(advice["explicitSettings"])
    few, many = (
        np.linalg.norm(path(number, advised[0], **advised[1]) - exact, axis=1).max() for number in (10, steps)
    )
    assert many < TOLERANCE < few


def test_length_constraints_are_those_of_the_scene(new_mbs, add_pendulum, add_sensor):
    def build(elements):
        mbs = new_mbs()
        template = InextensibleCable(**SECTION, numberOfLengthConstraints=2)
        cable = add_pendulum(mbs, **LINE, numberOfElements=elements, beamTemplate=template)
        sensor = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        return mbs, sensor

    settings = AdviceSettings(numbersOfElements=FEW)
    assert Advise(build, 0.05, 0.05, settings=settings)["numberOfLengthConstraints"] == 2
