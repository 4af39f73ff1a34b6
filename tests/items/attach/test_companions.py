"""Companions: sensors, loads and springs at any arc length, at no cost where nothing acts on them."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CartesianSpringDamper,
    GenericJoint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodePosition,
    NodeRigidBody2D,
    ObjectRigidBody2D,
    SensorBody,
    SensorMarker,
    SphericalJoint,
    SpringDamper,
)

import exudyn_inext
from exudyn_inext import AddMarkerOnCable, CableShape, CreateCompanionCables, InputError
from exudyn_inext.exudyn_binding.scene import read_scene
from tests.cables import hermite
from tests.exudyn_binding.items import SECTION, load_node, native_cable, solve_native, trajectory

FORCE = [0.0, 0.2, 0.0]  # [N]
POSITION = exudyn.OutputVariableType.Position


def point_of_curve(q, length, x):
    """Position at x within elements of that length, from the interpolation conditions."""
    k = min(int(x // length), len(q) - 2)
    weights = np.array([p(x - k * length) for p in hermite(length)])
    return weights @ np.concatenate([q[k], q[k + 1]])


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("arc_length", [0.0, 0.3, 0.36, 1.13, 1.8])
def test_marker_is_on_the_curve_at_its_arc_length(mbs, add_cable, coordinates, dim, arc_length):
    cable = add_cable(mbs, dimension=dim)
    marker = AddMarkerOnCable(mbs, cable, arc_length)
    mbs.Assemble()
    size = mbs.systemData.ODE2Size()
    mbs.systemData.SetODE2Coordinates(np.random.default_rng(1).uniform(-0.3, 0.3, size))
    expected = point_of_curve(coordinates(mbs, cable["nodes"]), 0.36, arc_length)
    np.testing.assert_allclose(mbs.GetMarkerOutput(marker, POSITION)[:dim], expected, atol=1e-13)


def test_last_companion_of_a_ring_leads_back_to_the_first_node(mbs, add_cable, coordinates):
    ring = add_cable(mbs, shape=CableShape.Circle([0, 0], 0.5, 8))
    length = np.pi / 8
    marker = AddMarkerOnCable(mbs, ring, 7.4 * length)
    mbs.Assemble()
    q = coordinates(mbs, ring["nodes"])
    expected = point_of_curve(np.concatenate([q, q[:1]]), length, 7.4 * length)
    np.testing.assert_allclose(mbs.GetMarkerOutput(marker, POSITION)[:2], expected, atol=1e-13)


def test_a_cable_has_one_set_of_companions(mbs, add_pendulum):
    cable, other = add_pendulum(mbs), add_pendulum(mbs)
    first = CreateCompanionCables(mbs, cable)
    AddMarkerOnCable(mbs, cable, 0.5)
    assert CreateCompanionCables(mbs, cable) == first
    assert not set(CreateCompanionCables(mbs, other)) & set(first)


def test_companions_that_nothing_acts_on_change_neither_motion_nor_path(twin, solve):
    plain, watched = twin(), twin()
    elements = CreateCompanionCables(watched.mbs, watched.cable)
    sensor = SensorBody(bodyNumber=elements[-1], localPosition=[0.36, 0, 0], storeInternal=True)
    sensor.outputVariableType = exudyn.OutputVariableType.Velocity
    velocity = watched.mbs.AddSensor(sensor)
    watched.mbs.Assemble()
    assert not read_scene(watched.mbs).foreign
    reports = [solve(case.mbs, 0.3) for case in (plain, watched)]
    assert reports[0]["path"] == reports[1]["path"]
    np.testing.assert_array_equal(trajectory(plain.mbs, plain.tip), trajectory(watched.mbs, watched.tip))
    final = watched.mbs.GetNodeOutput(watched.cable["nodes"][-1], exudyn.OutputVariableType.Velocity)
    np.testing.assert_allclose(trajectory(watched.mbs, velocity)[-1, 1:], final, atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_curvature_is_that_of_the_curve(mbs, add_cable, coordinates, dim):
    """r_x x r_xx / |r_x|^2, as native cables measure it."""
    ring = add_cable(mbs, shape=CableShape.Circle([0, 0], 0.5, 8), dimension=dim)
    elements, length = CreateCompanionCables(mbs, ring), np.pi / 8
    mbs.Assemble()
    nodal = coordinates(mbs, ring["nodes"])[3:5].reshape(4, dim)
    r_x, r_xx = (np.array([p.deriv(k)(0.1) for p in hermite(length)]) @ nodal for k in (1, 2))
    expected = (r_x[0] * r_xx[1] - r_x[1] * r_xx[0]) / (r_x @ r_x)
    kind = exudyn.OutputVariableType.CurvatureLocal
    found = np.ravel(mbs.GetObjectOutputBody(elements[3], kind, [0.1, 0, 0]))[-1]
    assert found == pytest.approx(expected, rel=1e-12)
    assert found == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize(
    ("kind", "what"),
    [
        ("ForceLocal", "Force"),
        ("TorqueLocal", "Force"),
        ("KineticEnergy", "Energy"),
        ("PotentialEnergy", "Energy"),
    ],
)
def test_sensor_of_what_a_companion_lacks_is_warned_of(mbs, add_pendulum, solve, kind, what):
    sensor = SensorBody(bodyNumber=CreateCompanionCables(mbs, add_pendulum(mbs))[2], storeInternal=True)
    sensor.outputVariableType = getattr(exudyn.OutputVariableType, kind)
    mbs.AddSensor(sensor)
    mbs.Assemble()
    with pytest.warns(UserWarning, match=rf"sensor 0 .*{kind} of object 5, .* Use CreateCable{what}Sensor"):
        solve(mbs, 0.01)


def test_sensors_of_the_same_output_are_warned_of_together(mbs, add_pendulum, solve):
    for body in CreateCompanionCables(mbs, add_pendulum(mbs)):
        mbs.AddSensor(SensorBody(bodyNumber=body, outputVariableType=exudyn.OutputVariableType.ForceLocal))
    mbs.Assemble()
    with pytest.warns(UserWarning, match=r"sensor 0 .* it is zero, as are 4 other sensors\. Use") as found:
        solve(mbs)
    assert len(found) == 1


def tip_with_force(mbs, add_pendulum, add_sensor, solve, attach, **changes):
    """Trajectory of the tip, with a step that resolves both meshes; `attach` adds a force."""
    cable = add_pendulum(mbs, **changes)
    attach(mbs, cable)
    sensor = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    solve(mbs, 0.3, stepSize=1e-4)
    return trajectory(mbs, sensor)[:, 1:]


def push_within(mbs, cable):
    """In the middle of an element of 12 elements, on a node of 24."""
    marker = AddMarkerOnCable(mbs, cable, 1.275)
    mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=FORCE))


def test_force_within_an_element_moves_the_cable_as_on_a_node_of_another_mesh(
    new_mbs, add_pendulum, add_sensor, solve
):
    def on_node(mbs, cable):
        load_node(mbs, cable["nodes"][17], FORCE)

    tools = add_pendulum, add_sensor, solve
    expected = tip_with_force(new_mbs(), *tools, on_node, numberOfElements=24)
    found = tip_with_force(new_mbs(), *tools, push_within, numberOfElements=12)
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.ptp(expected[:, 1]))
    unloaded = tip_with_force(new_mbs(), *tools, lambda *_: None, numberOfElements=12)
    assert np.abs(unloaded - expected).max() > 0.1 * np.ptp(expected[:, 1])


def test_force_within_an_element_in_space_acts_as_in_the_plane(new_mbs, add_pendulum, add_sensor, solve):
    tools = add_pendulum, add_sensor, solve
    held = {"dimension": 3, "groundConstraintsStart": [True] * 3 + [False] * 3}
    expected = tip_with_force(new_mbs(), *tools, push_within)
    found = tip_with_force(new_mbs(), *tools, push_within, **held)
    np.testing.assert_allclose(found, expected, atol=1e-8)


def test_spring_within_an_element_is_that_on_a_native_cable(new_mbs, add_pendulum, solve):
    def spring(mbs, marker):
        ground = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround(referencePosition=[1, 0.5, 0])))
        rest = {"stiffness": 5.0, "damping": 0.05, "referenceLength": 0.4}
        mbs.AddObject(SpringDamper(markerNumbers=[ground, marker], **rest))
        return mbs.AddSensor(
            SensorMarker(markerNumber=marker, outputVariableType=POSITION, storeInternal=True)
        )

    ours, native = new_mbs(), new_mbs()
    sensor = spring(ours, AddMarkerOnCable(ours, add_pendulum(ours, numberOfElements=18), 1.05))
    ours.Assemble()
    solve(ours, 0.4)
    held = {"groundConstraintsStart": [True, True, False, False]}
    elements = native_cable(native, 2, 36, section=SECTION, **held)["elements"]
    at = MarkerBodyPosition(bodyNumber=elements[20], localPosition=[0.05, 0, 0])
    expected = spring(native, native.AddMarker(at))
    native.Assemble()
    solve_native(native, 0.4)
    found, expected = (trajectory(*pair)[:, 1:] for pair in ((ours, sensor), (native, expected)))
    np.testing.assert_allclose(found, expected, atol=1e-2 * np.ptp(expected[:, 1]))


@pytest.mark.parametrize("dim", [2, 3])
def test_a_spring_at_rest_moves_nothing_until_a_load_sets_in(mbs, add_cable, add_sensor, solve, dim):
    """Its round-off is no motion, and no reason to leave compiled code."""
    held = [True] * dim + [False] * dim
    cable = add_cable(mbs, gravity=[0, 0, 0], groundConstraintsStart=held, dimension=dim)
    anchor = MarkerBodyPosition(bodyNumber=mbs.CreateGround(), localPosition=[1.13, 0, 0])
    markers = [mbs.AddMarker(anchor), AddMarkerOnCable(mbs, cable, 1.13)]
    mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, stiffness=[1e5, 1e5, 1e5]))

    def late(mbs, t, load):
        return [0, 0.1 * (t > 0.1), 0]

    load_node(mbs, cable["nodes"][-1], [0, 0, 0], loadVectorUserFunction=late)
    tip = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    report = solve(mbs, 0.2, steps=20)
    y = trajectory(mbs, tip)[:, 2]
    assert "in one compiled call" in report["path"] and report["rejections"] == 0
    assert np.abs(y[:11]).max() < 1e-12
    assert y[-1] > 1e-3


def test_body_hinged_within_an_element_swings_as_on_a_native_cable(new_mbs, add_pendulum, add_sensor, solve):
    def hinge(mbs, marker):
        body = mbs.CreateMassPoint(
            mass=0.03, referencePosition=[1.35, 0, 0], gravity=[0, -9.81, 0], create2D=True
        )
        markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=body)), marker]
        mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0]))

    ours, native = new_mbs(), new_mbs()
    cable = add_pendulum(ours, numberOfElements=10)
    hinge(ours, AddMarkerOnCable(ours, cable, 1.35))
    held = {"groundConstraintsStart": [True, True, False, False]}
    twin = native_cable(native, 2, 40, section=SECTION, **held)
    hinge(native, native.AddMarker(MarkerNodePosition(nodeNumber=twin["nodes"][30])))
    found, expected = add_sensor(ours, cable["nodes"][-1]), add_sensor(native, twin["nodes"][-1])
    for mbs in (ours, native):
        mbs.Assemble()
    solve(ours, 0.4)
    solve_native(native, 0.4)
    found, expected = trajectory(ours, found)[:, 1:], trajectory(native, expected)[:, 1:]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.ptp(expected[:, 1]))


def test_bodies_beside_a_cable_swing_as_beside_a_native_one(new_mbs, add_pendulum, add_sensor, solve):
    """A rigid body fixed to an arm, and a mass point hinged to another one."""

    def hang_beside(mbs, arm, hook):
        node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[0.8, -0.1, 0]))
        lamp = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=0.04, inertia=1e-4))
        frame = mbs.AddMarker(MarkerBodyRigid(bodyNumber=lamp))
        mbs.AddLoad(LoadForceVector(markerNumber=frame, loadVector=[0, -9.81 * 0.04, 0]))
        mbs.AddObject(GenericJoint(markerNumbers=[arm, frame], constrainedAxes=[1, 1, 0, 0, 0, 1]))
        point = mbs.CreateMassPoint(mass=0.01, referencePosition=[1.45, 0.08, 0], create2D=True)
        markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=point)), hook]
        mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0]))
        return add_sensor(mbs, node)

    ours, native = new_mbs(), new_mbs()
    cable = add_pendulum(ours, numberOfElements=24)
    arm = AddMarkerOnCable(ours, cable, 0.8, offset=-0.1, hasFrame=True)
    found = hang_beside(ours, arm, AddMarkerOnCable(ours, cable, 1.45, offset=0.08))
    held = {"groundConstraintsStart": [True, True, False, False]}
    elements = native_cable(native, 2, 36, section=SECTION, **held)["elements"]
    arm = MarkerBodyRigid(bodyNumber=elements[16], localPosition=[0, -0.1, 0])
    hook = MarkerBodyPosition(bodyNumber=elements[29], localPosition=[0, 0.08, 0])
    expected = hang_beside(native, native.AddMarker(arm), native.AddMarker(hook))
    for mbs in (ours, native):
        mbs.Assemble()
    assert "in one compiled call" in solve(ours, 0.4)["path"]
    solve_native(native, 0.4, 5e-4)
    found, expected = trajectory(ours, found)[:, 1:], trajectory(native, expected)[:, 1:]
    np.testing.assert_allclose(found, expected, atol=5e-3 * np.ptp(expected[:, 1]))


@pytest.mark.parametrize("beside", [{"offset": 0.1}, {"hasFrame": True}])
def test_points_beside_a_cable_in_space_are_refused(mbs, add_cable, contents, beside):
    cable = add_cable(mbs, dimension=3)
    before = contents(mbs)
    with pytest.raises(InputError, match="a cable in space has no orientation about its axis"):
        AddMarkerOnCable(mbs, cable, 0.5, **beside)
    assert contents(mbs) == before


@pytest.mark.parametrize("arc_length", [-0.1, 1.9, np.nan, "tip"])
def test_a_point_that_is_not_on_the_cable_is_refused(mbs, add_pendulum, contents, arc_length):
    cable = add_pendulum(mbs)
    before = contents(mbs)
    with pytest.raises(InputError, match=r"is not on the cable: it runs from 0 to 1\.8 m"):
        AddMarkerOnCable(mbs, cable, arc_length)
    assert contents(mbs) == before


def test_the_old_name_is_deprecated_for_one_release():
    with pytest.warns(DeprecationWarning, match="MarkerOnCable is deprecated: use AddMarkerOnCable"):
        from exudyn_inext import MarkerOnCable
    assert MarkerOnCable is AddMarkerOnCable
    with pytest.raises(AttributeError, match="has no attribute 'AnotherName'"):
        exudyn_inext.AnotherName  # noqa: B018
