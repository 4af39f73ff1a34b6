"""Native bodies, joints, connectors and states under explicit steps: closed forms and Exudyn's own solver."""

import warnings

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    DistanceConstraint,
    LoadCoordinate,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericODE1,
    NodePointGround,
    ObjectGenericODE1,
    SensorMarker,
    SensorNode,
    SensorObject,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid
from scipy.linalg import expm

from exudyn_inext import (
    CreatePrescribedMotion,
    DivergenceError,
    InextensibleCable,
    RedundantConstraintError,
    SolveExplicit,
)
from exudyn_inext.integrators import INTEGRATORS
from exudyn_inext.native.joint_items import read_joints
from exudyn_inext.scene.joints import JointSolve
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import that_remembers, trajectory

GRAVITY = [0, -9.81, 0]
ROTATIONS = [exudyn.NodeType.RotationEulerParameters, exudyn.NodeType.RotationRxyz]
every_integrator = pytest.mark.parametrize("integrator", INTEGRATORS, ids=str)


def hang_brick(mbs, rotation, rate=1.0):
    """A brick on a spherical joint that starts tumbling; returns its node, and the marker at the joint."""
    angular_velocity = rate * np.array([3.0, 1.0, 2.0])
    body = mbs.CreateRigidBody(
        inertia=InertiaCuboid(100, [0.2, 0.05, 0.1]),
        referencePosition=[0.1, 0, 0],
        initialAngularVelocity=angular_velocity.tolist(),
        initialVelocity=np.cross(angular_velocity, [0.1, 0, 0]).tolist(),
        gravity=GRAVITY,
        nodeType=rotation,
        returnDict=True,
    )
    hook = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body["bodyNumber"], localPosition=[-0.1, 0, 0]))
    ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround()))
    mbs.AddObject(SphericalJoint(markerNumbers=[ground, hook]))
    return body["nodeNumber"], hook


def rigid_pendulum(mbs, add_sensor, rotation):
    """The brick of `hang_brick`; returns the sensor of its centre."""
    sensor = add_sensor(mbs, hang_brick(mbs, rotation)[0])
    mbs.Assemble()
    return sensor


@pytest.fixture
def tumbling(new_mbs, add_sensor, solve):
    """(rotation, integrator, h) -> centre of the tumbling brick every 0.05 s; Exudyn's own without h."""

    def run(rotation, integrator=None, h=None):
        mbs = new_mbs()
        sensor = rigid_pendulum(mbs, add_sensor, rotation)
        settings = quiet_settings(0.5, 10)
        settings.solution.sensors.writePeriod = 0.05
        if h is not None:
            solve(mbs, settings=settings, integrator=integrator, stepSize=h)
        else:
            settings.timeIntegration.numberOfSteps = 5000
            with silence():
                mbs.SolveDynamic(settings)
        return trajectory(mbs, sensor)

    return run


@pytest.mark.parametrize("rotation", ROTATIONS, ids=["EulerParameters", "Rxyz"])
def test_a_tumbling_body_moves_as_with_the_native_implicit_solver(tumbling, rotation):
    native = tumbling(rotation)
    assert np.ptp(native[:, 1:], axis=0).min() > 0.04
    for integrator, tolerance in (("RATTLE", 2e-5), ("Zhai", 3e-5), ("RK4", 5e-6)):
        np.testing.assert_allclose(tumbling(rotation, integrator, 5e-4), native, atol=tolerance)


@every_integrator
@pytest.mark.parametrize("rotation", ROTATIONS, ids=["EulerParameters", "Rxyz"])
def test_energy_of_a_tumbling_body_is_accounted_for(mbs, add_sensor, solve, rotation, integrator):
    """With Rxyz, its mass matrix changes so that 8 % of the energy would be missing without that account."""
    rigid_pendulum(mbs, add_sensor, rotation)
    drift = solve(mbs, settings=quiet_settings(0.5, 10), integrator=integrator, stepSize=1e-3)["drift"]
    assert drift["energyGain"] < 1e-3 and drift["energyLoss"] < 1e-3


