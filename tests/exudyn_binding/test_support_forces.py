"""Constraints that hold, move or link cables show their forces, as those of native cables do."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import CoordinateConstraint, InertiaCuboid

from exudyn_inext import CableShape, CreatePrescribedMotion, SolveEquilibrium
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import add_cable, either_cable, hang, load_node, trajectory

G, LENGTH, DENSITY = 9.81, 1.4, 0.3
WEIGHT = DENSITY * LENGTH * G
FORCE = exudyn.OutputVariableType.Force
SECTION = {"massPerLength": DENSITY, "bendingStiffness": 0.05}
AXIAL = 1e4  # EA of native twins [N], damped, so that they soon hang without axial waves


def hold(mbs, node, coordinate, is_first=False):
    """is_first: whether the marker of the node comes before that of the ground."""
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    markers = [ground, mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))]
    return mbs.AddObject(CoordinateConstraint(markerNumbers=markers[::-1] if is_first else markers))


def pin(mbs, nodes, dim):
    return [hold(mbs, nodes[0], k) for k in range(dim)]


def pin_with_reversed_markers(mbs, nodes, dim):
    return [hold(mbs, nodes[0], k, is_first=True) for k in range(dim)]


def clamp(mbs, nodes, dim):
    """The slope along the cable, whose force follows the strain there, is held, too, but not looked at."""
    hold(mbs, nodes[0], dim)
    return [hold(mbs, nodes[0], k) for k in range(2 * dim) if k != dim]


def slide(mbs, nodes, dim):
    """Held in the direction in which it hangs."""
    return [hold(mbs, nodes[0], 0)]


def hang_at_a_rod(mbs, nodes, dim):
    return [*pin(mbs, nodes, dim), hang(mbs, nodes[4], [0.5 * LENGTH, 0.5, 0], 0.5)]


def move(mbs, nodes, dim):
    def place(t):
        return [0.02 * np.sin(3 * t) ** 2, 0.1 * (1 - np.cos(6 * t)), 0][:dim]

    return CreatePrescribedMotion(mbs, nodes[0], place)["constraintObjects"]


def join_body(mbs, node, dim):
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(1000, [0.1, 0.05, 0.05]),
        referencePosition=[LENGTH + 0.05, 0, 0],
        gravity=[G, 0, 0],
    )
    markers = [
        mbs.AddMarker(MarkerNodePosition(nodeNumber=node)),
        mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[-0.05, 0, 0])),
    ]
    return mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, int(dim == 3)]))


def build(mbs, support, dim=2, native=False, body=False):
    """Sensors of the forces in supports of a cable that hangs along x and is pushed sideways at its end."""
    section = SECTION | ({"axialDamping": 0.005 * AXIAL} if native else {})
    line = {"positionStart": [0, 0, 0], "positionEnd": [LENGTH, 0, 0], "gravity": [G, 0, 0]}
    nodes, _ = either_cable(mbs, native, dim, section, AXIAL, numberOfElements=8, **line)
    constraints = support(mbs, nodes, dim)
    if body:
        join_body(mbs, nodes[-1], dim)

    def push(mbs, t, load):
        return [0, load[1] * np.sin(5 * t) ** 2, 0]

    load_node(mbs, nodes[-1], [0, 1.5 if body else 0.6, 0], loadVectorUserFunction=push)
    kind = {"storeInternal": True, "outputVariableType": FORCE}
    return [mbs.AddSensor(SensorObject(objectNumber=number, **kind)) for number in constraints]


def rows(mbs, sensors):
    return np.hstack([trajectory(mbs, sensor)[:, 1:] for sensor in sensors])


def run(mbs, solve, support, changes, **explicit):
    sensors = build(mbs, support, **changes)
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.4, 1, 0.02), **explicit)
    return rows(mbs, sensors)


def run_natively(mbs, support, **changes):
    sensors = build(mbs, support, native=True, **changes)
    mbs.Assemble()
    settings = quiet_settings(0.4, 400, 0.02)
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    with silence():
        mbs.SolveDynamic(settings)
    return rows(mbs, sensors)


LONE = [(pin, 2), (pin_with_reversed_markers, 2), (clamp, 3), (slide, 2), (hang_at_a_rod, 2), (move, 3)]
AMONG_BODIES = [(pin, 3), (clamp, 2), (hang_at_a_rod, 2), (move, 2)]
CASES = [(*case, False) for case in LONE] + [(*case, True) for case in AMONG_BODIES]


@pytest.mark.parametrize(("support", "dim", "body"), CASES)
def test_supports_have_the_forces_of_native_cables(new_mbs, solve, support, dim, body):
    ours = run(new_mbs(), solve, support, {"dim": dim, "body": body})
    native = run_natively(new_mbs(), support, dim=dim, body=body)
    settled = slice(12, None)  # the native cable, which begins without tension
    scale = np.abs(native[settled]).max(axis=0)
    assert (np.abs(ours[settled] - native[settled]) <= 0.05 * scale + 1e-6).all()
    assert support is slide or scale[1] > 0.03
    if support is not move:  # at rest
        weight = WEIGHT + (0.25 * G if body else 0.0)
        assert abs(ours[0, 0]) == pytest.approx(weight, rel=1e-9)


@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
def test_all_integrators_and_steps_show_the_same_forces(new_mbs, solve, body, integrator):
    changes = {"body": body}
    expected = run(new_mbs(), solve, hang_at_a_rod, changes, stepSize=2e-4)
    found = run(new_mbs(), solve, hang_at_a_rod, changes, integrator=integrator, stepSize=1e-3)
    np.testing.assert_allclose(found, expected, atol=5e-3 * np.abs(expected).max())


@pytest.mark.parametrize("body", [False, True])
def test_scaled_masses_and_one_step_after_the_other_change_no_force(new_mbs, solve, body):
    ahead = run(new_mbs(), solve, clamp, {"body": body}, stepSize=5e-4)
    watched = run(new_mbs(), solve, clamp, {"body": body}, stepSize=5e-4, dependsOnTimeOnly=False)
    np.testing.assert_allclose(watched, ahead, rtol=1e-6, atol=1e-6 * WEIGHT)
    scaled = run(new_mbs(), solve, clamp, {"body": body}, stepSize=5e-4, massScaling=0.3)
    np.testing.assert_allclose(scaled, ahead, atol=2e-3 * WEIGHT)
    np.testing.assert_allclose(scaled[0], ahead[0], rtol=1e-9, atol=1e-9)


def test_after_a_run_the_constraint_has_the_force_of_its_last_row(mbs, solve):
    sensors = build(mbs, pin)
    mbs.Assemble()
    solve(mbs, settings=quiet_settings(0.1, 1, 0.05))
    numbers = [mbs.GetSensor(sensor)["objectNumber"] for sensor in sensors]
    found = [mbs.GetObjectOutput(number, FORCE) for number in numbers]
    np.testing.assert_array_equal(found, rows(mbs, sensors)[-1])


def test_who_looks_at_places_only_has_the_forces_at_the_end(new_mbs, add_sensor, solve):
    found = []
    for looks in (True, False):
        mbs = new_mbs()
        sensors = build(mbs, pin)
        numbers = [mbs.GetSensor(sensor)["objectNumber"] for sensor in sensors]
        for sensor in sensors if not looks else ():
            mbs.SetSensorParameter(sensor, "outputVariableType", exudyn.OutputVariableType.ConstraintEquation)
        mbs.Assemble()
        solve(mbs, 0.1)
        found.append([mbs.GetObjectOutput(number, FORCE) for number in numbers])
    np.testing.assert_array_equal(*found)


def test_each_of_several_cables_has_its_own_forces(mbs, solve):
    cables = [
        add_cable(mbs, positionStart=[k, 0, 0], positionEnd=[k, -1.8 - k, 0], groundConstraintsEnd=None,
                  groundConstraintsStart=[True, True, False, False])
        for k in range(3)
    ]  # fmt: skip
    mbs.Assemble()
    solve(mbs, 0.05)
    found = [mbs.GetObjectOutput(cable["constraintObjects"][1], FORCE) for cable in cables]
    np.testing.assert_allclose(found, [-0.0348 * G * (1.8 + k) for k in range(3)], rtol=1e-9)


def test_a_ring_hangs_with_its_weight(mbs):
    ring = CableShape.Circle([0, 0, 0], 0.3, 12)
    made = add_cable(mbs, shape=ring, groundConstraintsStart=[True, True, False, False])
    mbs.Assemble()
    SolveEquilibrium(mbs)
    found = [mbs.GetObjectOutput(number, FORCE) for number in made["constraintObjects"]]
    np.testing.assert_allclose(found, [0, 0.0348 * G * 0.6 * np.pi], rtol=1e-3, atol=1e-9)


STIFF = {"massPerLength": DENSITY, "bendingStiffness": 1.0}


def statically(mbs, native, body):
    """Forces in the clamp of a cable that is pulled from its line, and in the joint of a mass."""
    line = {"positionStart": [0, 0, 0], "positionEnd": [LENGTH, 0, 0], "gravity": [0.5, -G, 0]}
    nodes, _ = either_cable(mbs, native, 2, STIFF, 1e6, numberOfElements=16, **line)
    constraints = clamp(mbs, nodes, 2)
    load_node(mbs, nodes[-1], [0.3, 0.6, 0])
    if body:
        point = mbs.CreateMassPoint(
            mass=0.2, referencePosition=[LENGTH, 0, 0], gravity=[0, -G, 0], returnDict=True
        )
        hold(mbs, point["nodeNumber"], 2, is_first=True)
        pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (nodes[-1], point["nodeNumber"])]
        constraints.append(mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0])))
    mbs.Assemble()
    return constraints


@pytest.mark.parametrize("body", [False, True])
def test_equilibria_have_the_forces_of_the_native_static_solver(new_mbs, body):
    native, ours = new_mbs(), new_mbs()
    expected, found = statically(native, True, body), statically(ours, False, body)
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.staticSolver.numberOfLoadSteps = 10
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    with silence():
        native.SolveStatic(settings)
    SolveEquilibrium(ours)
    for wanted, number in zip(expected, found, strict=True):
        wanted, force = native.GetObjectOutput(wanted, FORCE), ours.GetObjectOutput(number, FORCE)
        np.testing.assert_allclose(force, wanted, rtol=0.01, atol=1e-6)
    vertical = [mbs.GetObjectOutput(n, FORCE) for mbs, n in ((native, expected[1]), (ours, found[1]))]
    assert vertical[1] == pytest.approx(vertical[0], rel=1e-6)


@pytest.mark.parametrize("is_first", [False, True])
def test_a_body_that_is_held_has_the_sign_of_the_native_solver(new_mbs, solve, is_first):
    found = []
    for native in (True, False):
        mbs = new_mbs()
        point = mbs.CreateMassPoint(mass=2.0, gravity=[0, -G, 0], returnDict=True)
        number = hold(mbs, point["nodeNumber"], 1, is_first=is_first)
        mbs.CreateSpringDamper(itemNumbers=[mbs.CreateGround(), point["bodyNumber"]], stiffness=10.0,
                               localPosition0=[1, 0, 0], referenceLength=0.5)  # fmt: skip
        mbs.Assemble()
        if native:
            with silence():
                mbs.SolveDynamic(quiet_settings(0.01, 10))
        else:
            solve(mbs, 0.01)
        found.append(mbs.GetObjectOutput(number, FORCE))
    assert found[1] == pytest.approx(found[0], rel=1e-6)
