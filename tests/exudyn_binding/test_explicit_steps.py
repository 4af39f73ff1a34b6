"""ExplicitSteps: Exudyn's own environment and dialog drive an ExplicitSolver, beside their native solvers."""

import importlib
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest
from exudyn.interactive import InteractiveDialog
from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

from examples import slung_load as example
from exudyn_inext import (
    DivergenceError,
    ExplicitSettings,
    ExplicitSteps,
    InputError,
    SceneError,
    SolveExplicit,
)
from reference_models.conventional.native_cables import NativeCables
from reference_models.model import quiet_settings, silence
from tests.gym_stub import import_environments

SETTINGS = ExplicitSettings(stepSize=2e-3, massScaling=0.3)
PERIOD = 0.02
POSITION, VELOCITY = exudyn.OutputVariableType.Position, exudyn.OutputVariableType.Velocity


def hover(mbs, load, push=(0, 0, 0)):
    """Thrust that carries the weight, and a push [N]."""
    mbs.SetLoadParameter(load, "loadVector", (push - example.WEIGHT).tolist())


@pytest.fixture
def said(monkeypatch):
    """What an environment warns of."""
    return import_environments(monkeypatch)


@pytest.fixture
def environments(said):
    """Classes of environments: a slung load, explicit, and its native twin."""
    module = importlib.import_module("exudyn.artificialIntelligence")
    native, spaces = module.OpenAIGymInterfaceEnv, module.spaces

    class SlungLoad:
        addCable, steps = staticmethod(example.inext.CreateInextensibleCable), 1

        def CreateMBS(self, SC, mbs, simulationSettings, **scene):
            self.stepUpdateTime = PERIOD
            self.bodies, _, self.force = example.build(mbs, addCable=self.addCable)
            hover(mbs, self.force)
            mbs.Assemble()
            simulationSettings.timeIntegration.numberOfSteps = self.steps
            simulationSettings.timeIntegration.endTime = 0
            simulationSettings.timeIntegration.verboseMode = 0
            simulationSettings.timeIntegration.newton.relativeTolerance = 1e-6
            simulationSettings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
            simulationSettings.solution.file.write = False
            return 12

        def SetupSpaces(self):
            self.action_space = spaces.Box(low=np.full(3, -1e7), high=np.full(3, 1e7), dtype=np.float64)
            self.observation_space = spaces.Box(low=np.full(12, -100.0), high=np.full(12, 100.0))

        def MapAction2MBS(self, action):
            hover(self.mbs, self.force, action)

        def Output2StateAndDone(self):
            outputs = [self.mbs.GetNodeOutput(n, kind) for n in self.bodies for kind in (POSITION, VELOCITY)]
            self.state = np.concatenate(outputs)
            return bool(np.abs(self.state).max() > 50)

    class Explicit(SlungLoad, ExplicitSteps, native):
        explicitSettings = SETTINGS

    class Native(SlungLoad, ExplicitSteps, native):
        addCable, steps = staticmethod(NativeCables(1e5)), 10  # longer ones let it diverge

        def PreInitializeSolver(self):
            self._initial_state = self.mbs.systemData.GetSystemState(exudyn.ConfigurationType.Initial)
            native.PreInitializeSolver(self)

    return SimpleNamespace(Explicit=Explicit, Native=Native, SlungLoad=SlungLoad, base=native)


def push(k):
    """Action of step k: it jumps."""
    return np.array([6.0 * np.sin(0.9 * k), 3.0 * (k % 7 > 3), 4.0 * np.cos(0.5 * k)])


def episode(environment, steps=60, action=push, **options):
    """States (steps + 1, n) of an episode."""
    with silence():
        states = [environment.reset(**options)[0]]
        states += [environment.step(action(k))[0] for k in range(steps)]
    return np.array(states)


def test_an_environment_moves_as_with_native_cables_and_its_native_solver(environments):
    of_positions = [0, 1, 2, 6, 7, 8]  # native cables also vibrate along their axes
    ours, native = (episode(kind())[:, of_positions] for kind in (environments.Explicit, environments.Native))
    assert np.abs(ours - native).max() < 0.01 * np.abs(native - native[0]).max()
    assert np.abs(native[-1, :3]).max() > 0.1


def test_an_environment_whose_items_exudyn_evaluates_moves_the_same(environments, request):
    compiled = episode(environments.Explicit(), steps=10)
    request.getfixturevalue("by_exudyn")
    environment = environments.Explicit()
    np.testing.assert_allclose(episode(environment, steps=10), compiled, atol=1e-6)
    assert "this test" in environment.dynamicSolver.path
    np.testing.assert_allclose(episode(environment, steps=5), compiled[:6], atol=1e-6)


