"""Steps that follow the stability limit of cables among bodies, springs and joints."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    Force,
    LoadForceVector,
    MarkerNodePosition,
    NodePointGround,
    SphericalJoint,
)

from exudyn_inext import (
    DivergenceError,
    ExplicitSettings,
    ExplicitStepper,
    SolveEnsemble,
    SolveExplicit,
    StepSizeError,
)
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import COARSE, add_pendulum, either_cable, load_node, trajectory
from tests.exudyn_binding.test_restart import restarting
from tests.exudyn_binding.test_support_forces import hold

SECTION = {"massPerLength": 0.05, "bendingStiffness": 0.01}
MASS, G = 0.5, 9.81


def add_mass_on_cable(mbs, native=False, gravity=(0, -G, 0)):
    """Body, node and marker of a mass at the end of a cable of 1 m along x, pinned in the origin."""
    line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "gravity": list(gravity)}
    nodes, _ = either_cable(mbs, native, 2, SECTION, 1e5, numberOfElements=10, **line)
    for axis in (0, 1):
        hold(mbs, nodes[0], axis)
    point = mbs.CreateMassPoint(
        mass=MASS, referencePosition=[1, 0, 0], gravity=list(gravity), returnDict=True
    )
    pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (nodes[-1], point["nodeNumber"])]
    mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
    return point["bodyNumber"], point["nodeNumber"], pair[1]


def pulled(mbs, native=False):
    """By a force that grows from nothing to 600 N."""
    _, node, marker = add_mass_on_cable(mbs, native)

    def pull(mbs, t, load):
        return [600 * t**2, 0, 0]

    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[1, 0, 0], loadVectorUserFunction=pull))
    return node


def driven(mbs, native=False):
    """In circles, by a force along its velocity."""
    _, node, marker = add_mass_on_cable(mbs, native, gravity=(0, 0, 0))

    def drive(mbs, t, load):
        x, y, _ = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position)
        return [-8 * y, 8 * x, 0]

    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[1, 0, 0], loadVectorUserFunction=drive))
    return node


def caught(mbs, native=False):
    """As it falls, by a stiff spring that pulls only."""
    body, node, _ = add_mass_on_cable(mbs, native)

    def spring(mbs, t, number, u, v, k, d, force):
        return 2e6 * max(u, 0.0)

    mbs.CreateSpringDamper(
        itemNumbers=[mbs.CreateGround(), body],
        localPosition0=[1, 1, 0],
        referenceLength=1.3,
        stiffness=1.0,
        springForceUserFunction=spring,
    )
    return node


SCENES = [(pulled, 1.0), (driven, 0.8)]


@pytest.fixture
def run(new_mbs, add_sensor, solve):
    """(scene, end, period of outputs, settings) -> report, places of the mass, and the system."""

    def with_settings(scene, end, period=0.02, **explicit):
        mbs = new_mbs()
        sensor = add_sensor(mbs, scene(mbs))
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(end, 1, period), **explicit)
        return report, trajectory(mbs, sensor)[:, 1:], mbs

    return with_settings


@pytest.mark.parametrize(("scene", "end"), SCENES)
def test_steps_that_adapt_go_where_steps_at_the_first_limit_fail(run, scene, end, without_smaller_steps):
    report, exact, _ = run(scene, end, stepSize=1e-4)
    step = 0.95 * report["bounds"].bending
    with pytest.raises(DivergenceError):
        run(scene, end, stepSize=step)
    report, path, _ = run(scene, end, stepSize=step, adaptiveStep=True)
    assert np.ptp(exact, axis=0).max() > 0.2
    np.testing.assert_allclose(path, exact, atol=2e-3)
    assert report["stepSize"] < 0.5 * step
    assert report["steps"] < 0.9 * end / report["stepSize"]


def test_a_spring_that_catches_a_mass_stays_within_its_limit(run):
    """Nothing announces it: steps on the way into it are rejected, those that follow know it."""
    _, exact, _ = run(caught, 0.4, stepSize=4e-5)
    report, path, _ = run(caught, 0.4, stepSize=1e-3, adaptiveStep=True)
    np.testing.assert_allclose(path, exact, atol=2e-3)
    stiff = np.sqrt(2e6 / MASS)
    assert 0.0 < report["stepSize"] < 2.0 / stiff
    assert 0 < report["rejections"] < 10
    assert report["steps"] < 0.8 * stiff


def thrown(mbs):
    """A rope of 10 g, by a spring that is compressed by 5 cm."""
    section = {"massPerLength": 0.01, "bendingStiffness": 1e-4}
    nodes, _ = either_cable(
        mbs, False, 2, section, 1e4, numberOfElements=8, positionStart=[0, 0, 0], positionEnd=[0.8, 0.6, 0]
    )
    for axis in (0, 1):
        hold(mbs, nodes[0], axis)
    ends = [
        mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (mbs.AddNode(NodePointGround()), nodes[-1])
    ]
    mbs.AddObject(
        CartesianSpringDamper(markerNumbers=ends, stiffness=[1000, 1000, 0], offset=[0.83, 0.56, 0])
    )
    return nodes[-1]


@COARSE
def test_steps_that_become_shorter_for_the_motion_are_as_accurate_as_equal_ones(run):
    """They followed the limit, too, divided, and lost energy at each change: four times the error."""
    _, exact, _ = run(thrown, 0.02, 2e-4, stepSize=2.5e-6)
    report, path, _ = run(thrown, 0.02, 2e-4, adaptiveStep=True)
    _, equal, _ = run(thrown, 0.02, 2e-4, stepSize=report["meanStepSize"])
    errors = [np.abs(found - exact).max() for found in (path, equal)]
    assert errors[1] > 1e-4
    assert errors[0] < 1.5 * errors[1]


def test_stiffness_that_is_set_during_a_run_is_followed(new_mbs, add_sensor, solve):
    """5e6 N/m on 0.5 kg vibrate at 3162 rad/s, faster than the cable."""
    found, reports = [], []
    for explicit in ({"stepSize": 2e-5}, {"adaptiveStep": True}, {"stepSize": 8e-4}):
        mbs = new_mbs()
        body, node, _ = add_mass_on_cable(mbs)
        spring = mbs.CreateSpringDamper(
            itemNumbers=[mbs.CreateGround(), body],
            localPosition0=[1, 1, 0],
            referenceLength=1.0,
            stiffness=5e4,
        )

        def stiffen(mbs, t, spring=spring):
            return mbs.SetObjectParameter(spring, "stiffness", 5e4 if t < 0.1 else 5e6) or True

        mbs.SetPreStepUserFunction(stiffen)
        sensor = add_sensor(mbs, node)
        mbs.Assemble()
        if "adaptiveStep" in explicit or explicit["stepSize"] < 1e-4:
            settings = quiet_settings(0.15, 15, 0.01)
            reports.append(solve(mbs, settings=settings, energyTolerance=np.inf, **explicit))
            found.append(trajectory(mbs, sensor)[:, 1:])
        else:
            with pytest.raises(StepSizeError, match=r"after the change of .*stiffness"):
                solve(mbs, settings=quiet_settings(0.15, 15, 0.01), **explicit)
    sizes = [np.abs(path[:, 1]).max() for path in found]
    assert sizes[1] < 2.0 * sizes[0] < 1e-2
    assert reports[1]["stepSize"] < 2.0 / np.sqrt(5e6 / MASS)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_the_smallest_step_keeps_its_share_of_the_limit(run, solve, is_compiled, request):
    if not is_compiled:
        request.getfixturevalue("by_exudyn")
    report, _, mbs = run(pulled, 1.0, adaptiveStep=True)
    assert ("one call for each" in report["path"]) != is_compiled
    data = mbs.systemData
    data.SetSystemState(data.GetSystemState(), exudyn.ConfigurationType.Initial)
    settings = quiet_settings(1.001, 1)
    settings.timeIntegration.startTime = 1.0
    limit = solve(mbs, settings=settings, stepSize=1e-5)["bounds"].bending
    assert 0.6 * limit < report["stepSize"] < 0.72 * limit
    assert report["rejections"] == 0


def test_the_native_twin_moves_alike(run, new_mbs, add_sensor):
    _, ours, _ = run(pulled, 0.6, adaptiveStep=True)
    mbs = new_mbs()
    sensor = add_sensor(mbs, pulled(mbs, native=True))
    mbs.Assemble()
    settings = quiet_settings(0.6, 1200, 0.02)
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    with silence():
        mbs.SolveDynamic(settings)
    np.testing.assert_allclose(ours, trajectory(mbs, sensor)[:, 1:], atol=6e-3)


def set_and_damped(mbs):
    """By a dashpot that turns as the mass falls, and a force that a step function sets."""
    body, node, marker = add_mass_on_cable(mbs)
    ends = {"itemNumbers": [mbs.CreateGround(), body], "localPosition0": [1.2, 0, 0]}
    mbs.CreateSpringDamper(**ends, referenceLength=0.2, stiffness=10.0, damping=1000.0)
    load = mbs.AddLoad(Force(markerNumber=marker, loadVector=[0, 0, 0]))
    mbs.SetPreStepUserFunction(lambda mbs, t: mbs.SetLoadParameter(load, "loadVector", [t, 0, 0]) or True)
    return node


@pytest.mark.parametrize(
    ("scene", "integrator"), [(pulled, "RATTLE"), (driven, "RATTLE"), (set_and_damped, "RK4")]
)
def test_a_run_goes_on_from_its_restart_file(new_mbs, add_sensor, solve, tmp_path, scene, integrator):
    found, explicit = [], {"adaptiveStep": True, "integrator": integrator}
    for end, restarts in ((0.4, False), (0.2, True), (0.4, True)):
        mbs = new_mbs()
        sensor = add_sensor(mbs, scene(mbs))
        mbs.Assemble()
        settings = quiet_settings(end, 1, 0.02)
        solve(mbs, settings=restarting(settings, tmp_path) if restarts else settings, **explicit)
        found.append(trajectory(mbs, sensor))
    np.testing.assert_array_equal(found[2], found[0][-len(found[2]) :])
    assert len(found[2]) > 5


def pulled_alone(mbs):
    """A cable and a force that grows to 216 N."""
    tip = add_pendulum(mbs)["nodes"][-1]
    load_node(mbs, tip, [1, 0, 0], loadVectorUserFunction=lambda mbs, t, load: [600 * t**2, 0, 0])


@pytest.mark.parametrize("scene", [pulled_alone, pulled])
def test_ensembles_and_steppers_adapt_their_steps_as_a_run_does(new_mbs, scene):
    end, period, explicit = 0.6, 0.02, ExplicitSettings(adaptiveStep=True)
    systems = [new_mbs() for _ in range(4)]
    for mbs in systems:
        scene(mbs)
        mbs.Assemble()
    alone, of_stepper, *members = systems
    settings = quiet_settings(end, round(end / period), period)
    with silence():
        report = SolveExplicit(alone, settings, explicit)
    result = SolveEnsemble(members, settings, explicit, derivatives=2, threads=2)
    stepper = ExplicitStepper(of_stepper, explicit, interval=period, duration=end)
    stepper.Start()
    for _ in range(round(end / period)):
        stepper.Step()
    stepper.WriteToSystem()
    assert report["stepSize"] < 0.8 * stepper.stepSize
    np.testing.assert_array_equal(result["steps"], report["steps"])
    for states, read in zip(("coordinates", "velocities"), ("", "_t"), strict=True):
        expected = getattr(alone.systemData, f"GetODE2Coordinates{read}")()
        stepped = getattr(of_stepper.systemData, f"GetODE2Coordinates{read}")()
        np.testing.assert_allclose(stepped, expected, atol=1e-12)  # its times differ by round-off
        for member in result[states]:
            np.testing.assert_array_equal(member[-1], expected)
    expected = np.array(alone.systemData.GetODE2Coordinates_tt())
    scale = np.abs(expected).max()
    for member in result["accelerations"]:
        np.testing.assert_allclose(member[-1], expected, atol=1e-9 * scale)
