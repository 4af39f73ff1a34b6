"""Scenes that explicit steps cannot take: the culprit is named, and mbs stays as it was."""

import re
from itertools import pairwise

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateVectorConstraint,
    DistanceConstraint,
    LoadForceVector,
    LoadTorqueVector,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinates,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodeGenericODE2,
    NodePoint,
    NodePoint2DSlope1,
    NodePointSlope23,
    NodeRigidBody2D,
    NodeRigidBodyEP,
    ObjectALEANCFCable2D,
    ObjectANCFBeam,
    ObjectANCFCable2D,
    ObjectBeamGeometricallyExact,
    ObjectFFRF,
    ObjectRigidBody2D,
    SphericalJoint,
)
from exudyn.utilities import InertiaCuboid, RigidBodyInertia, RotXYZ2RotationMatrix

from exudyn_inext import (
    AddMarkerOnCable,
    CreateInextensibleCable,
    InextensibleCable,
    RedundantConstraintError,
    SceneError,
)


def mass_point(mbs, position=(1.8, 0, 0)):
    return mbs.CreateMassPoint(mass=1.0, referencePosition=list(position), returnDict=True)["nodeNumber"]


def tied(mbs, nodes, times=1, **options):
    """Mass point at the cable's tip, tied to it so many times."""
    point = mass_point(mbs, **options)
    pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (nodes[-1], point)]
    for k in range(times):
        mbs.AddObject(SphericalJoint(markerNumbers=pair, constrainedAxes=[1, 1, 0], name=f"tie{k}"))


def tied_twice(mbs, nodes):
    tied(mbs, nodes, 2)


def tied_apart(mbs, nodes):
    tied(mbs, nodes, position=(1.8, 0.01, 0))


def tied_at_another_speed(mbs, nodes):
    tied(mbs, nodes)
    mbs.SetNodeParameter(mbs.systemData.NumberOfNodes() - 1, "initialVelocities", [0, 0.02, 0])


def velocity_constraint(mbs, nodes):
    pair = [mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=n)) for n in (nodes[-1], mass_point(mbs))]
    same = {"scalingMarker0": np.eye(2, 4), "scalingMarker1": np.eye(2, 3), "offset": np.zeros(2)}
    mbs.AddObject(CoordinateVectorConstraint(markerNumbers=pair, velocityLevel=True, name="drive", **same))


def rotation_vector(mbs, nodes):
    kind = exudyn.NodeType.RotationRotationVector
    mbs.CreateRigidBody(inertia=InertiaCuboid(1000, [0.1] * 3), nodeType=kind, name="gyro")


def node_without_body(mbs, nodes):
    mbs.AddNode(NodePoint(name="lost"))
    mass_point(mbs)


def node_of_ale_elements(mbs, nodes):
    zero = {"initialCoordinates": [0], "initialCoordinates_t": [0], "referenceCoordinates": [0]}
    mbs.AddNode(NodeGenericODE2(numberOfODE2Coordinates=1, name="flow", **zero))
    mass_point(mbs)


def section():
    beam = exudyn.BeamSection()
    beam.massPerLength, beam.inertia, beam.stiffnessMatrix = 0.3, 1e-4 * np.eye(3), np.diag([300.0] * 6)
    return beam


def beam_of_euler_parameters(mbs, nodes):
    start = [mbs.AddNode(NodeRigidBodyEP(referenceCoordinates=[x, 1, 0, 1, 0, 0, 0])) for x in (0, 0.1)]
    mbs.AddObject(
        ObjectBeamGeometricallyExact(nodeNumbers=start, length=0.1, sectionData=section(), name="boom")
    )


def beam_of_slopes(mbs, nodes):
    at = [[x, 1, 0, 0, 1, 0, 0, 0, 1] for x in (0, 0.1)]
    start = [mbs.AddNode(NodePointSlope23(referenceCoordinates=one)) for one in at]
    mbs.AddObject(ObjectANCFBeam(nodeNumbers=start, length=0.1, sectionData=section(), name="boom"))


