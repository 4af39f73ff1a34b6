"""ExplicitStepper: the same motion as SolveExplicit, in any portions, with forces set in between."""

import tracemalloc

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

from exudyn_inext import (
    CableShape,
    DivergenceError,
    ExplicitSettings,
    ExplicitStepper,
    InputError,
    SceneError,
    SolveExplicit,
    StepSizeError,
)

STEP = 1e-3


def system_state(mbs):
    data = mbs.systemData
    return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt()])


def add_force(mbs, node, user_function):
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    mbs.AddLoad(
        LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=user_function)
    )


def started(mbs, stepSize=STEP, **settings):
    stepper = ExplicitStepper(mbs, ExplicitSettings(stepSize=stepSize, **settings))
    stepper.Start()
    return stepper


@pytest.fixture
def build_ring(new_mbs, add_cable):
    """() -> closed ring of 12 elements, pushed at one node."""

    def build():
        mbs = new_mbs()
        angle = 2 * np.pi * np.arange(12) / 12
        cosine, sine = np.cos(angle), np.sin(angle)
        shape = CableShape(
            0.5 * np.column_stack([cosine, sine]), np.column_stack([-sine, cosine]), closed=True
        )
        cable = add_cable(mbs, shape=shape)
        add_force(mbs, cable["nodes"][0], lambda mbs, t, load: [0.2 * np.sin(30 * t), 0, 0])
        mbs.Assemble()
        return mbs

    return build


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
@pytest.mark.parametrize("portions", [[100], [1] * 100, [7, 30, 63]])
def test_any_portions_of_steps_give_the_bits_of_a_run(twin, solve, integrator, portions):
    run, stepped = twin(), twin()
    assert solve(run.mbs, 100 * STEP, stepSize=STEP, integrator=integrator)["stepSize"] == STEP
    stepper = started(stepped.mbs, integrator=integrator)
    for n in portions:
        stepper.Step(n)
    stepper.WriteToSystem()
    np.testing.assert_array_equal(system_state(stepped.mbs), system_state(run.mbs))
    supports = [one.mbs.systemData.GetAECoordinates() for one in (stepped, run)]
    np.testing.assert_array_equal(*supports)
    assert stepped.mbs.systemData.GetTime() == pytest.approx(0.1, rel=1e-12)


def test_mass_scaling_gives_the_bits_of_a_run(twin, solve):
    run, stepped = twin(), twin()
    solve(run.mbs, 0.1, stepSize=5e-3, massScaling=0.3)
    stepper = started(stepped.mbs, 5e-3, massScaling=0.3)
    stepper.Step(20)
    stepper.WriteToSystem()
    np.testing.assert_array_equal(system_state(stepped.mbs), system_state(run.mbs))


@pytest.mark.parametrize("pure", [True, False], ids=["known ahead", "asked in between"])
def test_loads_in_time_and_closed_cables_give_the_bits_of_a_run(build_ring, solve, pure):
    run, stepped = build_ring(), build_ring()
    solve(run, 60 * STEP, stepSize=STEP, dependsOnTimeOnly=pure or None)
    stepper = started(stepped, dependsOnTimeOnly=pure or None)
    for n in (1, 1, 28, 30):
        stepper.Step(n)
    stepper.WriteToSystem()
    np.testing.assert_array_equal(system_state(stepped), system_state(run))
    q, _, _ = stepper.State()
    np.testing.assert_array_equal(q[0], q[-1])


def test_forces_that_are_set_act_as_a_load_of_the_same_values(twin, new_mbs, add_pendulum, solve):
    force = lambda t: [0.1 * np.cos(20 * t), 0.3 * np.sin(30 * t), 0.0]  # noqa: E731
    loaded = new_mbs()
    cable = add_pendulum(loaded)
    add_force(loaded, cable["nodes"][3], lambda mbs, t, load: force(t))
    loaded.Assemble()
    solve(loaded, 50 * STEP, stepSize=STEP)

    built = twin()
    stepper = ExplicitStepper(built.mbs, stepSize=STEP)
    stepper.SetNodeForce(built.cable["nodes"][3], force(0.0))
    stepper.Start()
    for step in range(50):
        stepper.SetNodeForce(built.cable["nodes"][3], force((step + 1) * STEP))
        stepper.Step()
    stepper.WriteToSystem()
    np.testing.assert_allclose(system_state(built.mbs)[:2], system_state(loaded)[:2], rtol=1e-12, atol=1e-12)


