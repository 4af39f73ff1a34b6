"""ExplicitSolver: driven call by call, it gives the states of a run and follows changes in between."""

import gc
import weakref

import exudyn
import numpy as np
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    CartesianSpringDamper,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodePosition,
    ObjectANCFCable2D,
    RevoluteJoint2D,
    SensorNode,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import (
    CableDrag,
    DivergenceError,
    ExplicitSettings,
    ExplicitSolver,
    InextensibleCable,
    ReplaceNativeCables,
    SceneError,
    SetCableDrag,
    SolveExplicit,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import SECTION, add_pendulum
from tests.random_scenes import RandomScene

PERIOD, STEP = 0.02, 1e-3
INITIAL = exudyn.ConfigurationType.Initial


@pytest.fixture(autouse=True)
def nobody_else_listens(quick_collections):
    """Solvers of earlier tests that were not ended have let go of Exudyn's methods."""
    gc.collect()


class Driven:
    """A pendulum whose tip is pulled, and a solver object that is driven as Exudyn's environment does."""

    def __init__(self, stepSize=STEP, steps=1, explicit=None, **options):
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.add_items(**options)
        self.mbs.Assemble()
        self.solver = ExplicitSolver(ExplicitSettings(stepSize=stepSize, **(explicit or {})))
        self.settings = quiet_settings(0.0, steps)

    def add_items(self, damping=0.0, **load):
        cable = add_pendulum(self.mbs, beamTemplate=InextensibleCable(**SECTION, bendingDamping=damping))
        self.nodes, self.supports = cable["nodes"], cable["constraintObjects"]
        self.tip = self.mbs.AddMarker(MarkerNodePosition(nodeNumber=self.nodes[-1]))
        self.load = self.mbs.AddLoad(LoadForceVector(markerNumber=self.tip, loadVector=[0, 0, 0], **load))
        kind = exudyn.OutputVariableType.Position
        sensor = SensorNode(nodeNumber=self.nodes[-1], storeInternal=True, outputVariableType=kind)
        self.sensor = self.mbs.AddSensor(sensor)

    @property
    def state(self):
        data = self.mbs.systemData
        return np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t()])

    def begin(self):
        with silence():
            self.solver.InitializeSolver(self.mbs, self.settings)
        return self

    def step(self, force=None, period=PERIOD):
        time, data = self.settings.timeIntegration, self.mbs.systemData
        if force is not None:
            self.mbs.SetLoadParameter(self.load, "loadVector", force)
        time.startTime = time.endTime
        time.endTime = time.startTime + period
        self.solver.InitializeSolverInitialConditions(self.mbs, self.settings)
        with silence():
            self.solver.SolveSteps(self.mbs, self.settings)
        data.SetSystemState(data.GetSystemState(), INITIAL)
        return self.state

    def end(self):
        self.solver.FinalizeSolver(self.mbs, self.settings)


def solved(end_time, settings=None, explicit=None, before=None, **options):
    """State after a run of SolveExplicit.   before: (scene, t), called before each step of Exudyn's loop."""
    scene, explicit = Driven(**options), ExplicitSettings(**({"stepSize": STEP} | (explicit or {})))
    if before is not None:
        scene.mbs.SetPreStepUserFunction(lambda mbs, t: before(scene, t) or True)
    with silence():
        SolveExplicit(scene.mbs, settings or quiet_settings(end_time, 1), explicit)
    return scene.state


@pytest.mark.parametrize("begins_anew", [True, False])
def test_a_refused_change_is_said_once(begins_anew):
    """It was raised again by InitializeSolver, so that nothing could begin anew, and by FinalizeSolver."""
    driven = Driven(steps=4).begin()
    driven.step()
    load = LoadForceVector(markerNumber=driven.tip, loadVector=[0, 1.0, 0])
    driven.mbs.SetPreStepUserFunction(lambda mbs, t: mbs.AddLoad(load) is not None)
    with pytest.raises(SceneError, match="AddLoad was called"):
        driven.step()
    driven.mbs.SetPreStepUserFunction(0)
    if begins_anew:
        start = driven.begin().state
        assert not np.array_equal(driven.step(), start)
    driven.end()


@pytest.mark.parametrize("explicit", [{"integrator": name} for name in ("RATTLE", "Zhai", "RK4")])
@pytest.mark.parametrize("steps", [1, 4])
def test_portions_give_the_states_of_a_run(steps, explicit):
    driven = Driven(steps=steps, explicit=explicit).begin()
    states = [driven.step() for _ in range(10)]
    np.testing.assert_allclose(states[-1], solved(10 * PERIOD, explicit=explicit), atol=1e-12)
    assert driven.mbs.systemData.GetTime() == pytest.approx(0.2)
    driven.end()
    rows = driven.mbs.GetSensorStoredData(driven.sensor)
    tip = driven.mbs.GetNodeOutput(driven.nodes[-1], exudyn.OutputVariableType.Position)
    np.testing.assert_allclose(rows[-1], [0.2, *tip], atol=1e-12)


