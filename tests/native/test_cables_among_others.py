"""Cables joined to bodies, to each other and to springs; what a coupled run leaves behind."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    GenericJoint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRigid,
    RevoluteJoint2D,
    SphericalJoint,
    TorsionalSpringDamper,
)
from exudyn.utilities import InertiaCuboid

from exudyn_inext import CableForces, CableShape, CreateCableForceSensor, DivergenceError
from exudyn_inext.items.cable_data import find_cable_item
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import either_cable, load_node, native_cable, solve_native, trajectory

GRAVITY = [0, -9.81, 0]


def brick(mbs, x, **options):
    """A small brick whose left end is at x; returns its dict and a marker at that end."""
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(100, [0.2, 0.05, 0.1]),
        referencePosition=[x + 0.1, 0, 0],
        gravity=GRAVITY,
        returnDict=True,
        **options,
    )
    end = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body["bodyNumber"], localPosition=[-0.1, 0, 0]))
    return body, end


def hook(mbs, node, marker, **options):
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    return mbs.AddObject(SphericalJoint(markerNumbers=[tip, marker], **options))


def hanging_brick(mbs, nodes, add_sensor):
    """A brick on the last node; returns the sensors of tip and brick."""
    body, end = brick(mbs, 1.8)
    hook(mbs, nodes[-1], end)
    return add_sensor(mbs, nodes[-1]), add_sensor(mbs, body["nodeNumber"])


@pytest.fixture
def with_brick(new_mbs, add_pendulum, add_sensor, solve):
    """(settings of the run) -> report, paths of tip and brick over 0.4 s, mbs."""

    def run(**explicit):
        mbs = new_mbs()
        cable = add_pendulum(mbs, dimension=3, groundConstraintsStart=[True] * 3 + [False] * 3)
        sensors = hanging_brick(mbs, cable["nodes"], add_sensor)
        mbs.Assemble()
        report = solve(mbs, 0.4, **explicit)
        return report, [trajectory(mbs, sensor) for sensor in sensors], mbs

    return run


def damped_arm(mbs, native):
    """A damped cable, clamped to a brick on a torsional spring and to a hanging one; both bricks."""
    section = {"massPerLength": 0.2, "bendingStiffness": 0.5, "bendingDamping": 0.02}
    line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "gravity": GRAVITY}
    line["numberOfElements"] = 20 if native else 10
    nodes, _ = either_cable(mbs, native, 2, section, 2e5, **line)
    inertia, bricks = InertiaCuboid(1000, [0.2, 0.1, 0.05]), []
    for node, x, end in ((nodes[0], -0.1, 0.1), (nodes[-1], 1.1, -0.1)):
        place = {"referencePosition": [x, 0, 0], "gravity": GRAVITY}
        bricks.append(mbs.CreateRigidBody(inertia=inertia, create2D=True, **place))
        clamp = MarkerBodyRigid(bodyNumber=bricks[-1], localPosition=[end, 0, 0])
        pair = [mbs.AddMarker(marker) for marker in (clamp, MarkerNodeRigid(nodeNumber=node))]
        mbs.AddObject(GenericJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0, 0, 0, 1]))
    wall = MarkerBodyRigid(bodyNumber=mbs.CreateGround(referencePosition=[-0.2, 0, 0]))
    hinge = MarkerBodyRigid(bodyNumber=bricks[0], localPosition=[-0.1, 0, 0])
    pair = [mbs.AddMarker(marker) for marker in (wall, hinge)]
    mbs.AddObject(RevoluteJoint2D(markerNumbers=pair))
    mbs.AddObject(TorsionalSpringDamper(markerNumbers=pair, stiffness=20, damping=0.1))
    return bricks


def test_a_damped_cable_between_clamps_moves_as_a_native_one(new_mbs, solve):
    """Its damping has more on the left than it is, which the clamps must not feel."""
    found = []
    for native in (True, False):
        mbs = new_mbs()
        bricks = damped_arm(mbs, native)
        mbs.Assemble()
        if native:
            solve_native(mbs, 1.0, step=2.5e-4)
        else:
            report = solve(mbs, 1.0)
        kind = exudyn.OutputVariableType.Position
        found.append([mbs.GetObjectOutputBody(brick, kind) for brick in bricks])
    np.testing.assert_allclose(*found, atol=1e-3)
    assert report["drift"]["energyGain"] < 1e-3


def test_so_it_does_by_exudyns_own_evaluation(by_exudyn, new_mbs, solve):
    test_a_damped_cable_between_clamps_moves_as_a_native_one(new_mbs, solve)


def test_a_brick_on_a_cable_moves_as_on_a_native_cable(new_mbs, with_brick, add_sensor):
    mbs = new_mbs()
    nodes = native_cable(mbs, 3, 16)["nodes"]
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround()))
    hook(mbs, nodes[0], ground)
    sensors = hanging_brick(mbs, nodes, add_sensor)
    mbs.Assemble()
    solve_native(mbs, 0.4)
    native = [trajectory(mbs, sensor) for sensor in sensors]
    for explicit in (
        {},
        {"integrator": "Zhai"},
        {"integrator": "RK4"},
        {"stepSize": 1e-3, "massScaling": 0.3},
    ):
        _, found, _ = with_brick(**explicit)
        for path, expected in zip(found, native, strict=True):
            assert np.abs(path[-1, 1:] - path[0, 1:]).max() > 0.4
            np.testing.assert_allclose(path, expected, atol=4e-4, err_msg=str(explicit))


def test_the_report_says_that_all_items_are_compiled(with_brick):
    assert with_brick()[0]["path"].endswith("in one compiled call, because all loads are known")


def test_the_report_says_what_an_evaluation_takes_and_why(by_exudyn, with_brick):
    path = with_brick()[0]["path"]
    assert "one right-hand side of Exudyn" in path
    assert "the mass of 1 bodies, the Jacobians of 1 joints" in path
    assert "(RigidBody)" in path and "(JointSpherical)" in path


def split_cable(mbs, add_pendulum, add_cable, slack_joint=False):
    """The cable of 6 elements as two of 3, joined in position and, at first across, in slope."""
    first = add_pendulum(mbs, positionEnd=[0.9, 0, 0], numberOfElements=3)
    second = add_cable(mbs, positionStart=[0.9, 0, 0], numberOfElements=3)
    nodes = first["nodes"][-1], second["nodes"][0]
    for coordinate in (0, 1) if slack_joint else (0, 1, 3):
        pair = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=coordinate)) for n in nodes]
        mbs.AddObject(CoordinateConstraint(markerNumbers=pair))
    return second["nodes"][-1]


@pytest.mark.parametrize("integrator", ["RATTLE", "Zhai", "RK4"])
def test_a_cable_cut_in_two_and_rejoined_is_the_whole_one(
    new_mbs, add_pendulum, add_cable, add_sensor, solve, integrator
):
    paths = []
    for cut in (True, False):
        mbs = new_mbs()
        tip = (
            split_cable(mbs, add_pendulum, add_cable)
            if cut
            else add_pendulum(mbs, numberOfElements=6)["nodes"][-1]
        )
        sensor = add_sensor(mbs, tip)
        mbs.Assemble()
        solve(mbs, 0.3, integrator=integrator, stepSize=1e-3)
        paths.append(trajectory(mbs, sensor))
    assert np.abs(paths[0][-1, 1:] - paths[0][0, 1:]).max() > 0.3
    np.testing.assert_allclose(*paths, atol=2e-7)


def test_a_spring_at_the_tip_pulls_as_on_a_native_cable(new_mbs, add_pendulum, add_sensor, solve):
    def attach_spring(mbs, node):
        ground = mbs.AddMarker(
            MarkerBodyPosition(bodyNumber=mbs.CreateGround(referencePosition=[1.8, 0.2, 0]))
        )
        tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        pair = {"markerNumbers": [ground, tip], "stiffness": [3, 3, 0], "damping": [0.05, 0.05, 0]}
        mbs.AddObject(CartesianSpringDamper(**pair))
        return add_sensor(mbs, node)

    mbs = new_mbs()
    sensor = attach_spring(mbs, add_pendulum(mbs, numberOfElements=8)["nodes"][-1])
    mbs.Assemble()
    solve(mbs, 0.3, massScaling=0.3)  # default steps are 1.9 mm off
    native = new_mbs()
    nodes = native_cable(native, 2, 12)["nodes"]
    ground = native.AddMarker(MarkerBodyPosition(bodyNumber=native.CreateGround()))
    hook(native, nodes[0], ground, constrainedAxes=[1, 1, 0])
    expected = attach_spring(native, nodes[-1])
    native.Assemble()
    solve_native(native, 0.3)
    np.testing.assert_allclose(trajectory(mbs, sensor), trajectory(native, expected), atol=1e-3)


def test_loads_on_cables_are_the_same_whether_exudyn_or_the_kernels_evaluate_them(
    new_mbs, add_pendulum, add_sensor, solve
):
    paths = []
    for foreign in (True, False):
        mbs = new_mbs()
        nodes = add_pendulum(mbs)["nodes"]
        load_node(mbs, nodes[3], [0.1, 0.2, 0])
        load_node(mbs, nodes[-1], [1, 0, 0], loadVectorUserFunction=lambda mbs, t, f: [0, np.sin(9 * t), 0])
        if foreign:
            mbs.CreateMassPoint(mass=1.0, referencePosition=[5, 0, 0])
        sensor = add_sensor(mbs, nodes[-1])
        mbs.Assemble()
        solve(mbs, 0.2, stepSize=1e-3)
        paths.append(trajectory(mbs, sensor))
    np.testing.assert_allclose(*paths, atol=1e-10)


def evaluated(mbs):
    """What Exudyn evaluates of each object, as text."""
    objects = [mbs.GetObject(number) for number in range(mbs.systemData.NumberOfObjects())]
    return [str({k: v for k, v in data.items() if not k.startswith("temp")}) for data in objects]


def test_how_a_cable_keeps_its_length_elsewhere_does_not_matter_here(
    new_mbs, add_pendulum, add_sensor, solve
):
    """Forces, masses and constraints for other solvers are switched off, and on again."""
    paths = []
    for enforcement in ("projection", "penaltyMass", "algebraic"):
        mbs = new_mbs()
        cable = add_pendulum(mbs, numberOfElements=3, enforcement=enforcement)
        mbs.CreateMassPoint(mass=1.0, referencePosition=[5, 0, 0])
        sensors = add_sensor(mbs, cable["nodes"][-1]), CreateCableForceSensor(mbs, cable, 0.9)
        mbs.Assemble()
        before = evaluated(mbs)
        solve(mbs, 0.1, stepSize=1e-3)
        assert evaluated(mbs) == before
        paths.append([trajectory(mbs, sensor) for sensor in sensors])
    for other in paths[1:]:
        for path, expected in zip(other, paths[0], strict=True):
            np.testing.assert_allclose(path, expected, rtol=1e-9, atol=1e-12)


def test_a_closed_cable_takes_forces_and_joints_at_its_first_node(new_mbs, add_cable, add_sensor, solve):
    """Held there by a spherical joint, or by a pin: the same motion."""
    paths = []
    for by_joint in (True, False):
        mbs = new_mbs()
        shape = CableShape.Circle([0, 0], 0.5, 8)
        pin = None if by_joint else [True, True, False, False]
        ring = add_cable(mbs, shape=shape, groundConstraintsStart=pin)
        load_node(mbs, ring["nodes"][0], [0, 1, 0])
        load_node(mbs, ring["nodes"][4], [0, 0.3, 0])
        if by_joint:
            ground = mbs.CreateGround(referencePosition=[0.5, 0, 0])
            marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=ground))
            hook(mbs, ring["nodes"][0], marker, constrainedAxes=[1, 1, 0])
        sensor = add_sensor(mbs, ring["nodes"][4])
        mbs.Assemble()
        solve(mbs, 0.1, stepSize=5e-4)
        paths.append(trajectory(mbs, sensor))
    np.testing.assert_allclose(*paths, atol=1e-7)


def test_tension_among_bodies_and_joints_balances_what_hangs_on_the_cable(mbs, add_pendulum, solve):
    cable = add_pendulum(
        mbs, positionEnd=[0, -1.8, 0], dimension=3, groundConstraintsStart=[True] * 3 + [False] * 3
    )
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(100, [0.1] * 3), referencePosition=[0, -1.8, 0], gravity=GRAVITY
    )
    hook(mbs, cable["nodes"][-1], mbs.AddMarker(MarkerBodyPosition(bodyNumber=body)))
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    mbs.AddLoad(LoadForceVector(markerNumber=tip, loadVector=[0, -0.5, 0]))
    mbs.Assemble()
    forces = CableForces(mbs, cable, [0.0, 0.9, 1.8])
    weight = 9.81 * (0.1 + 0.0348 * np.array([1.8, 0.9, 0.0])) + 0.5
    np.testing.assert_allclose(forces["tension"], weight, rtol=1e-9)
    np.testing.assert_allclose(forces["multiplierTension"].mean(), weight[1], rtol=1e-9)
    before = np.asarray(mbs.systemData.GetSystemState()[0]), mbs.systemData.GetTime()
    solve(mbs, 0.01)
    np.testing.assert_allclose(CableForces(mbs, cable, [0.9])["tension"], weight[1], rtol=1e-6)
    np.testing.assert_allclose(mbs.systemData.GetSystemState()[0], before[0], atol=1e-9)


def test_changes_by_a_post_step_function_are_taken_over(mbs, add_pendulum, add_sensor, solve):
    """A ball that a user function throws back at t = 0.1 s is where it must be at 0.2 s."""
    add_pendulum(mbs)
    ball = mbs.CreateMassPoint(
        mass=1.0, referencePosition=[0, 0, 0], initialVelocity=[1, 0, 0], returnDict=True
    )

    def throw_back(mbs, t):
        if abs(t - 0.1) < 1e-9:
            v = mbs.systemData.GetODE2Coordinates_t()
            v[place] = -2.0
            mbs.systemData.SetODE2Coordinates_t(v)
        return True

    mbs.Assemble()
    place = mbs.GetNodeODE2Index(ball["nodeNumber"])
    mbs.SetPostStepUserFunction(throw_back)
    solve(mbs, 0.2, steps=100, stepSize=2e-3)
    assert mbs.systemData.GetODE2Coordinates()[place] == pytest.approx(-0.1)


def test_a_coupled_run_leaves_the_cable_refusing_other_solvers(with_brick):
    _, _, mbs = with_brick()
    with pytest.raises(exudyn.ModelError, match="does not enforce inextensibility"), silence():
        mbs.SolveDynamic(quiet_settings(0.01, 10))


def test_a_diverging_run_keeps_the_last_good_state_and_the_cable(mbs, add_pendulum, solve):
    cable = add_pendulum(mbs)
    mbs.CreateMassPoint(mass=1.0, referencePosition=[0, 0, 0])
    load_node(
        mbs, cable["nodes"][2], [0, 1, 0], loadVectorUserFunction=lambda mbs, t, f: [0, np.exp(90 * t), 0]
    )
    mbs.Assemble()
    with pytest.raises(DivergenceError, match=r"diverged before t = 0\.\d+ s.*reduce stepSize"):
        solve(mbs, 1.0, steps=100, integrator="Zhai")
    assert np.isfinite(mbs.systemData.GetODE2Coordinates()).all()
    assert find_cable_item(mbs.GetObject(cable["elements"][0])).nodes == tuple(map(int, cable["nodes"]))
