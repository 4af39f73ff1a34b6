"""Sensors, solution files and user functions work as with any run of Exudyn's time loop."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import SensorObject
from exudyn.utilities import LoadSolutionFile

from exudyn_inext import CableShape, DivergenceError, SceneError
from reference_models.model import quiet_settings
from tests.exudyn_binding.items import load_node


def state(mbs):
    data = mbs.systemData
    return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])


def stored(built):
    return np.asarray(built.mbs.GetSensorStoredData(built.tip))


@pytest.mark.parametrize("period", [0.01, 0.05])
def test_sensors_are_stored_at_their_write_period(twin, solve, period):
    built = twin()
    report = solve(built.mbs, settings=quiet_settings(0.2, 1, period))
    np.testing.assert_allclose(stored(built)[:, 0], np.arange(0, 0.2 + 1e-9, period), atol=1e-12)
    multiple = period / report["stepSize"]
    assert multiple == pytest.approx(round(multiple), abs=1e-9)
    assert report["loopSteps"] == round(0.2 / period)


def test_a_run_may_start_late(twin, solve):
    early, late = twin(), twin()
    solve(early.mbs, 0.1)
    settings = quiet_settings(1.1, 1)
    settings.timeIntegration.startTime = 1.0
    solve(late.mbs, settings=settings)
    np.testing.assert_allclose(stored(late)[:, 0], 1.0 + stored(early)[:, 0], atol=1e-12)
    np.testing.assert_allclose(stored(late)[:, 1:], stored(early)[:, 1:], atol=1e-12)


def test_a_solution_file_holds_the_motion_that_the_sensor_saw(twin, solve, tmp_path):
    built = twin()
    settings = quiet_settings(0.1, 1)
    settings.solution.file.write = True
    settings.solution.file.name = str(tmp_path / "solution.txt")
    settings.solution.file.writePeriod = 0.01
    solve(built.mbs, settings=settings)
    solution = LoadSolutionFile(settings.solution.file.name, verbose=False)
    assert solution["columnsExported"][:3] == [24, 24, 24]
    times, tips = solution["data"][:, 0], solution["data"][:, [21, 22]] + [1.8, 0.0]
    np.testing.assert_allclose(times, stored(built)[:, 0], atol=1e-12)
    np.testing.assert_allclose(tips, stored(built)[:, 1:3], atol=1e-9)
    last = solution["data"][-1, 1:73].reshape(3, 24)
    np.testing.assert_allclose(last, state(built.mbs), rtol=1e-8, atol=1e-8)


def test_write_periods_that_make_very_many_steps_are_told_of(twin, solve):
    """What native solvers write at each of their steps; 0, as advised, writes each step here, too."""
    settings = quiet_settings(0.01, 1)
    settings.solution.sensors.writePeriod = 1e-6
    with pytest.warns(UserWarning, match="10000 steps of 1e-06 s.*sensors.writePeriod.*0 writes each step"):
        solve(twin().mbs, settings=settings)
    settings.solution.sensors.writePeriod = 0.0
    built = twin()
    report = solve(built.mbs, settings=settings)
    assert len(stored(built)) == report["steps"] + 1 < 100


def test_step_user_functions_are_called_once_a_step_and_see_the_state(twin, solve):
    """As with Exudyn's own solvers: before a step, with its end time; after it; at the start."""
    built, before, after = twin(), [], []

    def watch(seen):
        def user_function(mbs, t):
            seen.append((t, mbs.systemData.GetODE2Coordinates()[-3]))
            return True

        return user_function

    built.mbs.SetPreStepUserFunction(watch(before))
    built.mbs.SetPostStepUserFunction(watch(after))
    report = solve(built.mbs, 0.1)
    tips, times = stored(built)[:, 2], np.arange(11) / 100
    assert report["loopSteps"] == 10
    np.testing.assert_allclose([t for t, _ in before], times[1:], atol=1e-12)
    np.testing.assert_allclose([t for t, _ in after], times, atol=1e-12)
    np.testing.assert_array_equal([y for _, y in before], tips[:-1])
    np.testing.assert_array_equal([y for _, y in after], tips)


