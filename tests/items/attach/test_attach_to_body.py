"""Hinges and clamps between a cable and a body: against native joints, differences and each other."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    GenericJoint,
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    NodeRigidBody2D,
    ObjectRigidBody2D,
    RevoluteJoint2D,
    SphericalJoint,
)
from exudyn.utilities import RigidBodyInertia

from exudyn_inext import AddPointMass, AttachToBody, CableShape, CreateCompanionCables, InputError
from exudyn_inext.items.attach.body_frame import (
    BodyFrame,
    pose_in_plane,
    pose_of_angles,
    pose_of_quaternion,
)
from exudyn_inext.items.attach.clamp_to_body import clamp_derivatives, directions_across, user_functions
from tests.exudyn_binding.items import SECTION, native_cable, solve_native, trajectory

GRAVITY = np.array([0.0, -9.81, 0.0])
MASS, INERTIA, TURNED = 0.05, 4e-4, 0.4
RIM = np.array([0.08, -0.03, 0.0])  # in the frame of the hub
_IN_PLANE = {}  # kind -> tip
AXES = {"EulerParameters": exudyn.NodeType.RotationEulerParameters, "Rxyz": exudyn.NodeType.RotationRxyz}


def about_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def oblique():
    """Some rotation that mixes all axes."""
    q, _ = np.linalg.qr(np.array([[0.6, 0.3, -0.5], [0.2, 0.9, 0.4], [0.7, -0.2, 0.8]]))
    return q * np.sign(np.linalg.det(q))


def hub_in_plane(mbs):
    """A rigid body, turned, free to rotate about its centre of mass at the origin."""
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[0, 0, TURNED]))
    body = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=MASS, inertia=INERTIA))
    markers = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=number)) for number in (mbs.CreateGround(), body)]
    mbs.AddObject(RevoluteJoint2D(markerNumbers=markers))
    return body


def hub_in_space(mbs, rotation, node_type):
    inertia = RigidBodyInertia(mass=MASS, inertiaTensor=INERTIA * np.eye(3))
    turned = rotation @ about_z(TURNED)
    body = mbs.CreateRigidBody(inertia=inertia, referenceRotationMatrix=turned, nodeType=AXES[node_type])
    markers = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=number)) for number in (mbs.CreateGround(), body)]
    mbs.AddObject(SphericalJoint(markerNumbers=markers))
    return body


def line(rotation=np.eye(3)):  # noqa: B008
    """Ends of a horizontal cable of 1 m that starts at the rim."""
    start = about_z(TURNED) @ RIM
    return {
        "positionStart": (rotation @ start).tolist(),
        "positionEnd": (rotation @ (start + np.eye(3)[0])).tolist(),
        "gravity": (rotation @ GRAVITY).tolist(),
    }


@pytest.fixture
def ours_in_plane(new_mbs, add_cable, add_sensor, solve):
    """(kind) -> tip (m, 3) of a cable on the hub, up to 0.5 s; each kind is computed once."""

    def run(kind):
        if kind not in _IN_PLANE:
            _IN_PLANE[kind] = compute(kind)
        return _IN_PLANE[kind]

    def compute(kind):
        mbs = new_mbs()
        hub = hub_in_plane(mbs)
        cable = add_cable(mbs, numberOfElements=10, **line())
        AttachToBody(mbs, cable, "start", hub, RIM, kind)
        tip = add_sensor(mbs, cable["nodes"][-1])
        mbs.Assemble()
        solve(mbs, 0.5)
        return trajectory(mbs, tip)[:, 1:]

    return run


@pytest.mark.parametrize("kind", ["hinge", "clamp"])
def test_cable_on_a_hub_moves_as_a_native_one(new_mbs, ours_in_plane, add_sensor, kind):
    mbs = new_mbs()
    hub = hub_in_plane(mbs)
    cable = native_cable(mbs, 2, 40, section=SECTION, **line())
    rim = exudyn.HT(rotation=about_z(-TURNED), translation=RIM)
    markers = [
        mbs.AddMarker(MarkerBodyRigid(bodyNumber=hub, localHT=rim)),
        mbs.AddMarker(MarkerBodyRigid(bodyNumber=cable["elements"][0])),
    ]
    if kind == "clamp":
        mbs.AddObject(GenericJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0, 0, 0, 1]))
    else:
        mbs.AddObject(RevoluteJoint2D(markerNumbers=markers))
    tip = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    solve_native(mbs, 0.5)
    expected = trajectory(mbs, tip)[:, 1:]
    np.testing.assert_allclose(ours_in_plane(kind), expected, atol=1e-3 * np.ptp(expected[:, 1]))


@pytest.mark.parametrize("node_type", AXES)
@pytest.mark.parametrize("kind", ["hinge", "clamp"])
def test_motion_in_an_oblique_plane_is_that_in_the_plane(
    mbs, ours_in_plane, add_cable, add_sensor, solve, kind, node_type
):
    rotation = oblique()
    hub = hub_in_space(mbs, rotation, node_type)
    cable = add_cable(mbs, numberOfElements=10, dimension=3, **line(rotation))
    AttachToBody(mbs, cable, "start", hub, RIM, kind)
    tip = add_sensor(mbs, cable["nodes"][-1])
    mbs.Assemble()
    solve(mbs, 0.3)
    found = trajectory(mbs, tip)[:, 1:] @ rotation
    expected = ours_in_plane(kind)[: len(found)]
    assert np.ptp(expected[:, 1]) > 0.2
    np.testing.assert_allclose(found, expected, atol=1e-8)


def test_body_hangs_at_the_last_node_as_at_a_native_cable(new_mbs, add_pendulum, add_sensor, solve):
    """Hinge away from the centre of mass; the body's gravity is a load of its own."""

    def add_weight(mbs):
        node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[1.8, -0.1, 0]))
        body = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=MASS, inertia=INERTIA))
        marker = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=GRAVITY.tolist()))
        return node, body

    ours, native = new_mbs(), new_mbs()
    node, body = add_weight(ours)
    cable = add_pendulum(ours, numberOfElements=10)
    AttachToBody(ours, cable, "end", body, [0, 0.1, 0])
    found = add_sensor(ours, node)
    ours.Assemble()
    solve(ours, 0.5)
    node, body = add_weight(native)
    pinned = {"groundConstraintsStart": [True, True, False, False]}
    elements = native_cable(native, 2, 40, section=SECTION, **pinned)["elements"]
    ends = [(body, [0.0, 0.1, 0.0]), (elements[-1], [0.045, 0.0, 0.0])]
    markers = [native.AddMarker(MarkerBodyRigid(bodyNumber=b, localPosition=x)) for b, x in ends]
    native.AddObject(RevoluteJoint2D(markerNumbers=markers))
    expected = add_sensor(native, node)
    native.Assemble()
    solve_native(native, 0.5)
    found, expected = trajectory(ours, found)[:, 1:], trajectory(native, expected)[:, 1:]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.ptp(expected[:, 1]))


