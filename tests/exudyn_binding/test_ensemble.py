"""Ensembles: every member moves as it would alone, on any number of threads; what must not differ."""

import re
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import exudyn
import numpy as np
import pytest

from exudyn_inext import (
    CableShape,
    CreateInextensibleCable,
    CreatePrescribedMotion,
    DivergenceError,
    ExplicitSettings,
    InextensibleCable,
    InputError,
    SceneError,
    SolveEnsemble,
    SolveExplicit,
    StepSizeError,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import hang, load_node

END = 0.3


def pendulum(stiffness=0.0866, tip_speed=0.0, elements=5, build=lambda mbs, nodes: None, **changes):
    """An assembled pendulum; `build` adds to it."""
    mbs = exudyn.SystemContainer().AddSystem()
    velocity = [0.0, tip_speed, 0.0]
    arguments = {
        "shape": CableShape.Line([0, 0, 0], [1.8, 0, 0], elements, velocityEnd=velocity),
        "beamTemplate": InextensibleCable(0.0348, stiffness, **changes.pop("section", {})),
        "gravity": [0, -9.81, 0],
        "groundConstraintsStart": [True, True, False, False],
    } | changes
    nodes = CreateInextensibleCable(mbs, **arguments)["nodes"]
    build(mbs, nodes)
    mbs.Assemble()
    return mbs


def ring(stiffness):
    """A ring that swings on its first node."""
    shape = CableShape.Circle([0, 0], 0.5, 8)
    return pendulum(stiffness, shape=shape)


def pushed(strength):
    """A force on the tip that depends on the time."""

    def force(mbs, t, load):
        return [0.0, strength * np.sin(10.0 * t), 0.0]

    return pendulum(build=lambda mbs, nodes: load_node(mbs, nodes[-1], [0] * 3, loadVectorUserFunction=force))


def shaken(amplitude):
    """The first node follows a motion."""

    def position(t):
        return [amplitude * (1.0 - np.cos(6.0 * t)), 0.0]

    return pendulum(
        build=lambda mbs, nodes: CreatePrescribedMotion(mbs, nodes[0], position), groundConstraintsStart=None
    )


def hung(height):
    """The first node hangs on a rod."""
    return pendulum(
        build=lambda mbs, nodes: hang(mbs, nodes[0], [0, height, 0], height), groundConstraintsStart=None
    )


def two_cables(stiffness):
    """Two cables whose steps are bounded alike."""
    mbs = pendulum(stiffness)
    CreateInextensibleCable(mbs, [0, 1, 0], [1.8, 1, 0], 4, InextensibleCable(0.0348, stiffness))
    mbs.Assemble()
    return mbs


def spatial(speed):
    return pendulum(
        dimension=3,
        groundConstraintsStart=[True] * 3 + [False] * 3,
        shape=CableShape.Line([0, 0, 0], [1.8, 0, 0], 5, velocityEnd=[0, 0, speed]),
    )


def moved(mbs, steps=1, **explicit):
    """(3, n) last coordinates, velocities and accelerations of a run of its own."""
    with silence():
        SolveExplicit(mbs, quiet_settings(END, steps), ExplicitSettings(**explicit))
    data = mbs.systemData
    return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])


def ensemble(build, parameters, threads=1, derivatives=2, **explicit):
    return SolveEnsemble(
        build, quiet_settings(END, 1), ExplicitSettings(**explicit), parameters, derivatives, threads
    )


def last(result):
    """(members, 3, n)"""
    return np.stack([result[name][:, -1] for name in ("coordinates", "velocities", "accelerations")], axis=1)


@pytest.mark.parametrize(
    ("build", "parameters", "explicit"),
    [
        (pendulum, [0.05, 0.0866, 0.1], {}),
        (pendulum, [0.05, 0.0866, 0.1], {"integrator": "Zhai"}),
        (pendulum, [0.05, 0.0866], {"stepSize": 5e-3, "massScaling": 0.3}),
        (pushed, [0.1, 0.2], {}),
        (shaken, [0.1, 0.2], {}),
        (hung, [0.3, 0.5], {}),
        (ring, [0.05, 0.0866], {}),
        (two_cables, [0.05, 0.0866], {}),
        (spatial, [0.0, 0.5], {}),
    ],
)
def test_every_member_moves_bit_for_bit_as_it_does_alone(build, parameters, explicit):
    result = ensemble(build, parameters, **explicit)
    assert result["status"] == ["ok"] * len(parameters)
    steps = zip(result["stepSize"], result["massScaling"], strict=True)
    for member, values, (step, theta) in zip(last(result), parameters, steps, strict=True):
        alone = moved(build(values), **(explicit | {"stepSize": step, "massScaling": theta}))
        np.testing.assert_array_equal(member, alone)
    assert np.abs(np.diff(last(result), axis=0)).max() > 1e-3  # the parameters matter