def test_forces_that_follow_the_state_act_as_with_native_cables_and_their_solver(environments):
    """A spring to the side, by a user function of the load, on the drone."""

    def side(mbs, t, loadVector):
        x, _, _ = mbs.GetNodeOutput(mbs.variables["drone"], POSITION)
        return [0.0, 30.0 * (0.1 - x), 0.0]

    def springy(kind):
        class Springy(kind):
            def CreateMBS(self, SC, mbs, simulationSettings):
                size = super().CreateMBS(SC, mbs, simulationSettings)
                mbs.variables["drone"] = self.bodies[0]
                marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=self.bodies[0]))
                mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVectorUserFunction=side))
                mbs.Assemble()
                return size

        return Springy()

    of_positions = [0, 1, 2, 6, 7, 8]
    ours, native = (
        episode(springy(kind), steps=20)[:, of_positions]
        for kind in (environments.Explicit, environments.Native)
    )
    assert np.abs(ours - native).max() < 0.01 * np.abs(native - native[0]).max()


def test_an_environment_that_is_reset_starts_from_the_initial_values(environments):
    environment = environments.Explicit()
    first = episode(environment)
    np.testing.assert_array_equal(episode(environment, steps=30, seed=1), first[:31])
    np.testing.assert_array_equal(first[0, :6], [0, 0, 0, 0, 0, 0])
    environment.close()
    np.testing.assert_array_equal(episode(environment), first)