def floating_frame_of_a_mesh(mbs, nodes):
    frame = mbs.AddNode(NodeRigidBodyEP(referenceCoordinates=[0, 1, 0, 1, 0, 0, 0]))
    places = np.vstack([np.zeros(3), 0.3 * np.eye(3), 0.3 * np.ones(3)])
    mesh = [mbs.AddNode(NodePoint(referenceCoordinates=place)) for place in places]
    size = 3 * len(mesh)
    mass, stiffness = exudyn.MatrixContainer(0.1 * np.eye(size)), exudyn.MatrixContainer(np.zeros([size] * 2))
    given = {"massMatrixFF": mass, "stiffnessMatrixFF": stiffness, "name": "hull"}
    mbs.AddObject(ObjectFFRF(nodeNumbers=[frame, *mesh], **given))


def pipe_with_flow(mbs, nodes):
    ends = [mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[x, 1, 1, 0])) for x in (0, 0.3)]
    zero = {"initialCoordinates": [0], "initialCoordinates_t": [0], "referenceCoordinates": [0]}
    flow = mbs.AddNode(NodeGenericODE2(numberOfODE2Coordinates=1, **zero))
    section = {"massPerLength": 0.3, "bendingStiffness": 0.02, "axialStiffness": 300, "length": 0.3}
    mbs.AddObject(ObjectALEANCFCable2D(nodeNumbers=[*ends, flow], name="pipe", **section))


def disc_without_inertia(mbs, nodes):
    node = mbs.AddNode(NodeRigidBody2D(name="disc"))
    mbs.AddObject(ObjectRigidBody2D(mass=1.0, inertia=0.0, nodeNumber=node))


def rod_without_inertia_about_its_axis(mbs, nodes):
    inertia = RigidBodyInertia(mass=1.0, inertiaTensor=np.diag([0.0, 0.1, 0.1]))
    mbs.CreateRigidBody(
        inertia=inertia,
        referenceRotationMatrix=RotXYZ2RotationMatrix([0.3, 0.2, 0.1]),
        nodeType=exudyn.NodeType.RotationEulerParameters,
        name="rod",
    )


def beam_on_the_cable(mbs, nodes):
    section = {"massPerLength": 1.0, "bendingStiffness": 1.0, "axialStiffness": 1.0, "length": 0.36}
    mbs.AddObject(ObjectANCFCable2D(nodeNumbers=nodes[:2], name="double", **section))


def rod_of_no_length(mbs, nodes):
    pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=n)) for n in (nodes[-1], mass_point(mbs))]
    mbs.AddObject(DistanceConstraint(markerNumbers=pair, distance=0.1, name="rod"))


def joint_at_rest(mbs, nodes):
    mass_point(mbs)
    grounds = [mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.CreateGround())) for _ in range(2)]
    mbs.AddObject(SphericalJoint(markerNumbers=grounds, name="nowhere"))


def planar_body_on_a_joint_in_space(mbs, nodes):
    body = mbs.CreateRigidBody(inertia=InertiaCuboid(1000, [0.1] * 3), create2D=True)
    pair = [mbs.CreateGround(), body]
    mbs.CreateRevoluteJoint(itemNumbers=pair, position=[0, 5, 0], axis=[0, 0, 1], name="knuckle")


def closed_loop_in_space(mbs, nodes):
    """A body on two hinges with the same axis: five rows each, six coordinates."""
    body = mbs.CreateRigidBody(inertia=InertiaCuboid(1000, [0.1] * 3), referencePosition=[0, 5, 0])
    for z in (-0.1, 0.1):
        mbs.CreateRevoluteJoint(
            itemNumbers=[mbs.CreateGround(), body], position=[0, 5, z], axis=[0, 0, 1], name=f"hinge{z}"
        )
    mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))