def test_the_interpreter_is_left_as_it_was():
    """Threads take shorter turns while members are read; after a run, and after an error, as before."""
    before, during = sys.getswitchinterval(), []

    def watched(parameter):
        during.append(sys.getswitchinterval())
        if parameter is None:
            raise ValueError("no parameter")
        return pendulum(parameter)

    ensemble(watched, [0.1, 0.2, 0.3], threads=2, stepSize=1e-3)  # given, so that they are read meanwhile
    assert max(during[1:]) < before and sys.getswitchinterval() == before
    with pytest.raises(ValueError, match="no parameter"):
        ensemble(watched, [0.1, None], threads=2, stepSize=1e-3)
    assert sys.getswitchinterval() == before


def test_overlapping_ensembles_leave_the_interpreter_as_it_was():
    """One begins first and ends first: the other one must not put back what it has found."""
    before, during = sys.getswitchinterval(), []
    second_has_begun, first_has_ended = threading.Event(), threading.Event()

    def first(number):
        if number == 1:
            assert second_has_begun.wait(60)
        return pendulum()

    def second(number):
        if number == 1:
            second_has_begun.set()
            assert first_has_ended.wait(60)
            during.append(sys.getswitchinterval())
        return pendulum()

    with ThreadPoolExecutor(2) as pool:
        one, other = (pool.submit(ensemble, f, [0, 1], threads=2, stepSize=1e-3) for f in (first, second))
        assert one.result()["success"]
        first_has_ended.set()
        assert other.result()["success"]
    assert during[0] < before and sys.getswitchinterval() == before


def test_threads_change_no_bit():
    parameters = np.linspace(0.05, 0.1, 11)
    one, two = (ensemble(pendulum, parameters, threads) for threads in (1, 2))
    for name in ("coordinates", "velocities", "accelerations", "times", "referenceCoordinates"):
        np.testing.assert_array_equal(one[name], two[name])
    assert (one["threads"], two["threads"]) == (1, 2)


def test_results_are_what_a_sensor_stores(add_sensor):
    mbs = pendulum(tip_speed=0.5)
    tip = add_sensor(mbs, 5)
    mbs.Assemble()
    settings = quiet_settings(END, 1, period=0.02)
    result = SolveEnsemble([mbs, pendulum()], settings, derivatives=1)
    assert mbs.GetSensorStoredData(tip).size == 0
    with silence():
        SolveExplicit(mbs, settings)
    stored = np.asarray(mbs.GetSensorStoredData(tip))
    assert result["coordinates"].shape == result["velocities"].shape == (2, 16, 24)
    assert "accelerations" not in result
    positions = result["coordinates"][0] + result["referenceCoordinates"][0]
    np.testing.assert_allclose(positions[:, -4:-2], stored[:, 1:3], atol=1e-14)
    np.testing.assert_allclose(result["times"], stored[:, 0], atol=1e-14)
    assert result["velocities"][0, 0, -3] == 0.5
    assert result["steps"] == pytest.approx(END / result["stepSize"])


def test_the_systems_stay_as_they_are(contents):
    systems = [pendulum(), pendulum(0.1)]
    before = [contents(mbs) for mbs in systems]
    SolveEnsemble(systems, quiet_settings(END, 1))
    assert [contents(mbs) for mbs in systems] == before


def test_a_builder_may_change_and_return_the_same_system():
    mbs = pendulum()

    def with_speed(speed):
        mbs.SetNodeParameter(5, "initialVelocities", [0, speed, 0, speed / 1.8])
        for node in range(1, 6):
            share = node / 5
            mbs.SetNodeParameter(node, "initialVelocities", [0, share * speed, 0, speed / 1.8])
        mbs.SetNodeParameter(0, "initialVelocities", [0, 0, 0, speed / 1.8])
        mbs.Assemble()
        return mbs

    result = ensemble(with_speed, [0.0, 0.5])
    expected = ensemble(lambda speed: pendulum(tip_speed=speed), [0.0, 0.5])
    np.testing.assert_allclose(result["coordinates"], expected["coordinates"], atol=1e-12)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_member_that_diverges_leaves_the_others_alone(threads, fault, without_smaller_steps):
    """With this step the pendulum of 0.0866 N m^2 is stable, the one of 0.4 N m^2 is not."""
    step = {"stepSize": 2.5e-3, "allowUnstableStep": True}
    with pytest.warns(UserWarning, match="of member 1"):
        result = ensemble(pendulum, [0.0866, 0.4, 0.05], threads, **step)
    assert not result["success"]
    assert [status == "ok" for status in result["status"]] == [True, False, True]
    with pytest.warns(UserWarning), pytest.raises(DivergenceError, match="before t") as alone:
        moved(pendulum(0.4), steps=30, **step)
    time = result["divergenceTimes"][1]
    alone_until = float(re.search(r"before t = ([\d.]+) s", str(alone.value))[1])
    assert result["status"][1] == f"diverged before t = {time:.6g} s"
    assert time == pytest.approx(alone_until)
    states = result["coordinates"]
    np.testing.assert_array_equal(np.isnan(states[1]).all(axis=1), result["times"] > time - 1e-9)
    np.testing.assert_array_equal(np.isfinite(states[1]).all(axis=1), result["times"] < time - 1e-9)
    assert np.isnan(result["divergenceTimes"][[0, 2]]).all()
    for number, stiffness in ((0, 0.0866), (2, 0.05)):
        np.testing.assert_array_equal(last(result)[number], moved(pendulum(stiffness), stepSize=2.5e-3))
    fault(f"one member of an ensemble diverges ({threads} thread(s))", "the others are as alone, bit for bit")