def test_steps_of_half_the_size_go_on_from_the_present_state(environments):
    whole = episode(environments.Explicit(), action=lambda k: push(k // 10))
    halved = environments.Explicit()
    states = episode(halved, steps=30, action=lambda k: push(k // 10))
    halved.stepUpdateTime = PERIOD / 2
    later = [halved.step(push((60 + k) // 20))[0] for k in range(60)]
    np.testing.assert_array_equal(states, whole[:31])
    np.testing.assert_allclose(later[1::2], whole[31:], atol=1e-4)


def test_exudyn_s_own_test_of_a_model_runs_and_writes_its_file(environments, capsys, tmp_path):
    environment = environments.Explicit()
    environment.action_space.low[:], environment.action_space.high[:] = -1.0, 1.0
    file = str(tmp_path / "solution.txt")
    environment.TestModel(numberOfSteps=20, useRenderer=False, sleepTime=0, solutionFileName=file)
    assert not environment.flagNan and environment.mbs.systemData.GetTime() == pytest.approx(20 * PERIOD)
    assert "time spent" in capsys.readouterr().out
    rows = np.loadtxt(file, delimiter=",", comments="#")
    environment.close()  # once more, as scripts do that first try a model
    size = environment.mbs.systemData.ODE2Size()
    np.testing.assert_allclose(rows[-1, 0], 20 * PERIOD)
    np.testing.assert_allclose(
        rows[-1, 1 : size + 1], environment.mbs.systemData.GetODE2Coordinates(), atol=1e-6
    )


def test_after_the_end_of_an_episode_exudyn_warns_and_goes_on(environments, said):
    environment = environments.Explicit()
    away = [environment.step(np.array([0, 0, 3e3]))[2] for _ in range(60) if environment.state is not None]
    assert away == []  # before a reset there is no state
    with pytest.raises(AssertionError, match="Call reset before"):
        environment.step(np.zeros(3))
    episode(environment, steps=60, action=lambda k: np.array([0.0, 0.0, 3e3]))
    assert environment.steps_beyond_done > 0
    assert any("already returned done" in text for text in said) or not said


def test_an_episode_that_diverges_is_followed_by_one_that_does_not(environments):
    environment = environments.Explicit()
    first = episode(environment, steps=20)
    with silence(), pytest.raises(DivergenceError, match="diverged before"):
        for _ in range(20):
            environment.step(np.array([9e6, 9e6, -9e6]))
    with pytest.raises(DivergenceError, match="diverged before"):
        environment.step(np.zeros(3))
    np.testing.assert_array_equal(episode(environment, steps=20), first)


def test_environments_side_by_side_do_not_see_each_other(environments):
    alone = episode(environments.Explicit())
    one, other = environments.Explicit(), environments.Explicit()
    with silence():
        one.reset(), other.reset()
        for k in range(60):
            state = one.step(push(k))[0]
            other.step(-push(k))
    np.testing.assert_array_equal(state, alone[-1])


def test_values_of_a_user_s_own_map_are_taken(environments):
    """Drone and load at the same velocity, drawn at random."""

    class Drifting(environments.Explicit):
        drifts = False

        def State2InitialValues(self):
            values = super().State2InitialValues()
            if self.drifts:
                values[1] = np.zeros(len(values[1]))
                for node in (*self.bodies, *range(example.ELEMENTS + 1)):
                    values[1][self.mbs.systemData.GetNodeLTGODE2(node)[:3]] = [self.speed, 0, 0]
            return values

    environment = Drifting()
    environment.speed, environment.drifts = 0.7, True
    state = episode(environment, steps=0)[0]
    np.testing.assert_allclose(state, [0, 0, 0, 0.7, 0, 0, 0, 0, -example.LENGTH, 0.7, 0, 0], atol=1e-6)
    environment.drifts = False
    with silence():
        state = [environment.step(np.zeros(3))[0] for _ in range(50)][-1]
    np.testing.assert_allclose(state[[0, 3, 6, 9]], [0.7, 0.7, 0.7, 0.7], atol=1e-4)


def test_values_that_are_not_all_there_are_are_refused(environments):
    class Short(environments.Explicit):
        def State2InitialValues(self):
            return [values[:-6] for values in super().State2InitialValues()]

    environment = Short()
    size = environment.mbs.systemData.ODE2Size()
    said = rf"returned {size - 6} coordinates and {size - 6} velocities, of {size} each"
    with silence(), pytest.raises(InputError, match=said):
        environment.reset()


def test_values_that_violate_constraints_are_refused(environments):
    class TornApart(environments.Explicit):
        def State2InitialValues(self):
            values = super().State2InitialValues()
            values[0] = np.array(values[0])
            values[0][self.mbs.systemData.GetNodeLTGODE2(self.bodies[0])] += 0.1
            return values

    environment = TornApart()
    with silence():
        environment.reset()
        with pytest.raises(
            SceneError, match=r"initial coordinates violate .*JointSpherical.* by -?0\.[12].* startTolerance"
        ):
            environment.step(np.zeros(3))


# ------------------------------------------------------------------ the dialog, whose window nobody opens


def drive_dialog(kind, mbs, settings, periods, before=lambda mbs, dialog: None, period=PERIOD):
    """The methods that a dialog calls, with the attributes that its window would have given it."""
    dialog = kind.__new__(kind)
    vars(dialog).update(
        mbs=mbs, simulationSettings=settings, simulationFunction=before, plots=[], period=period
    )
    dialog.doTimeIntegration, time = True, settings.timeIntegration
    dialog.stepSize = time.endTime / time.numberOfSteps
    dialog.InitializeSolver()
    for _ in range(periods):
        end = dialog.RunSimulationPeriod()
    dialog.FinalizeSolver()
    return end


class ExplicitDialog(ExplicitSteps, InteractiveDialog):
    explicitSettings = SETTINGS


def slung_load(addCable=example.inext.CreateInextensibleCable):
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    bodies, _, force = example.build(mbs, addCable=addCable)
    hover(mbs, force)
    mbs.Assemble()
    return SimpleNamespace(container=container, mbs=mbs, bodies=bodies, force=force)


def positions(scene):
    return np.concatenate([scene.mbs.GetNodeOutput(node, POSITION) for node in scene.bodies])


def test_a_dialog_moves_as_with_native_cables_and_its_native_solver():
    moved = {}
    for kind, addCable in (
        (ExplicitDialog, example.inext.CreateInextensibleCable),
        (InteractiveDialog, NativeCables(1e5)),
    ):
        scene = slung_load(addCable)

        def before(mbs, dialog, scene=scene):
            t = dialog.simulationSettings.timeIntegration.startTime
            force = push(int(t / 0.1)) - example.WEIGHT
            mbs.SetLoadParameter(scene.force, "loadVector", force.tolist())

        settings = quiet_settings(1.0, 200)
        settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        with silence():
            end = drive_dialog(kind, scene.mbs, settings, 50, before)
        assert end == pytest.approx(1.0)
        moved[kind] = positions(scene)
    ours, native = moved.values()
    assert np.abs(ours - native).max() < 0.01 * np.abs(native[:3]).max()


def test_a_dialog_gives_the_bits_of_a_run():
    ended = []
    for drive in (False, True):
        scene = slung_load()
        scene.mbs.SetLoadParameter(scene.force, "loadVector", [1.0, 0.0, 60.0])
        settings = quiet_settings(1.0, 50)
        with silence():
            if drive:
                drive_dialog(ExplicitDialog, scene.mbs, settings, 50)
            else:
                SolveExplicit(scene.mbs, settings, SETTINGS)
        ended.append(positions(scene))
    np.testing.assert_allclose(*ended, atol=1e-12)