REFUSED = [
    (
        tied_apart,
        SceneError,
        r"initial coordinates violate .*'tie0'.*by 0\.01 \(limit 1e-06\).*startTolerance",
    ),
    (tied_twice, RedundantConstraintError, r"'tie1' \(JointSpherical\), equations 0, 1, are not indep"),
    (
        closed_loop_in_space,
        RedundantConstraintError,
        r"'hinge0\.1' \(JointRevoluteZ\), equations 0, 1, 2, 3, 4, are not.*axialStiffness\.$",
    ),
    (
        velocity_constraint,
        SceneError,
        r"'drive' \(ConnectorCoordinateV.* constrains veloc.*velocityLevel=False",
    ),
    (rotation_vector, SceneError, r"node .*\(RigidBodyRotVecLG\).*RotationEulerParameters or RotationRxyz"),
    (node_without_body, SceneError, r"node \d+ 'lost' \(Point\) has coordinates without mass"),
    (node_of_ale_elements, SceneError, r"'flow' \(GenericODE2\) has coordinates without mass.*remove it"),
    (beam_of_euler_parameters, SceneError, r"mass.*'boom' \(BeamGeometrica.*couples.*NodeRigidBodyRxyz\.$"),
    (beam_of_slopes, SceneError, r"'boom' .* singular mass.*BeamGeometricallyExact on NodeRigidBodyRxyz"),
    (floating_frame_of_a_mesh, SceneError, r"'hull' \(FFRF\).*ObjectFFRFreducedOrder"),
    (pipe_with_flow, SceneError, r"'pipe' \(ALEANCFCable2D\) needs a mass.*massMatrix on"),
    (disc_without_inertia, SceneError, r"'disc' \(RigidBody2D\) has coordinates without mass.*inertia"),
    (rod_without_inertia_about_its_axis, SceneError, r"\(RigidBodyEP\) has coordinates without mass"),
    (
        beam_on_the_cable,
        SceneError,
        r"'double' \(ANCFCable2D\) has mass and lies on nodes of an inextensible",
    ),
    (rod_of_no_length, SceneError, r"'rod' \(ConnectorDistance\) cannot be evaluated .*distance"),
    (joint_at_rest, SceneError, r"'nowhere' \(JointSpherical\) has an equation that does not depend on any"),
    (planar_body_on_a_joint_in_space, SceneError, r"'knuckle' .* take an ObjectJointRevolute2D or"),
]


@pytest.mark.parametrize(
    ("add", "error", "message"), REFUSED, ids=lambda value: getattr(value, "__name__", "")
)
def test_the_culprit_is_named(mbs, add_pendulum, solve, contents, add, error, message):
    cable = add_pendulum(mbs)
    add(mbs, cable["nodes"])
    mbs.Assemble()
    before = contents(mbs), mbs.GetObject(cable["elements"][0])["forceUserFunction"]
    with pytest.raises(error, match=message):
        solve(mbs)
    assert contents(mbs) == before[0]
    assert mbs.GetObject(cable["elements"][0])["forceUserFunction"] == before[1]


def four_bar(mbs, add_pendulum, free):
    """Three bodies in space and ground, on four hinges.   free: axes of them, by names."""
    add_pendulum(mbs)
    x, y = np.array([[0, 0, 2, 3], [5, 6, 6.5, 5]])
    middles = np.stack([0.5 * (x[:-1] + x[1:]), 0.5 * (y[:-1] + y[1:]), np.zeros(3)], axis=1)
    inertia = InertiaCuboid(1000, [0.3, 0.1, 0.1])
    bodies = [mbs.CreateRigidBody(inertia=inertia, referencePosition=list(middle)) for middle in middles]
    ground = mbs.CreateGround()
    for k, pair in enumerate(pairwise([ground, *bodies, ground])):
        given = {"itemNumbers": list(pair), "position": [x[k], y[k], 0], "name": f"hinge{k}"}
        if given["name"] in free:
            axes = [int(axis < 5 and axis not in free[given["name"]]) for axis in range(6)]
            mbs.CreateGenericJoint(constrainedAxes=axes, **given)
        else:
            mbs.CreateRevoluteJoint(axis=[0, 0, 1], **given)
    mbs.Assemble()