@pytest.mark.parametrize(
    ("pose", "coordinates", "dim"),
    [
        (pose_in_plane, [0.3, 0.2, 0.7], 2),
        (pose_of_angles, [0.3, 0.2, 0.1, 0.5, -0.4, 0.9], 3),
        (pose_of_angles, [0.3, 0.2, 0.1, 0.5, -0.4, 0.9], 2),
        (pose_of_quaternion, [0.3, 0.2, 0.1, 0.8, -0.3, 0.5, 0.4], 3),
    ],
)
def test_jacobian_of_the_clamp_is_its_derivative(mbs, pose, coordinates, dim):
    frame = BodyFrame(0, "body", 0, np.array(coordinates), pose)
    across = directions_across(
        np.array([0.6, 0.0, 0.8][:: 1 if dim == 3 else -1]) * [1, 1, dim - 2], frame.orientation(), dim
    )
    value, jacobian = user_functions(clamp_derivatives(frame, across, dim))
    rng = np.random.default_rng(1)
    q = np.concatenate([coordinates, rng.standard_normal(2 * dim)])
    v, step = rng.standard_normal(len(q)), 1e-6
    found = jacobian(mbs, 0.0, 0, q, v, False)
    assert found.shape == (dim - 1, len(q))
    columns = [
        np.subtract(value(mbs, 0.0, 0, q + e, v, False), value(mbs, 0.0, 0, q - e, v, False)) / (2 * step)
        for e in step * np.eye(len(q))
    ]
    np.testing.assert_allclose(found, np.transpose(columns), atol=1e-9)
    np.testing.assert_allclose(value(mbs, 0.0, 0, q, v, True), found @ v, atol=1e-12)


@pytest.mark.parametrize("node_type", AXES)
def test_rotation_of_a_body_is_that_of_exudyn(mbs, node_type):
    inertia = RigidBodyInertia(mass=MASS, inertiaTensor=INERTIA * np.eye(3))
    body = mbs.CreateRigidBody(inertia=inertia, referenceRotationMatrix=oblique(), nodeType=AXES[node_type])
    coordinates = np.array(mbs.GetNode(mbs.GetObject(body)["nodeNumber"])["referenceCoordinates"])
    pose = {"Rxyz": pose_of_angles, "EulerParameters": pose_of_quaternion}[node_type]
    np.testing.assert_allclose(pose(coordinates)[1], oblique(), atol=1e-12)