@pytest.fixture
def whirl(mbs, solve):
    """(rate, settings) -> report and largest gap [m] of a brick that whirls on a joint for 5 s."""

    def run(rate, **settings):
        _, hook = hang_brick(mbs, exudyn.NodeType.RotationEulerParameters, rate)
        gap = mbs.AddSensor(
            SensorMarker(
                markerNumber=hook, outputVariableType=exudyn.OutputVariableType.Position, storeInternal=True
            )
        )
        mbs.Assemble()
        report = solve(mbs, settings=quiet_settings(5.0, 500), stepSize=2e-3, **settings)
        return report, np.abs(mbs.GetSensorStoredData(gap)[:, 1:]).max()

    return run


@every_integrator
def test_the_largest_gap_of_a_joint_is_reported(whirl, integrator):
    report, gap = whirl(1.0, integrator=integrator)
    assert 0.2 * gap < report["drift"]["constraints"] < 1.05 * gap


def test_a_run_whose_joint_opens_is_stopped_before_it_is_handed_out(mbs, whirl, fault):
    loose = {"integrator": "Zhai", "stabilizationRate": 0.01, "energyTolerance": np.inf}
    with pytest.raises(DivergenceError, match=r"another constraint is violated by .* \(limit 0.05\)"):
        whirl(10.0, **loose)
    gap = np.abs(mbs.GetSensorStoredData(0)[:, 1:]).max()
    assert gap < 0.05
    fault("a joint that opens", f"stopped with a gap of {gap:.2g} m in the outputs (limit 0.05)")


def test_joints_that_cannot_be_solved_for_in_mid_run_leave_the_last_good_output(
    by_exudyn, whirl, mbs, monkeypatch, fault
):
    factorise = JointSolve.factorise

    def fail_at_last(self):
        if mbs.systemData.GetTime() > 1.8:
            raise RedundantConstraintError("joint 7 is not independent: remove it.")
        factorise(self)

    monkeypatch.setattr(JointSolve, "factorise", fail_at_last)
    said = r"before t = \d\.\d+ s.* joint 7 .* remove it\. .* reduce stepSize\. .* last good output"
    with pytest.raises(DivergenceError, match=said):
        whirl(1.0, integrator="RATTLE")
    last = mbs.GetSensorStoredData(0)[-1, 0]
    assert last == pytest.approx(1.8)
    fault("joints that cannot be solved for in mid-run", f"stopped, outputs until {last:.4g} s are kept")


@every_integrator
def test_order_of_convergence_of_a_tumbling_body(tumbling, integrator):
    coarse, middle, fine = (
        tumbling(exudyn.NodeType.RotationEulerParameters, integrator, h)[:, 1:] for h in (4e-3, 2e-3, 1e-3)
    )
    ratio = np.abs(coarse - middle).max() / np.abs(middle - fine).max()
    assert np.log2(ratio) == pytest.approx(INTEGRATORS[integrator].order, abs=0.35)


def driven_point(mbs, stiffness=0.0, damping=0.0, force=None, **functions):
    """A mass point of 2 kg that moves along x, between a spring, a damper, and a force."""
    point = mbs.CreateMassPoint(mass=2.0, referencePosition=[0, 0, 0], returnDict=True)
    ground = mbs.CreateGround()
    law = {"stiffness": [stiffness] * 3, "damping": [damping] * 3}
    mbs.CreateCartesianSpringDamper(itemNumbers=[ground, point["bodyNumber"]], **law, **functions)
    if force is not None:
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=point["nodeNumber"], coordinate=0))
        mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=1.0, loadUserFunction=force))
    return point["nodeNumber"]


def tie_to_the_cable(mbs, cable, node, name="tie"):
    """A mass point at the cable's last node, 1.8 m from the first one."""
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    point = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    return mbs.AddObject(SphericalJoint(markerNumbers=[tip, point], name=name))