def test_a_pre_step_function_that_sets_velocities_restarts_the_motion(mbs, add_cable, solve):
    shape = CableShape.Line([0, 0], [1, 0], 3, velocityStart=[1, 2], velocityEnd=[1, 2])
    add_cable(mbs, shape=shape, gravity=[0, 0, 0])
    mbs.Assemble()

    def stop_before_the_fifth_step(mbs, t):
        if abs(t - 0.05) < 1e-9:
            mbs.systemData.SetODE2Coordinates_t(np.zeros(16))
        return True

    mbs.SetPreStepUserFunction(stop_before_the_fifth_step)
    solve(mbs, 0.1, steps=10)
    displacement = np.reshape(mbs.systemData.GetODE2Coordinates(), (4, 4))[:, :2]
    np.testing.assert_allclose(displacement, np.tile([0.04, 0.08], (4, 1)), atol=1e-12)
    np.testing.assert_allclose(state(mbs)[1], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("register", "calls"), [("SetPreStepUserFunction", 10), ("SetPostStepUserFunction", 11)]
)
def test_a_step_function_that_moves_the_cable_moves_it(mbs, add_cable, solve, register, calls):
    add_cable(mbs, gravity=[0, 0, 0])
    mbs.Assemble()

    def lift(mbs, t):
        q = np.reshape(mbs.systemData.GetODE2Coordinates(), (6, 4))
        q[:, 1] += 0.1
        mbs.systemData.SetODE2Coordinates(q.ravel())
        return True

    getattr(mbs, register)(lift)
    solve(mbs, 0.1, steps=10)
    height = np.reshape(mbs.systemData.GetODE2Coordinates(), (6, 4))[:, 1]
    np.testing.assert_allclose(height, 0.1 * calls, atol=1e-9)


def test_a_pre_step_function_can_end_the_run(twin, solve):
    built = twin()
    built.mbs.SetPreStepUserFunction(lambda mbs, t: t < 0.05 - 1e-9)
    solve(built.mbs, 0.1)
    assert built.mbs.systemData.GetTime() <= 0.05 + 1e-9


def test_looking_ahead_changes_no_bit(twin, solve):
    ahead, watched = twin(), twin()
    watched.mbs.SetPostStepUserFunction(lambda mbs, t: True)
    fast, slow = solve(ahead.mbs, 0.5), solve(watched.mbs, 0.5)
    assert "50 of Exudyn's steps in one compiled call" in fast["path"]
    assert "one call for each of Exudyn's steps" in slow["path"]
    np.testing.assert_array_equal(stored(ahead), stored(watched))
    np.testing.assert_array_equal(state(ahead.mbs), state(watched.mbs))


def test_a_run_far_from_the_origin_is_that_beside_it(new_mbs, add_pendulum, solve):
    def tip(place):
        mbs = new_mbs()
        node = add_pendulum(mbs, positionStart=place, positionEnd=np.add(place, [1.8, 0, 0]))["nodes"][-1]
        mbs.Assemble()
        solve(mbs, 0.5)
        return mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position) - place

    np.testing.assert_allclose(tip(np.array([1e5, -1e5, 0.0])), tip(np.zeros(3)), atol=1e-8)


def test_a_second_run_of_the_same_system_repeats_every_bit(twin, solve):
    built = twin()
    solve(built.mbs, 0.3)
    first = stored(built).copy(), state(built.mbs)
    solve(built.mbs, 0.3)
    np.testing.assert_array_equal(stored(built), first[0])
    np.testing.assert_array_equal(state(built.mbs), first[1])


def test_two_cables_in_one_system_move_as_each_alone(new_mbs, add_pendulum, add_cable, solve):
    pendulum = {}
    free = {"numberOfElements": 3, "positionStart": [0, 1, 0], "positionEnd": [1, 1, 0]}
    free |= {"groundConstraintsStart": [True] * 4}

    def motion(*cables):
        mbs = new_mbs()
        for cable in cables:
            add_pendulum(mbs, **cable)
        mbs.Assemble()
        solve(mbs, 0.2, stepSize=1e-3)
        return state(mbs)

    together = motion(pendulum, free)
    np.testing.assert_array_equal(together[:, :24], motion(pendulum))
    np.testing.assert_array_equal(together[:, 24:], motion(free))


def test_settings_are_as_before_and_kept_in_the_system_after_a_run(twin, solve):
    built, settings = twin(), quiet_settings(0.1, 3)
    before = repr(settings.GetDictionary())
    solve(built.mbs, settings=settings)
    assert repr(settings.GetDictionary()) == before
    assert repr(built.mbs.sys["simulationSettings"].GetDictionary()) == before
    assert isinstance(built.mbs.sys["dynamicSolver"], exudyn.MainSolverImplicitSecondOrder)