def test_damped_cables_begin_as_in_a_run():
    """The solver starts twice, and took the accelerations of the first start for those of the motion."""
    found = Driven(damping=0.1).begin().step()
    np.testing.assert_allclose(found, solved(PERIOD, damping=0.1), atol=1e-12)


def state_dependent(mbs, t, load):
    """A spring to the place where the tip begins, which only Exudyn can evaluate."""
    x, y, _ = mbs.GetNodeOutput(5, exudyn.OutputVariableType.Position)
    return [2.0 * (1.8 - x), -2.0 * y, 0.0]


def test_user_functions_of_the_state_are_evaluated():
    driven = Driven(loadVectorUserFunction=state_dependent).begin()
    states = [driven.step() for _ in range(5)]
    assert "may depend on the state" in driven.solver.path
    settings = quiet_settings(5 * PERIOD, 5)
    np.testing.assert_allclose(
        states[-1], solved(0, settings, loadVectorUserFunction=state_dependent), atol=1e-9
    )
    assert np.abs(states[-1] - solved(5 * PERIOD)).max() > 0.05


def test_forces_that_jump_in_between_do_so_with_the_order_of_the_scheme():
    def moved(stepSize):
        driven = Driven(stepSize).begin()
        return [driven.step([0.4 * (k % 2), 0.3, 0.0])[0] for k in range(10)][-1]

    def native(mbs, t, load):
        return [0.4 * (int(t / PERIOD - 1e-9) % 2), 0.3, 0.0]

    fine = Driven(2e-5, loadVectorUserFunction=native).begin()
    for _ in range(10):
        expected = fine.step()[0]
    errors = [np.abs(moved(step) - expected).max() for step in (5e-4, 2.5e-4, 1.25e-4)]
    assert errors[0] > 3 * errors[1] > 9 * errors[2], errors


def test_pre_step_functions_act_as_in_a_run():
    ended = []
    for drive in (True, False):
        scene = Driven(steps=20)

        def pull(mbs, t, scene=scene):
            mbs.SetLoadParameter(scene.load, "loadVector", [0.0, 3.0 * t, 0.0])
            return True

        scene.mbs.SetPreStepUserFunction(pull)
        if drive:
            scene.begin()
            for _ in range(5):
                scene.step()
            scene.end()
        else:
            with silence():
                SolveExplicit(scene.mbs, quiet_settings(0.1, 100), ExplicitSettings(stepSize=STEP))
        ended.append(scene.state)
    np.testing.assert_allclose(*ended, atol=2e-4)


def test_initialised_again_it_begins_from_the_initial_configuration():
    driven = Driven().begin()
    start = driven.mbs.systemData.GetSystemState(INITIAL)
    first = [driven.step([0.0, 0.1 * k, 0.0]) for k in range(5)]
    driven.mbs.systemData.SetSystemState(start, INITIAL)
    driven.settings.timeIntegration.endTime = 0.0
    driven.begin()
    np.testing.assert_array_equal([driven.step([0.0, 0.1 * k, 0.0]) for k in range(5)], first)


@pytest.mark.parametrize("seed", [2, 8])
def test_cables_that_stretch_among_joints_begin_again_from_the_state_that_is_given(seed):
    """What was learned from the state before the start moved them by millimetres there."""
    found = []
    for starts in (1, 2):
        scene = RandomScene(seed, stretches=True)
        scene.mbs.Assemble()
        settings, solver = quiet_settings(0.02, 20), ExplicitSolver(ExplicitSettings(stepSize=2.5e-4))
        with silence():
            for _ in range(starts):
                solver.InitializeSolver(scene.mbs, settings)
            solver.SolveSteps(scene.mbs, settings)
        found.append(scene.mbs.systemData.GetODE2Coordinates())
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-12)