@pytest.mark.parametrize(("kind", "held"), [("hinge", [1, 1, 0, 0]), ("clamp", [1, 1, 1, 1])])
def test_on_ground_the_node_is_held_without_leaving_the_fastest_path(
    new_mbs, add_cable, coordinates, solve, kind, held
):
    attached, reference = new_mbs(), new_mbs()
    ground = attached.CreateGround(referencePosition=[-1, 0, 0])
    cable = add_cable(attached)
    AttachToBody(attached, cable, "start", ground, [1, 0, 0], kind)
    expected = add_cable(reference, groundConstraintsStart=held)
    reports = []
    for mbs in (attached, reference):
        mbs.Assemble()
        reports.append(solve(mbs, 0.2))
    assert "in one compiled call" in reports[0]["path"]
    found, expected = coordinates(attached, cable["nodes"]), coordinates(reference, expected["nodes"])
    np.testing.assert_array_equal(found, expected)


def test_mass_point_at_the_tip_is_a_point_mass_of_the_cable(new_mbs, add_pendulum, coordinates, solve):
    """By a joint, or within the cable's own mass matrix."""
    joined, own = new_mbs(), new_mbs()
    body = joined.CreateMassPoint(
        mass=0.02, referencePosition=[1.7, 0, 0], gravity=[0, -9.81, 0], create2D=True
    )
    cable, twin = add_pendulum(joined), add_pendulum(own)
    AttachToBody(joined, cable, "end", body, [0.1, 0, 0])
    AddPointMass(own, twin, 1.8, 0.02)
    for mbs in (joined, own):
        mbs.Assemble()
        solve(mbs, 0.4, stepSize=5e-4)
    found, expected = coordinates(joined, cable["nodes"]), coordinates(own, twin["nodes"])
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_cable_hinged_to_a_companion_hangs_at_the_other_cable(mbs, add_pendulum, add_cable, solve):
    upper = add_pendulum(mbs)
    place = {"positionStart": [1.0, 0, 0], "positionEnd": [1.0, -0.9, 0]}
    lower = add_cable(mbs, numberOfElements=3, **place)
    elements = CreateCompanionCables(mbs, upper)
    AttachToBody(mbs, lower, "start", elements[2], [0.28, 0, 0])
    marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=elements[2], localPosition=[0.28, 0, 0]))
    mbs.Assemble()
    solve(mbs, 0.4)
    kind = exudyn.OutputVariableType.Position
    node = mbs.GetNodeOutput(lower["nodes"][0], kind)
    assert np.linalg.norm(node - [1.0, 0.0, 0.0]) > 0.1
    np.testing.assert_allclose(node, mbs.GetMarkerOutput(marker, kind), atol=1e-8)


def test_a_ring_has_no_end_to_attach(mbs, add_cable, contents):
    ring = add_cable(mbs, shape=CableShape.Circle([0, 0], 0.5, 8))
    ground = mbs.CreateGround(referencePosition=[0.5, 0, 0])
    before = contents(mbs)
    with pytest.raises(InputError, match="a closed cable has no ends; join one of its nodes"):
        AttachToBody(mbs, ring, "start", ground)
    assert contents(mbs) == before


@pytest.fixture
def scene(mbs, add_cable):
    """A cable along x from the origin, and bodies there."""
    bodies = {
        "ground": mbs.CreateGround(),
        "hub": hub_in_plane(mbs),
        "point": mbs.CreateMassPoint(mass=1.0, create2D=True),
        "cable": add_cable(mbs),
    }
    return mbs, bodies


@pytest.mark.parametrize(
    ("body", "arguments", "message"),
    [
        ("ground", {"end": "middle"}, "end = 'middle': choose one of .*'start', 'end'"),
        ("ground", {"kind": "glue"}, "kind = 'glue': choose one of .*'hinge', 'clamp'"),
        ("nobody", {}, r"bodyNumber = 99: mbs has objects 0 to \d"),
        (
            "ground",
            {"localPosition": [0.1, 0, 0]},
            r"0\.1 m apart \(limit 1\.8e-06 m.*correct localPosition",
        ),
        ("ground", {"localPosition": [0.1, 0]}, "localPosition = .* must be a vector of 3 numbers"),
        ("hub", {"kind": "clamp", "localDirection": [2, 0, 0]}, r"has length 2: must be a unit vector"),
        ("hub", {"kind": "clamp", "localDirection": [1, 0, 0]}, r"0\.4 rad away .*use \[0\.9210"),
        ("ground", {"localDirection": [1, 0, 0]}, "a hinge has none: leave it out"),
        ("point", {"kind": "clamp"}, "has no orientation that a cable could be clamped to: use kind='hinge'"),
        ("itself", {}, "has no points that a cable could be attached to"),
    ],
)
def test_what_does_not_fit_is_refused(scene, contents, body, arguments, message):
    mbs, bodies = scene
    cable = bodies["cable"]
    number = {"nobody": 99, "itself": cable["elements"][0]}.get(body, bodies.get(body))
    before = contents(mbs)
    with pytest.raises(InputError, match=message):
        AttachToBody(mbs, cable, **({"end": "start", "bodyNumber": number} | arguments))
    assert contents(mbs) == before