def test_settings_are_as_before_after_a_failing_run(twin, solve, without_smaller_steps):
    built, settings = twin(), quiet_settings(5.0, 3)
    before = repr(settings.GetDictionary())
    with pytest.warns(UserWarning, match="stepSize"), pytest.raises(DivergenceError):
        solve(built.mbs, settings=settings, stepSize=5e-3, allowUnstableStep=True)
    assert repr(settings.GetDictionary()) == before


def test_a_system_can_be_run_again_after_a_divergence(twin, solve, without_smaller_steps):
    built, fresh = twin(), twin()
    with pytest.warns(UserWarning, match="stepSize"), pytest.raises(DivergenceError):
        solve(built.mbs, 5.0, stepSize=5e-3, allowUnstableStep=True)
    solve(built.mbs, 0.1)
    solve(fresh.mbs, 0.1)
    np.testing.assert_array_equal(state(built.mbs), state(fresh.mbs))


def test_numberOfSteps_is_a_lower_bound_of_the_steps_of_the_loop(twin, solve):
    assert solve(twin().mbs, 0.1, steps=25)["loopSteps"] >= 25


def test_a_system_without_anything_is_refused(mbs, solve):
    mbs.Assemble()
    with pytest.raises(SceneError):
        solve(mbs)


@pytest.mark.parametrize("among_others", [False, True])
def test_an_interrupt_leaves_a_system_that_runs_again(new_mbs, add_pendulum, solve, among_others, fault):
    mbs = new_mbs()
    add_pendulum(mbs)
    if among_others:
        mbs.CreateMassPoint(mass=1.0, referencePosition=[0, 0, 0])
    mbs.Assemble()

    def interrupt(mbs, t):
        if t > 0.05:
            raise KeyboardInterrupt
        return True

    mbs.SetPreStepUserFunction(interrupt)
    with pytest.raises(KeyboardInterrupt, match=r"interrupted at t = 0\.0\d+ s"):
        solve(mbs, 0.1, steps=10)
    assert np.isfinite(mbs.systemData.GetODE2Coordinates()).all()
    mbs.SetPreStepUserFunction(lambda mbs, t: True)
    assert solve(mbs, 0.1, steps=10)["success"]
    assert mbs.systemData.GetTime() == pytest.approx(0.1)
    where = "among bodies" if among_others else "cables alone"
    fault(f"Ctrl-C in a run ({where})", "KeyboardInterrupt with the time; the same mbs runs again")


@pytest.mark.parametrize("where", ["before a step", "in a load"])
def test_an_error_of_a_function_leaves_a_state_of_one_time(mbs, add_pendulum, solve, where):
    tip, data, seen = add_pendulum(mbs)["nodes"][-1], mbs.systemData, []

    def present():
        return [data.GetTime(), *data.GetODE2Coordinates(), *data.GetODE2Coordinates_t()]

    def fail_late(mbs, t, force=True):
        mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Position)
        if t > 0.0505:
            raise ValueError("mine")
        return force

    if where == "in a load":
        load_node(mbs, tip, [0, 0, 0], loadVectorUserFunction=fail_late)
    else:
        mbs.SetPreStepUserFunction(fail_late)
    mbs.SetPostStepUserFunction(lambda mbs, t: seen.append(present()) or True)
    mbs.Assemble()
    with pytest.raises(Exception, match="mine") as caught:
        solve(mbs, 0.1, steps=100, stepSize=1e-3)
    assert isinstance(caught.value.__cause__ or caught.value, ValueError)
    np.testing.assert_array_equal(present(), seen[-1])
    assert seen[-1][0] == pytest.approx(0.05)


def test_a_sensor_of_what_keeps_the_length_under_native_solvers_is_warned_of(mbs, add_pendulum, solve):
    lengths = add_pendulum(mbs, enforcement="algebraic")["constraintObjects"][-1]
    kind = exudyn.OutputVariableType.Force
    mbs.AddSensor(SensorObject(objectNumber=lengths, outputVariableType=kind, storeInternal=True))
    mbs.Assemble()
    said = rf"measures .*Force of object {lengths}, which keeps the length.*CreateCableForceSensor"
    with pytest.warns(UserWarning, match=said):
        solve(mbs, 0.02)