@every_integrator
def test_a_force_in_time_is_evaluated_where_the_scheme_needs_it(
    mbs, add_sensor, add_pendulum, solve, integrator
):
    """m x'' = sin(5 t) beside a cable: x = t / (5 m) - sin(5 t) / (25 m)."""
    add_pendulum(mbs)
    node = driven_point(mbs, force=lambda mbs, t, load: np.sin(5 * t))
    sensor = add_sensor(mbs, node)
    mbs.Assemble()
    solve(mbs, 0.5, integrator=integrator, stepSize=1e-3)
    found = trajectory(mbs, sensor)
    exact = found[:, 0] / 10 - np.sin(5 * found[:, 0]) / 50
    tolerance = 1e-6 if INTEGRATORS[integrator].order == 2 else 1e-10
    np.testing.assert_allclose(found[:, 1], exact, atol=tolerance)


@pytest.fixture
def oscillator(new_mbs, add_sensor, add_pendulum, solve):
    """(h, ...) -> report and motion x(t) of m = 2, k = 5e4, d = 60: w = 158 rad/s, above the cable's."""

    def run(h, end_time=0.2, functions=None, **explicit):
        mbs = new_mbs()
        add_pendulum(mbs, numberOfElements=2)
        node = driven_point(mbs, stiffness=5e4, damping=60.0, **(functions or {}))
        mbs.SetNodeParameter(node, "initialCoordinates", [0.01, 0, 0])
        sensor = add_sensor(mbs, node)
        mbs.Assemble()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of a step above the limit
            settings = quiet_settings(end_time, 1)
            settings.solution.sensors.writePeriod = h
            report = solve(mbs, settings=settings, stepSize=h, allowUnstableStep=True, **explicit)
        return report, trajectory(mbs, sensor)[:, :2].T

    return run


def test_spring_and_damper_decay_as_they_must(oscillator):
    report, (t, x) = oscillator(2e-4)
    frequency, decay = np.sqrt(5e4 / 2), 60.0 / 4
    assert report["bounds"].largest_frequency == pytest.approx(frequency, rel=1e-3)
    damped = np.sqrt(frequency**2 - decay**2)
    exact = 0.01 * np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))
    np.testing.assert_allclose(x, exact, atol=3e-5)


def test_the_stability_limit_counts_spring_and_damper(oscillator):
    """Of a spring that Exudyn evaluates. Nobody looks at the energy; otherwise such steps are rejected."""

    def law(mbs, t, number, stretch, speed, stiffness, damping, offset):
        forces = zip(stiffness, stretch, damping, speed, strict=True)
        return [k * x + d * v for k, x, d, v in forces]

    given = {"functions": {"springForceUserFunction": that_remembers(law)}}
    limit = oscillator(1e-3, 1e-3, **given)[0]["bounds"].stability_limit
    steps = [share * limit for share in (0.97, 1.04)]
    runs = (oscillator(h, 100 * h, energyTolerance=np.inf, **given) for h in steps)
    below, above = (np.abs(path[1][-1]) for _, path in runs)
    assert below < 0.01 < 0.1 < above
    assert oscillator(steps[1], 100 * steps[1], **given)[0]["rejections"] > 0


@every_integrator
def test_first_order_states_are_integrated_with_the_scheme(mbs, add_pendulum, solve, integrator):
    """y' = -2 y beside a cable, observed at t = 0.5; y' is shown, too."""
    add_pendulum(mbs)
    node = mbs.AddNode(
        NodeGenericODE1(referenceCoordinates=[0], initialCoordinates=[3.0], numberOfODE1Coordinates=1)
    )
    mbs.AddObject(ObjectGenericODE1(nodeNumbers=[node], rhsUserFunction=lambda mbs, t, n, y: [-2 * y[0]]))
    mbs.Assemble()
    errors = []
    for h in (2e-3, 1e-3):
        solve(mbs, 0.5, integrator=integrator, stepSize=h)
        (y,) = mbs.systemData.GetODE1Coordinates()
        assert mbs.systemData.GetODE1Coordinates_t() == pytest.approx([-2 * y])
        errors.append(abs(y - 3 * np.exp(-1.0)))
    assert errors[1] < 1e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(INTEGRATORS[integrator].order, abs=0.3)