def test_a_force_replaces_the_last_one_and_adds_to_loads(twin):
    def tip(*forces):
        built = twin()
        stepper = started(built.mbs)
        for force in forces:
            stepper.SetNodeForce(built.cable["nodes"][-1], force)
        stepper.Step(50)
        return stepper.State()[0][-1, 0].copy()

    np.testing.assert_array_equal(tip([5.0, 5.0, 0.0], [0.0, 0.2, 0.0]), tip([0.0, 0.2, 0.0]))
    np.testing.assert_array_equal(tip([1.0, 1.0, 0.0], [0.0, 0.0, 0.0]), tip())
    assert tip([0.0, 0.2, 0.0])[1] > tip()[1] + 1e-3


def test_two_cables_are_stepped_together(new_mbs, add_pendulum):
    mbs = new_mbs()
    add_pendulum(mbs)
    add_pendulum(mbs, numberOfElements=3, positionStart=[0, 1, 0], positionEnd=[1, 1, 0])
    mbs.Assemble()
    stepper = started(mbs)
    stepper.Step(20)
    assert [stepper.State(cable)[0].shape for cable in (0, 1)] == [(6, 2, 2), (4, 2, 2)]
    with pytest.raises(InputError, match=r"cable = 2: must be .* at most 1"):
        stepper.State(2)


def test_state_is_the_present_one_and_total_coordinates(twin, coordinates):
    built = twin()
    stepper = started(built.mbs)
    q, v, time = stepper.State()
    assert time == 0.0
    np.testing.assert_allclose(q[-1], [[1.8, 0], [1, 0]], atol=1e-12)
    stepper.Step(100)
    stepper.WriteToSystem()
    np.testing.assert_allclose(q, coordinates(built.mbs, built.cable["nodes"]), atol=1e-14)
    again, _, time = stepper.State()
    assert np.shares_memory(q, again) and np.abs(v).max() > 0.1
    assert time == stepper.time == pytest.approx(0.1)


def test_sensors_read_what_is_written_to_the_system(twin):
    built = twin()
    stepper = started(built.mbs)
    stepper.Step(100)
    before = built.mbs.GetSensorValues(built.tip)
    stepper.WriteToSystem()
    np.testing.assert_array_equal(before, [1.8, 0, 0])
    np.testing.assert_allclose(built.mbs.GetSensorValues(built.tip)[:2], stepper.State()[0][-1, 0])
    tip = built.mbs.GetNodeOutput(
        built.cable["nodes"][-1],
        exudyn.OutputVariableType.Position,
        exudyn.ConfigurationType.Visualization,
    )
    np.testing.assert_allclose(tip[:2], stepper.State()[0][-1, 0])


def test_start_begins_anew(twin):
    stepper = started(twin().mbs, integrator="Zhai")
    stepper.Step(50)
    first = stepper.State()[0].copy()
    stepper.Step(13)
    stepper.Start()
    assert stepper.time == 0.0
    stepper.Step(50)
    np.testing.assert_array_equal(stepper.State()[0], first)


def test_a_run_that_starts_late_has_its_time(twin):
    stepper = ExplicitStepper(twin().mbs, stepSize=STEP, startTime=2.0)
    stepper.Start()
    stepper.Step(5)
    assert stepper.State()[2] == pytest.approx(2.005)


@pytest.mark.parametrize("n", [1, 100])
def test_steps_keep_no_memory_and_ask_for_next_to_none(twin, n):
    """Besides the frames and small numbers of Python itself, whatever the number of steps."""
    built = twin(numberOfElements=50)
    stepper = started(built.mbs, stepSize=2e-5)
    node, force = built.cable["nodes"][-1], [0.0, 0.1, 0.0]

    def steps():
        for _ in range(20):
            stepper.SetNodeForce(node, force)
            stepper.Step(n)
            stepper.State()

    tracemalloc.start()
    try:
        for _ in range(10):  # what the dispatch of kernels remembers settles within a few rounds
            steps()
        tracemalloc.reset_peak()
        before, _ = tracemalloc.get_traced_memory()
        steps()
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert abs(after - before) < 512
    assert peak - before < 4096


def test_a_step_above_the_limit_is_refused(twin, contents):
    mbs = twin().mbs
    before = contents(mbs)
    with pytest.raises(StepSizeError, match=r"stepSize = 0\.004 s is above 0\.00274159 s.*reduce the step"):
        ExplicitStepper(mbs, ExplicitSettings(stepSize=1e-3), stepSize=4e-3)
    assert contents(mbs) == before