def test_all_equations_too_many_of_a_closed_loop_are_named_at_once(new_mbs, add_pendulum, solve):
    """Four hinges have 20 equations for 18 coordinates, of which one stays free."""
    mbs = new_mbs()
    four_bar(mbs, add_pendulum, {})
    with pytest.raises(RedundantConstraintError, match="constrainedAxes; CreateGenericJoint") as caught:
        solve(mbs)
    (joint, numbers) = re.search(r"'(hinge\d)' \(.*\), equations (.+), are not", str(caught.value)).groups()
    mbs, free = new_mbs(), [int(number) for number in numbers.split(",")]
    four_bar(mbs, add_pendulum, {joint: free})
    solve(mbs, 0.01)
    assert len(free) == 3


def two_cables(mbs, sag):
    """Between supports 2 m apart, joined in the middle, which hangs by `sag` [m]."""
    section, g = InextensibleCable(massPerLength=0.1, bendingStiffness=1e-3), [0, -9.81, 0]
    pinned, ends = [True, True, False, False], []
    for start, end, side in ([[0, 0, 0], [1, -sag, 0], "Start"], [[1, -sag, 0], [2, 0, 0], "End"]):
        cable = CreateInextensibleCable(
            mbs, start, end, 4, section, gravity=g, **{f"groundConstraints{side}": pinned}
        )
        ends.append(cable["nodes"][0 if side == "End" else -1])
    markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in ends]
    mbs.AddObject(SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0], name="middle"))
    mbs.Assemble()
    return ends[0]


def test_straight_cables_between_held_ends_are_named_and_may_sag_instead(new_mbs, solve):
    mbs = new_mbs()
    two_cables(mbs, 0.0)
    with pytest.raises(
        RedundantConstraintError, match=r"'middle'.*not independent.*'object0', .*'object3'.* here.*sag"
    ):
        solve(mbs)
    mbs = new_mbs()
    middle = two_cables(mbs, 0.05)
    solve(mbs, 0.1)
    x, y, _ = mbs.GetNodeOutput(middle, exudyn.OutputVariableType.Position)
    assert x == pytest.approx(1.0, abs=1e-6)
    assert -0.05 < y < -0.01  # both cables fall, and pull it up


@pytest.mark.parametrize("elements", [2, 3, 8])
@pytest.mark.parametrize("way", [(1, 0, 0), (0, -1, 0), (0.6, 0.8, 0)], ids=str)
@pytest.mark.parametrize("tie", ["joint", "rod"])
def test_what_holds_a_straight_cable_at_its_own_length_is_redundant(mbs, solve, tie, way, elements):
    """A joint to ground at its end, or a rod in line with it; with its axialStiffness it may be held so."""

    def held(axial):
        mbs.Reset()
        section = InextensibleCable(massPerLength=0.3, bendingStiffness=0.02, axialStiffness=axial)
        pinned, end = {"groundConstraintsStart": [True, True, False, False]}, 1.3 * np.array(way)
        cable = CreateInextensibleCable(mbs, [0, 0, 0], list(end), elements, section, **pinned)
        rod = 0.0 if tie == "joint" else 0.5
        anchor = MarkerBodyPosition(
            bodyNumber=mbs.CreateGround(), localPosition=list(end + rod * np.array(way))
        )
        pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1])), mbs.AddMarker(anchor)]
        both = {"markerNumbers": pair}
        if rod:
            mbs.AddObject(DistanceConstraint(**both, distance=rod))
        else:
            mbs.AddObject(SphericalJoint(**both, constrainedAxes=[1, 1, 0]))
        mbs.Assemble()
        solve(mbs, 1e-3)

    with pytest.raises(RedundantConstraintError, match=r"not independent.*axialStiffness"):
        held(None)
    held(1e5)


