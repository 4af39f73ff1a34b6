"""Scenes of native items alone: runs that go wrong, restart files, and held coordinates."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    Mass1D,
    MassPoint2D,
    Node1D,
    NodePoint2D,
    NodePointGround,
    RevoluteJoint2D,
    SensorNode,
    SensorObject,
)

from exudyn_inext import DivergenceError
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.run.step_control import QUARTERS
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_pendulum, native_cable, that_remembers, trajectory

COORDINATES = exudyn.OutputVariableType.Coordinates


def marker_of(mbs, node, coordinate):
    return mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))


def add_spring(mbs, node, coordinate, force):
    """A spring to ground that Exudyn evaluates.   force: (t [s], displacement [m]) -> [N]."""
    markers = [marker_of(mbs, mbs.AddNode(NodePointGround()), 0), marker_of(mbs, node, coordinate)]

    def function(mbs, t, number, displacement, velocity, stiffness, damping, offset):
        return force(t, displacement)

    mbs.AddObject(
        CoordinateSpringDamper(markerNumbers=markers, springForceUserFunction=that_remembers(function))
    )


def observe(mbs, node):
    return mbs.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=COORDINATES))


def add_mass(mbs, force, displacement=0.0, velocity=0.0, mass=1.0):
    """A mass on a spring; a sensor of its place."""
    node = mbs.AddNode(Node1D(initialCoordinates=[displacement], initialVelocities=[velocity]))
    mbs.AddObject(Mass1D(mass=mass, nodeNumber=node))
    add_spring(mbs, node, 0, force)
    return observe(mbs, node)


def hardening_spring(mbs):
    """Six times as stiff where it is stretched most."""
    return add_mass(mbs, lambda t, u: 100.0 * u + 400.0 * u**3, velocity=20.0)


def spring_that_stiffens(mbs):
    return add_mass(mbs, lambda t, u: 100.0 * (1.0 + 200.0 * t**2) * u, displacement=0.1)


def stop_at_speed(mbs):
    return add_mass(mbs, lambda t, u: u + 1e4 * min(u, 0.0), displacement=0.5, velocity=-3.0)


def light_mass_beside_a_heavy_one(mbs):
    """Its spring stiffens by half a percent in a step, and passes the stability limit half-way."""
    add_mass(mbs, lambda t, u: 100.0 * u, velocity=1.0)
    return add_mass(mbs, lambda t, u: (150.0 + 100.0 * t) * u, velocity=0.3, mass=1e-2)


def quiet_mass(mbs):
    """A vibration at 0.9 of the stability limit, w = 36 rad/s, beside a slower one."""
    add_mass(mbs, lambda t, u: u + u**3, displacement=1.0)
    return add_mass(mbs, lambda t, u: 1296.0 * u, velocity=0.02)


PIN = [True, True, False, False]


def cable_against_a_stop(mbs):
    """A pendulum whose end, of 1 kg, falls on something 0.3 m below."""
    node = native_cable(mbs, 2, 6, axial_stiffness=1e3, groundConstraintsStart=PIN)["nodes"][-1]
    end = mbs.AddObject(MassPoint2D(mass=1.0, nodeNumber=node))
    weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=end))
    mbs.AddLoad(LoadMassProportional(markerNumber=weight, loadVector=[0, -9.81, 0]))
    add_spring(mbs, node, 1, lambda t, u: 1e8 * min(u + 0.3, 0.0))
    return observe(mbs, node)


def inextensible_cable_against_a_stop(mbs):
    """The same with an inextensible cable."""
    cable = add_pendulum(mbs, groundConstraintsStart=PIN)["nodes"][-1]
    place = mbs.GetNode(cable)["referenceCoordinates"][:2]
    end = mbs.AddNode(NodePoint2D(referenceCoordinates=place))
    body = mbs.AddObject(MassPoint2D(mass=0.1, nodeNumber=end))
    weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
    mbs.AddLoad(LoadMassProportional(markerNumber=weight, loadVector=[0, -9.81, 0]))
    ends = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in (cable, end)]
    mbs.AddObject(RevoluteJoint2D(markerNumbers=ends))
    add_spring(mbs, end, 1, lambda t, u: 1e6 * min(u + 0.3, 0.0))
    return observe(mbs, end)


SCENES = {  # step [s], end [s], output [s]
    hardening_spring: (0.05, 0.8, 0.1),
    spring_that_stiffens: (0.05, 0.5, 0.1),
    stop_at_speed: (0.05, 1.5, 0.05),
    cable_against_a_stop: (5e-4, 0.4, 0.02),
    inextensible_cable_against_a_stop: (2e-3, 0.5, 0.02),
}


@pytest.fixture
def run(new_mbs, solve):
    """(scene, step, output, ends, ...) -> rows of its sensor, run by run, and the last report."""

    def of(build, step, output, *ends, restart=None, **explicit):
        mbs = new_mbs()
        sensor = build(mbs)
        mbs.Assemble()
        rows = []
        for end in ends:
            settings = quiet_settings(end, 1, output)
            if restart is not None:
                settings.solution.restart.write = settings.solution.restart.continueIfAvailable = True
                settings.solution.restart.name = str(restart)
                settings.solution.restart.writePeriod = output
            report = solve(mbs, settings=settings, stepSize=step, **explicit)
            rows.append(trajectory(mbs, sensor)[:, 1:3].copy())  # x, y
        return rows, report

    return of


@pytest.mark.filterwarnings("ignore:.*the energy has grown")  # Zhai's, where contact changes the step
@pytest.mark.parametrize(
    ("scene", "integrator"),
    [
        (scene, integrator)
        for scene in SCENES
        for integrator in INTEGRATORS
        if (scene, integrator)
        not in [(cable_against_a_stop, "RK4"), (inextensible_cable_against_a_stop, "Zhai")]
    ],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_steps_that_become_too_long_are_taken_again_smaller(scene, integrator, run):
    step, end, output = SCENES[scene]
    (rows,), report = run(scene, step, output, end, integrator=integrator)
    assert report["rejections"] > 0 and report["stepSize"] < 0.3 * step
    (fine,), _ = run(scene, step / 8, output, end, integrator=integrator)
    assert np.abs(rows - fine).max() < 0.01 * np.ptp(fine, axis=0).max()


def test_a_light_part_that_becomes_unstable_is_seen_beside_a_heavy_one(run):
    """From then on its vibration does not grow."""
    with pytest.warns(UserWarning, match="the energy has grown"):
        (rows,), report = run(light_mass_beside_a_heavy_one, 0.0142, 0.0142, 1.0)
    assert report["rejections"] > 0
    outputs = len(rows) // 3
    assert np.abs(rows[-outputs:]).max() < 1.1 * np.abs(rows[:-outputs]).max()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_quiet_scene_near_the_limit_is_left_alone(integrator, run):
    """The same bits as where nobody looks at the energy."""
    step = 0.05 * (2**0.5 if integrator == "RK4" else 1.0)
    (rows,), report = run(quiet_mass, step, 10 * step, 200 * step, integrator=integrator)
    (expected,), _ = run(
        quiet_mass, step, 10 * step, 200 * step, integrator=integrator, energyTolerance=np.inf
    )
    assert report["rejections"] == 0
    np.testing.assert_array_equal(rows, expected)


@pytest.mark.parametrize("scene", [stop_at_speed, cable_against_a_stop], ids=lambda scene: scene.__name__)
def test_steps_grow_again_after_a_stop(scene, run):
    step, end, output = SCENES[scene]
    _, report = run(scene, step, output, end)
    assert report["steps"] < 0.3 * end / report["stepSize"]


def test_a_second_run_repeats_the_first(run):
    (first, second), _ = run(stop_at_speed, 0.05, 0.05, 1.5, 1.5)
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("scene", [stop_at_speed, cable_against_a_stop], ids=lambda scene: scene.__name__)
def test_restart_files_do_not_change_a_bit(scene, run, tmp_path):
    step, end, output = (2.0 ** round(np.log2(time)) for time in SCENES[scene])  # numbers that add up
    (whole,), _ = run(scene, step, output, end, restart=tmp_path / "whole.npz")
    joined = [
        run(scene, step, output, part, restart=tmp_path / "parts.npz")[0][0]
        for part in (0.5 * end, 0.75 * end, end)
    ]
    np.testing.assert_array_equal(np.concatenate(joined), whole)


def lost_beyond(place, force):
    """A spring that has no force any more."""
    return lambda mbs: add_mass(mbs, lambda t, u: 10.0 * u if u < place else force(u), velocity=4.0)


@pytest.mark.parametrize(
    ("force", "cause"),
    [
        (lambda u: np.nan, "not finite"),
        (lambda u: 1e200**2 * u, "finite"),
        (lambda u: (10.0 * u) ** 999.0, ""),
        (lambda u: 1e12, "work is wrong"),
    ],
    ids=["no number", "infinite", "overflow", "wall"],
)
def test_what_no_step_can_mend_is_said_with_time_place_and_cause(mbs, solve, force, cause):
    """The spring is passed at u = 1 m, after arcsin(sqrt(10) / 4) / sqrt(10) = 0.289 s."""
    sensor = lost_beyond(1.0, force)(mbs)
    mbs.Assemble()
    with pytest.raises(DivergenceError, match=r"before t = 0\.3 s.*" + cause) as caught:
        solve(mbs, settings=quiet_settings(1.0, 1, 0.02), stepSize=0.02)
    said = str(caught.value)
    assert "node 0" in said and f"{QUARTERS + 1} times steps were taken again" in said
    assert mbs.systemData.GetTime() == pytest.approx(0.28)
    here = mbs.systemData.GetODE2Coordinates()
    np.testing.assert_array_equal(here, trajectory(mbs, sensor)[-1, 1:])
    np.testing.assert_allclose(here, 4.0 / np.sqrt(10) * np.sin(np.sqrt(10) * 0.28), rtol=1e-3)


def test_an_error_of_a_user_function_is_not_taken_for_a_step_that_went_wrong(mbs, solve):
    add_mass(mbs, lambda t, u: {}["nothing"], velocity=1.0)
    mbs.Assemble()
    with pytest.raises(Exception, match="nothing"):
        solve(mbs, 0.1, stepSize=0.01)


def add_held_cable(mbs):
    """A native pendulum; its support in x and a sensor of the force there, and one of its end."""
    nodes = native_cable(mbs, 2, 4, axial_stiffness=1e3)["nodes"]
    ground = marker_of(mbs, mbs.AddNode(NodePointGround()), 0)
    supports = [
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker_of(mbs, nodes[0], coordinate)]))
        for coordinate in (0, 1)
    ]
    kind = exudyn.OutputVariableType.Force
    force = mbs.AddSensor(SensorObject(objectNumber=supports[1], storeInternal=True, outputVariableType=kind))
    return supports, [force, observe(mbs, nodes[-1])]


def run_natively(mbs, end, output):
    settings = quiet_settings(end, round(end / 1e-4), output)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
    settings.timeIntegration.newton.relativeTolerance = 1e-8
    with silence():
        mbs.SolveDynamic(settings)


def change_nothing(mbs, supports):
    pass


def release(mbs, supports):
    mbs.SetPreStepUserFunction(
        lambda mbs, t: bool(mbs.SetObjectParameter(supports[0], "activeConnector", t < 0.05) or True)
    )


def move(mbs, supports):
    """Slowly, so that both solvers see the same motion."""
    mbs.SetPreStepUserFunction(
        lambda mbs, t: bool(mbs.SetObjectParameter(supports[0], "offset", max(0.0, t - 0.05) ** 3) or True)
    )


@pytest.mark.parametrize("change", [change_nothing, release, move])
def test_held_coordinates_have_the_reactions_of_generalized_alpha(new_mbs, solve, change):
    found = []
    for run in (lambda mbs: solve(mbs, settings=quiet_settings(0.1, 1000, 0.01), stepSize=1e-4), None):
        mbs = new_mbs()
        supports, sensors = add_held_cable(mbs)
        mbs.Assemble()
        change(mbs, supports)
        if run is None:
            run_natively(mbs, 0.1, 0.01)
        else:
            run(mbs)
        found.append([trajectory(mbs, sensor)[:, 1:] for sensor in sensors])
    (force, place), (expected_force, expected_place) = found
    np.testing.assert_allclose(place, expected_place, atol=2e-3 * np.abs(expected_place).max())
    np.testing.assert_allclose(force, expected_force, atol=0.02 * np.abs(expected_force).max())
    assert np.abs(expected_force).max() > 0.1