def sprung_and_weighed(mbs):
    """A replaced cable with a body at its end, on a spring that Exudyn evaluates; numbers of all weights."""
    line = {
        "positionStart": [0, 0, 0],
        "positionEnd": [1, 0, 0],
        "numberOfElements": 5,
        "gravity": [0, -9.81, 0],
    }
    section = ObjectANCFCable2D(massPerLength=0.2, bendingStiffness=0.03, axialStiffness=2e3)
    pin = {"groundConstraintsStart": [True, True, False, False]}
    tip = GenerateBeamElementsAlongLine(mbs, beamTemplate=section, **line, **pin)["nodes"][-1]
    ReplaceNativeCables(mbs)
    inertia = InertiaCuboid(500, [0.2, 0.1, 0.05])
    body = mbs.CreateRigidBody(
        referencePosition=[1.1, 0, 0], inertia=inertia, gravity=[0, -9.81, 0], create2D=True
    )
    end = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[-0.1, 0, 0]))
    node = mbs.AddMarker(MarkerNodePosition(nodeNumber=tip))
    mbs.AddObject(RevoluteJoint2D(markerNumbers=[end, node]))
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[1, 0, 0]))
    pull = {"springForceUserFunction": lambda mbs, t, number, u, v, k, d, offset: [k[0] * x for x in u]}
    mbs.AddObject(CartesianSpringDamper(markerNumbers=[ground, node], stiffness=[5, 5, 5], **pull))
    mbs.Assemble()
    return range(mbs.systemData.NumberOfLoads())


def test_weights_that_are_set_before_the_first_step_are_there_from_its_beginning_each_time(mbs):
    weights, settings, solver = sprung_and_weighed(mbs), quiet_settings(0.02, 1), ExplicitSolver()
    begin, found = mbs.systemData.GetSystemState(INITIAL), []
    for factor in (1.4, 2.0, 1.4):
        mbs.systemData.SetSystemState(begin, INITIAL)
        with silence():
            solver.InitializeSolver(mbs, settings)
            for number in weights:
                mbs.SetLoadParameter(number, "loadVector", [0, -9.81 * factor, 0])
            solver.SolveSteps(mbs, settings)
        found.append(mbs.systemData.GetODE2Coordinates())
    np.testing.assert_allclose(found[2], found[0], rtol=0, atol=1e-12)
    body_is_at, fall = -2, 0.5 * 9.81 * 0.02**2
    assert found[0][body_is_at] == pytest.approx(-1.4 * fall, rel=0.01)
    assert found[1][body_is_at] == pytest.approx(-2.0 * fall, rel=0.01)


def test_a_period_that_changes_is_cut_into_other_steps():
    driven = Driven().begin()
    for period in (0.02, 0.0305, 0.0305, 0.01, 0.009):
        state = driven.step(period=period)
    np.testing.assert_allclose(state[0], solved(0.1)[0], atol=2e-4)
    assert driven.mbs.systemData.GetTime() == pytest.approx(0.1)


def test_steps_may_adapt():
    driven = Driven(explicit={"adaptiveStep": True}).begin()
    for _ in range(10):
        state = driven.step()
    np.testing.assert_allclose(state[0], solved(0.2)[0], atol=1e-3)


def test_a_support_that_is_moved_gets_there_within_the_next_step_of_the_loop():
    def lift(scene, t):
        scene.mbs.SetObjectParameter(int(scene.supports[1]), "offset", 0.02 * round(t / PERIOD))

    driven = Driven().begin()
    for k in range(1, 11):
        lift(driven, k * PERIOD)
        state = driven.step()
    settings = quiet_settings(0.2, 10)
    settings.solution.sensors.writePeriod = PERIOD
    np.testing.assert_allclose(state, solved(0, settings, before=lift), atol=1e-6)
    assert state[0, 1] == pytest.approx(0.2, abs=1e-9)
    driven.step()
    np.testing.assert_allclose(driven.step()[:, 1], [0.2, 0], atol=1e-9)


def test_a_run_of_its_own_may_come_in_between():
    def pull(scene, t):
        scene.mbs.SetLoadParameter(scene.load, "loadVector", [0.0, 3.0 * t, 0.0])

    expected = solved(0.1, before=pull)
    driven = Driven().begin()
    driven.step()
    other = Driven()
    driven.mbs.systemData.SetSystemState(other.mbs.systemData.GetSystemState(INITIAL), INITIAL)
    driven.mbs.SetPreStepUserFunction(lambda mbs, t: pull(driven, t) or True)
    with silence():
        SolveExplicit(driven.mbs, quiet_settings(0.1, 1), ExplicitSettings(stepSize=STEP))
    driven.mbs.SetPreStepUserFunction(0)  # which keeps the solver alive
    np.testing.assert_allclose(driven.state, expected, atol=1e-12)


def test_coordinates_that_are_set_in_between_are_taken_over():
    driven, data = Driven().begin(), None
    driven.step()
    data = driven.mbs.systemData
    expected = driven.state
    for _ in range(5):
        driven.step()
    data.SetODE2Coordinates(expected[0], INITIAL)
    data.SetODE2Coordinates_t(expected[1], INITIAL)
    np.testing.assert_allclose(driven.step(), solved(2 * PERIOD), atol=1e-6)