def test_the_system_is_left_alone_until_it_is_written_to(twin, contents):
    mbs = twin().mbs
    before = contents(mbs)
    started(mbs).Step(10)
    assert contents(mbs) == before


def test_a_divergence_keeps_the_last_good_state_and_asks_for_a_new_start(twin, without_smaller_steps):
    with pytest.warns(UserWarning, match="stepSize"):
        stepper = started(twin().mbs, 5e-3, allowUnstableStep=True)
    with pytest.raises(DivergenceError, match=r"cable 'object0'.*stepper holds the state at t = "):
        for _ in range(1000):
            stepper.Step()
    q, v, time = stepper.State()
    assert np.isfinite(q).all() and np.isfinite(v).all() and 0 < time < 5
    np.testing.assert_allclose(np.linalg.norm(q[:, 1], axis=1), 1.0, atol=0.05)
    with pytest.raises(DivergenceError, match="Start"):
        stepper.Step()
    stepper.Start()
    stepper.Step()
    assert stepper.time == 5e-3


def test_functions_that_nobody_would_call_are_refused(twin):
    model = twin()
    for name in ("PreStep", "PostStep"):
        register = getattr(model.mbs, f"Set{name}UserFunction")
        register(lambda mbs, t: True)
        with pytest.raises(SceneError, match="pre- or post-step user function, which is not called between"):
            ExplicitStepper(model.mbs, stepSize=1e-3)
        register(0)
    for name in ("PostNewton", "PreNewtonResidual"):
        register = getattr(model.mbs, f"Set{name}UserFunction")
        register(lambda mbs, t, *_: [0, 0])
        for run in (ExplicitStepper, SolveExplicit):
            with pytest.raises(SceneError, match=rf"remove it, mbs\.Set{name}UserFunction\(0\)"):
                run(model.mbs)
        register(0)
    ExplicitStepper(model.mbs, stepSize=1e-3)


def test_a_step_before_the_start_is_refused(twin):
    with pytest.raises(InputError, match=r"not been started: call Start\(\)"):
        ExplicitStepper(twin().mbs).Step()


@pytest.mark.parametrize("n", [0, -1, 1.5, 2.0, "3", None, np.nan])
def test_a_number_of_steps_that_is_none_is_refused(twin, n):
    with pytest.raises(InputError, match="must be an integer of at least 1"):
        started(twin().mbs).Step(n)


@pytest.mark.parametrize(
    ("place", "force", "message"),
    [
        (-1, [0.0, 0.0, 0.5], "z component 0.5 N.*dimension=3"),
        (-1, [0.0, np.nan, 0.0], "3 finite numbers"),
        (-1, [0.0, 1.0], "3 finite numbers"),
        (
            None,
            [0.0, 1.0, 0.0],
            r"node = 99 is on no inextensible cable: their nodes lie between 0 and 5",
        ),
    ],
)
def test_a_force_that_cannot_act_is_refused(twin, place, force, message):
    built = twin()
    stepper = started(built.mbs)
    node = 99 if place is None else built.cable["nodes"][place]
    with pytest.raises(InputError, match=message):
        stepper.SetNodeForce(node, force)


def test_a_system_without_cables_is_refused(mbs):
    mbs.CreateMassPoint(referencePosition=[0, 0, 0], mass=1.0)
    mbs.Assemble()
    with pytest.raises(SceneError):
        ExplicitStepper(mbs)


def test_a_system_that_is_not_assembled_is_refused(mbs, add_pendulum):
    add_pendulum(mbs)
    with pytest.raises(SceneError, match="Assemble"):
        ExplicitStepper(mbs)


@pytest.mark.parametrize("time", [np.nan, np.inf])
def test_a_start_time_that_is_no_number_is_refused(twin, time):
    with pytest.raises(InputError, match="startTime"):
        ExplicitStepper(twin().mbs, startTime=time)


def test_ten_thousand_elements_with_mass_scaling_start_in_little_memory(twin):
    """Neither round-off in pivots nor dense arrays of the size of the cable are in the way."""
    built = twin(numberOfElements=10_000)
    tracemalloc.start()
    try:
        stepper = started(built.mbs, 2e-3, massScaling=0.3)
        stepper.Step(2)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1e4 * 10_000
    assert stepper.State()[0][-1, 0, 1] == pytest.approx(-0.5 * 9.81 * stepper.time**2, rel=1e-2)