def test_a_step_above_the_limit_of_one_member_is_refused():
    with pytest.raises(StepSizeError, match=r"member 1 of the ensemble: stepSize = 0.0025 s is above"):
        ensemble(pendulum, [0.0866, 0.4], stepSize=2.5e-3)


def test_members_may_differ_in_all_but_the_number_of_coordinates():
    """Damping, links, curvature measure, load histories: each moves as alone."""
    builders = [
        pendulum,
        partial(pendulum, section={"bendingDamping": 1e-4}),
        partial(pendulum, section={"curvatureMeasure": "product"}),
        partial(pendulum, groundConstraintsStart=[True, False, False, False]),
        partial(pushed, 1.0),
    ]
    result = SolveEnsemble([build() for build in builders], quiet_settings(END, 1), derivatives=2)
    for number, build in enumerate(builders):
        step, theta = result["stepSize"][number], result["massScaling"][number]
        np.testing.assert_array_equal(last(result)[number], moved(build(), stepSize=step, massScaling=theta))
    assert np.abs(np.diff(last(result)[:, 0], axis=0)).max(axis=1).min() > 1e-6


@pytest.mark.parametrize("other", [partial(pendulum, elements=6), partial(two_cables, 0.05)])
def test_members_with_other_numbers_of_coordinates_are_refused(other):
    said = r"member 2 of the ensemble: number of coordinates = \d+, that of member 0 is 24"
    with pytest.raises(InputError, match=said):
        SolveEnsemble([pendulum(), pendulum(0.1), other()], quiet_settings(END, 1))


def watched():
    mbs = pendulum()
    mbs.SetPreStepUserFunction(lambda mbs, t: True)
    return mbs


def not_assembled():
    mbs = pendulum()
    CreateInextensibleCable(mbs, [0, 1, 0], [1.8, 1, 0], 4, InextensibleCable(0.0348, 0.0866))
    return mbs


@pytest.mark.parametrize(
    ("systems", "arguments", "error", "message"),
    [
        (list, {}, InputError, "the ensemble is empty"),
        (lambda: [pendulum()], {"parameters": [1.0]}, InputError, "systems is no function"),
        (lambda: pendulum, {}, InputError, "parameters are missing"),
        (lambda: pendulum, {"parameters": []}, InputError, "the ensemble is empty"),
        (lambda: lambda p: None, {"parameters": [1]}, InputError, "member 0 .*: None is no system"),
        (lambda: [pendulum(), not_assembled()], {}, SceneError, "member 1 .*: mbs is not assembled"),
        (lambda: [watched()], {}, SceneError, "member 0 .*: mbs has a pre- or post-step user function"),
        (
            lambda: [pushed(1.0)],
            {"explicitSettings": ExplicitSettings(dependsOnTimeOnly=False)},
            SceneError,
            r"load 0 .* may depend on the state.*dependsOnTimeOnly=",
        ),
        (lambda: [pendulum()], {"threads": 0}, InputError, "threads = 0: must be an integer of at least 1"),
        (lambda: [pendulum()], {"derivatives": 3}, InputError, "derivatives = 3: must be .* at most 2"),
    ],
)
def test_what_is_no_ensemble_is_refused(systems, arguments, error, message):
    with pytest.raises(error, match=message):
        SolveEnsemble(systems(), quiet_settings(END, 1), **arguments)


def test_progress_is_shown_where_exudyn_would_show_it(capsys):
    for verbose in (0, 1):
        settings = quiet_settings(0.02, 2)
        settings.timeIntegration.verboseMode = verbose
        SolveEnsemble(pendulum, settings, parameters=[0.05, 0.0866, 0.1])
        assert ("3/3" in capsys.readouterr().err) == bool(verbose)


def test_a_member_whose_steps_go_wrong_takes_smaller_ones_as_alone():
    step = {"stepSize": 2.5e-3, "allowUnstableStep": True}
    with pytest.warns(UserWarning, match="of member 1"):
        result = ensemble(pendulum, [0.0866, 0.4, 0.05], 2, **step)
    assert result["success"]
    with pytest.warns(UserWarning):
        np.testing.assert_array_equal(last(result)[1], moved(pendulum(0.4), steps=30, **step))


def test_progress_is_left_out_where_tqdm_is_not_installed(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    settings = quiet_settings(0.01, 1)
    settings.timeIntegration.verboseMode = 1
    assert SolveEnsemble([pendulum()], settings)["success"]
    assert "SolveEnsemble" not in capsys.readouterr().err