def test_a_run_that_somebody_stops_goes_on_from_where_it_was_stopped():
    driven = Driven(steps=20).begin()
    driven.mbs.SetPreStepUserFunction(lambda mbs, t: t < 10.5 * STEP)
    driven.step()
    stopped = driven.mbs.systemData.GetTime()
    assert stopped == pytest.approx(11 * STEP)
    driven.mbs.SetPreStepUserFunction(0)
    driven.settings.timeIntegration.endTime = stopped
    driven.settings.timeIntegration.numberOfSteps = 9
    driven.begin()
    np.testing.assert_allclose(driven.step(period=PERIOD - stopped), solved(PERIOD), atol=1e-9)


def test_other_items_are_read_when_it_is_initialised_again():
    driven = Driven().begin()
    driven.step()
    driven.mbs.AddLoad(LoadForceVector(markerNumber=driven.tip, loadVector=[0, 1.0, 0]))
    driven.mbs.Assemble()
    with pytest.raises(
        SceneError, match=r"other items were found than at the start, .*initialise the solver"
    ):
        driven.step()
    driven.settings.timeIntegration.endTime = 0.0
    other = Driven()
    driven.mbs.systemData.SetSystemState(other.mbs.systemData.GetSystemState(INITIAL), INITIAL)
    np.testing.assert_array_equal(driven.begin().step(), other.begin().step([0, 1.0, 0]))


@pytest.mark.parametrize("change", ["load", "drag"])
def test_what_it_could_not_see_is_said_at_the_next_start_and_at_the_end(change):
    driven = Driven()
    set_load = driven.mbs.SetLoadParameter  # bound before the solver listens
    driven.begin().step()
    if change == "load":
        set_load(driven.load, "loadVector", [0, 1.0, 0])
    else:
        SetCableDrag(driven.mbs, 0, CableDrag(1.2, 0.01, diameter=0.02, fluidDensity=1000.0))
    for said in (driven.begin, driven.end):
        driven.step()
        with pytest.raises(SceneError, match="without its notice"):
            said()


def test_an_end_releases_the_methods_of_exudyn_and_the_system():
    methods = dict(vars(exudyn.MainSystem))
    driven = Driven().begin()
    driven.step()
    assert vars(exudyn.MainSystem)["SetLoadParameter"] is not methods["SetLoadParameter"]
    driven.end()
    assert vars(exudyn.MainSystem)["SetLoadParameter"] is methods["SetLoadParameter"]
    forgotten = Driven().begin()
    forgotten.step()
    alive = weakref.ref(forgotten.solver)
    del forgotten
    gc.collect()
    assert alive() is None
    assert vars(exudyn.MainSystem)["SetLoadParameter"] is methods["SetLoadParameter"]


def test_after_a_divergence_it_can_be_initialised_again():
    driven = Driven().begin()
    start = driven.mbs.systemData.GetSystemState(INITIAL)
    first = driven.step()
    for _ in range(2):
        with pytest.raises(DivergenceError, match="diverged before"):
            driven.step([1e20, 1e20, 0])
    driven.mbs.SetLoadParameter(driven.load, "loadVector", [0, 0, 0])
    driven.mbs.systemData.SetSystemState(start, INITIAL)
    driven.settings.timeIntegration.endTime = 0.0
    np.testing.assert_array_equal(driven.begin().step(), first)


def test_after_an_error_of_a_user_function_the_scene_is_read_again():
    def pull(mbs, t, load):
        if fails and t > PERIOD:
            raise ArithmeticError("no force")
        return load

    fails, driven = True, Driven(loadVectorUserFunction=pull)
    set_load = driven.mbs.SetLoadParameter  # bound before the solver listens
    driven.begin()
    with pytest.raises(ArithmeticError, match="no force"):
        driven.step(period=2 * PERIOD)
    fails, driven.settings.timeIntegration.endTime = False, 0.0
    set_load(driven.load, "loadVector", [0, 1.0, 0])
    other = Driven(loadVectorUserFunction=pull)
    other.mbs.SetLoadParameter(other.load, "loadVector", [0, 1.0, 0])
    np.testing.assert_array_equal(driven.begin().step(), other.begin().step())


def test_without_cables_native_bodies_are_moved():
    driven = Driven.__new__(Driven)
    driven.add_items = lambda: driven.mbs.CreateMassPoint(mass=2.0, gravity=[0, 0, -9.81])
    Driven.__init__(driven)
    driven.begin()
    for _ in range(10):
        state = driven.step()
    np.testing.assert_allclose(state[0], [0, 0, -0.5 * 9.81 * 0.04], rtol=1e-9, atol=1e-12)