def test_steps_follow_first_order_states_whose_decay_gets_faster(mbs, add_pendulum, solve):
    """As that of oil in a chamber that shrinks: y oscillated about its rest, without a word."""
    add_pendulum(mbs)
    node = mbs.AddNode(
        NodeGenericODE1(referenceCoordinates=[0], initialCoordinates=[1.5], numberOfODE1Coordinates=1)
    )

    def rate(mbs, t, item, y):
        return [-(300.0 + 1500.0 * t) * np.tanh(y[0] - 1.0)]

    mbs.AddObject(ObjectGenericODE1(nodeNumbers=[node], rhsUserFunction=rate))
    mbs.Assemble()
    solve(mbs, 1.0)
    assert mbs.systemData.GetODE1Coordinates() == pytest.approx([1.0], abs=1e-3)


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_steps_resolve_first_order_states_that_swing_by_themselves(mbs, add_pendulum, solve, damping):
    """As current and charge of a coil and a condenser: 1 % of their range, until they have decayed."""
    w, duration = 150.0, 0.3
    add_pendulum(mbs)
    state = {"referenceCoordinates": [0, 0], "numberOfODE1Coordinates": 2}
    node = mbs.AddNode(NodeGenericODE1(initialCoordinates=[1, 0], **state))
    matrix = np.array([[0, w], [-w, -2 * damping * w]])
    mbs.AddObject(ObjectGenericODE1(nodeNumbers=[node], systemMatrix=matrix))
    kind = exudyn.OutputVariableType.Coordinates
    sensor = mbs.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind))
    mbs.Assemble()
    report = solve(mbs, settings=quiet_settings(duration, 30, 0.01))
    t, *found = np.asarray(mbs.GetSensorStoredData(sensor))[1:].T
    exact = [expm(matrix * time)[:, 0] for time in t]
    assert np.abs(np.transpose(found) - exact).max() < 0.021
    assert report["steps"] < (1.2, 0.55)[damping > 0.0] * w * duration * np.sqrt(5 / 12 * w * duration / 0.02)


def hang_on_a_moved_point(mbs, add_cable, along, **arguments):
    """A mass point whose offset along x follows the time carries a cable; its tip, and markers of that x."""
    cable = add_cable(mbs, **arguments)
    point = mbs.CreateMassPoint(mass=2.0, returnDict=True)["nodeNumber"]
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=point, coordinate=axis)) for axis in range(3)]
    for marker, function in zip(markers, (lambda mbs, t, n, offset: along(t), 0, 0), strict=True):
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker], offsetUserFunction=function))
    pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (cable["nodes"][0], point)]
    mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0]))
    return cable["nodes"][-1], [ground, markers[0]]


def test_a_joint_that_follows_the_time_moves_a_cable_as_a_prescribed_motion_does(
    new_mbs, add_cable, add_sensor, solve
):
    def shake(t):
        return 0.2 * (1 - np.cos(4 * t))

    found = []
    for through_a_body in (True, False):
        mbs = new_mbs()
        if through_a_body:
            tip, _ = hang_on_a_moved_point(mbs, add_cable, shake, numberOfElements=3)
        else:
            cable = add_cable(mbs, numberOfElements=3)
            CreatePrescribedMotion(mbs, cable["nodes"][0], lambda t: [shake(t), 0.0])
            tip = cable["nodes"][-1]
        sensor = add_sensor(mbs, tip)
        mbs.Assemble()
        solve(mbs, 0.5, stepSize=2e-3)
        found.append(trajectory(mbs, sensor))
    assert np.abs(found[0][-1, 1:] - found[0][0, 1:]).max() > 0.5
    np.testing.assert_allclose(found[0], found[1], atol=1e-7)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_a_quick_ramp_from_rest_is_compiled_and_its_work_known(mbs, add_cable, is_compiled):
    """One of fifth order by 0.3 m within 0.1 s: its third derivative jumps where the run begins."""

    def ramp(t):
        x = min(max(t / 0.1, 0.0), 1.0)
        return 0.3 * x**3 * (10 - 15 * x + 6 * x**2)

    section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.02)
    rope = {"numberOfElements": 6, "positionEnd": [0, -1, 0], "beamTemplate": section}
    _, markers = hang_on_a_moved_point(mbs, add_cable, ramp, **rope)
    if not is_compiled:
        law = {"springForceUserFunction": that_remembers(lambda mbs, t, number, way, *_: 1e-3 * way)}
        mbs.AddObject(CoordinateSpringDamper(markerNumbers=markers, **law))
    mbs.Assemble()
    report = SolveExplicit(mbs, quiet_settings(1.0, 100, 0.01))
    assert ("in one compiled call" in report["path"]) == is_compiled
    assert report["drift"]["energyGain"] < 1e-3