@pytest.mark.parametrize("bodies", ["beside it", "tied to it"])
@pytest.mark.parametrize("nodes", [(0, -1), (1, 2)], ids=str)
def test_a_rod_along_a_straight_cable_is_named_also_among_bodies(new_mbs, solve, nodes, bodies):
    """Of joints and frequencies it leaves no number; with axialStiffness it may be there."""

    def held(axial):
        mbs = new_mbs()
        section = InextensibleCable(massPerLength=0.1, bendingStiffness=1e-3, axialStiffness=axial)
        pinned = {"groundConstraintsStart": [True, True, False, False]}
        own = CreateInextensibleCable(mbs, [0, 0, 0], [1, 0, 0], 4, section, **pinned)["nodes"]
        pair = [mbs.AddMarker(MarkerNodePosition(nodeNumber=own[node])) for node in nodes]
        apart = 1.0 if nodes[0] == 0 else 0.25
        mbs.AddObject(DistanceConstraint(markerNumbers=pair, distance=apart))
        if bodies == "tied to it":
            tied(mbs, own, position=(1, 0, 0))
        else:
            mass_point(mbs)
        mbs.Assemble()
        solve(mbs, 1e-3)

    first, last = (range(5)[node] for node in nodes)
    says = rf"distance constraint at node {first} and {last} of cable .* not independent .*axialStiffness"
    with pytest.raises(RedundantConstraintError, match=says):
        held(None)
    held(1e4)


@pytest.mark.parametrize(
    ("load", "vector", "said"),
    [
        (LoadForceVector, [1, 2, 3], "z component 3 N"),
        (LoadTorqueVector, [0.1, 0, 3], "x component 0.1 Nm"),
        (LoadTorqueVector, [0, 0.2, 0], "y component 0.2 Nm"),
    ],
)
@pytest.mark.parametrize("at_node", [True, False])
def test_loads_out_of_the_plane_of_a_planar_cable_are_refused(
    mbs, add_pendulum, solve, load, vector, said, at_node
):
    """Those in the plane act: on frames beside nodes, and at nodes."""
    cable = add_pendulum(mbs, gravity=[0, 0, 0])
    at = MarkerNodeRigid(nodeNumber=cable["nodes"][2])
    marker = mbs.AddMarker(at) if at_node else AddMarkerOnCable(mbs, cable, 0.8, hasFrame=True)
    number = mbs.AddLoad(load(markerNumber=marker, loadVector=vector))
    mbs.Assemble()
    with pytest.raises(SceneError, match=rf"{said}.*planar.*dimension=3"):
        solve(mbs, 1e-3)
    in_plane = [vector[0], vector[1], 0] if load is LoadForceVector else [0, 0, 1.0]
    mbs.SetLoadParameter(number, "loadVector", in_plane)
    solve(mbs, 1e-3)
    assert np.abs(mbs.systemData.GetODE2Coordinates()).max() > 1e-7


def test_what_is_tied_at_another_speed_starts_after_an_impulse(mbs, add_pendulum, solve):
    cable = add_pendulum(mbs, gravity=[0, 0, 0])
    tied_at_another_speed(mbs, cable["nodes"])
    mbs.Assemble()
    with pytest.warns(
        UserWarning, match=r"initial velocities violate .*'tie0'.*by -?0\.02 .* J \(-\d\.\d+ %\)"
    ):
        solve(mbs, 1e-6, stepSize=1e-6)
    tip, point = (mbs.GetNodeOutput(n, exudyn.OutputVariableType.Velocity) for n in (5, 7))
    np.testing.assert_allclose(tip[:2], point[:2], atol=1e-9)
    assert 0.019 < point[1] < 0.02  # 1 kg against an end of the cable


def test_a_larger_start_tolerance_projects_what_is_apart(mbs, add_pendulum, solve):
    tied_apart(mbs, add_pendulum(mbs)["nodes"])
    mbs.Assemble()
    correction = solve(mbs, startTolerance=0.02)["startCorrections"][-1]
    assert correction.position > 1e-3
    tip, point = (mbs.GetNodeOutput(n, exudyn.OutputVariableType.Position) for n in (5, 7))
    np.testing.assert_allclose(tip[:2], point[:2], atol=1e-9)