def test_a_fast_vibration_of_a_joint_is_compiled(mbs, add_cable):
    """Of 160 Hz: second differences between three places are not those of the function."""
    hang_on_a_moved_point(mbs, add_cable, lambda t: 1e-3 * (1.0 - np.cos(1000.0 * t)), numberOfElements=3)
    mbs.Assemble()
    assert "in one compiled call" in SolveExplicit(mbs, quiet_settings(0.02, 20))["path"]


def test_multipliers_of_joints_are_shown_to_sensors(mbs, add_pendulum, solve):
    """Starting from rest, a cable that hangs straight down holds the weight of what hangs on it."""
    cable = add_pendulum(mbs, positionEnd=[0, -1.8, 0])
    point = mbs.CreateMassPoint(mass=0.5, referencePosition=[0, -2.0, 0], gravity=GRAVITY, returnDict=True)
    pair = [
        mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (cable["nodes"][-1], point["nodeNumber"])
    ]
    rod = mbs.AddObject(DistanceConstraint(markerNumbers=pair, distance=0.2))
    kind = exudyn.OutputVariableType.Force
    sensor = mbs.AddSensor(SensorObject(objectNumber=rod, outputVariableType=kind, storeInternal=True))
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    out_of_plane = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=point["nodeNumber"], coordinate=2))
    mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, out_of_plane]))
    mbs.Assemble()
    solve(mbs, 0.02)
    assert abs(trajectory(mbs, sensor)[-1, 1]) == pytest.approx(0.5 * 9.81, rel=1e-6)


def test_joints_that_count_as_linear_have_a_jacobian_that_never_changes(mbs, add_cable):
    nodes = add_cable(mbs)["nodes"]
    point = mbs.CreateMassPoint(mass=1.0, referencePosition=[1.8, 0, 0], returnDict=True)
    body = mbs.CreateRigidBody(inertia=InertiaCuboid(100, [0.1] * 3), referencePosition=[0, 0, 0])
    tips = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (nodes[0], nodes[-1])]
    knot = mbs.AddMarker(MarkerBodyPosition(bodyNumber=point["bodyNumber"]))
    corner = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[0.05, 0.05, 0]))
    pair = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=1)) for n in nodes[2:4]]
    mbs.AddObject(SphericalJoint(markerNumbers=[tips[1], knot], constrainedAxes=[1, 1, 0]))
    mbs.AddObject(SphericalJoint(markerNumbers=[tips[0], corner], constrainedAxes=[1, 1, 0]))
    mbs.AddObject(CoordinateConstraint(markerNumbers=pair, factor1=2.0))
    mbs.AddObject(DistanceConstraint(markerNumbers=tips, distance=1.8))
    mbs.Assemble()
    joints = read_joints(mbs, [])
    assert [joint.is_linear for joint in joints] == [True, False, True, False]
    before = [joint.jacobian(mbs) for joint in joints]
    rng = np.random.default_rng(0)
    mbs.systemData.SetODE2Coordinates(0.3 * rng.standard_normal(mbs.systemData.ODE2Size()))
    same = [np.array_equal(joint.jacobian(mbs), old) for joint, old in zip(joints, before, strict=True)]
    assert same == [True, False, True, False]
