"""One item of each kind beside a cable moves as under Exudyn's implicit solver."""

from functools import cache

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateVectorConstraint,
    LoadForceVector,
    MarkerBodiesRelativeRotationCoordinate,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodeCoordinates,
    NodeGenericODE1,
    NodeGenericODE2,
    NodePointGround,
    NodeRigidBody2D,
    ObjectGenericODE1,
    ObjectGenericODE2,
    ObjectKinematicTree,
    ObjectRigidBody2D,
    RevoluteJoint2D,
)
from exudyn.utilities import InertiaCuboid, InertiaCylinder

from reference_models.model import quiet_settings, silence

GRAVITY = [0, -9.81, 0]


def kinematic_tree(mbs):
    """Two links; the mass matrix depends on the configuration."""
    node = mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * 2,
            initialCoordinates=[0.3, -0.4],
            initialCoordinates_t=[1.0, 0.0],
            numberOfODE2Coordinates=2,
        )
    )
    link = InertiaCuboid(1000, [0.3, 0.05, 0.05]).Translated([0.15, 0, 0])
    mbs.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exudyn.JointType.RevoluteZ] * 2,
            linkParents=[-1, 0],
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * 2),
            jointOffsets=exudyn.Vector3DList([[0, 0, 0], [0.3, 0, 0]]),
            linkInertiasCOM=exudyn.Matrix3DList([link.InertiaCOM()] * 2),
            linkCOMs=exudyn.Vector3DList([link.COM()] * 2),
            linkMasses=[link.Mass()] * 2,
            gravity=GRAVITY,
            baseOffset=[0, 0, 0],
        )
    )
    return node


def planar_body_on_a_hinge(mbs):
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[1, 0, 0], initialVelocities=[0, 1.5, 3]))
    body = mbs.AddObject(ObjectRigidBody2D(mass=2, inertia=0.1, nodeNumber=node))
    ground = mbs.CreateGround(referencePosition=[0.5, 0, 0])
    pair = [MarkerBodyRigid(bodyNumber=ground), MarkerBodyRigid(bodyNumber=body, localPosition=[-0.5, 0, 0])]
    mbs.AddObject(RevoluteJoint2D(markerNumbers=[mbs.AddMarker(marker) for marker in pair]))
    centre = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
    mbs.AddLoad(LoadForceVector(markerNumber=centre, loadVector=[0, -19.62, 0]))
    return node


def planar_body_off_its_centre(mbs):
    """Its mass depends on the configuration."""
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[1, 0, 0.5], initialVelocities=[0, 1, 9]))
    body = ObjectRigidBody2D(mass=2, inertia=0.1, centerOfMass=[0.1, 0.05], nodeNumber=node)
    centre = mbs.AddMarker(MarkerBodyPosition(bodyNumber=mbs.AddObject(body)))
    mbs.AddLoad(LoadForceVector(markerNumber=centre, loadVector=[0, -19.62, 0]))
    return node


def rigid(mbs, inertia, **options):
    return mbs.CreateRigidBody(inertia=inertia, returnDict=True, **options)


def body_on_a_torsional_spring(mbs):
    """Its centre of mass lies off the reference point; Tait-Bryan angles."""
    body = rigid(
        mbs,
        InertiaCuboid(1000, [0.1, 0.2, 0.3]).Translated([0.05, 0.02, 0]),
        gravity=[0, 0, -9.81],
        initialAngularVelocity=[0, 0, 2],
        nodeType=exudyn.NodeType.RotationRxyz,
    )
    hinge = {"itemNumbers": [mbs.CreateGround(), body["bodyNumber"]], "position": [0] * 3, "axis": [0, 0, 1]}
    mbs.CreateRevoluteJoint(**hinge)
    mbs.CreateTorsionalSpringDamper(**hinge, stiffness=20, damping=0.1)
    return body["nodeNumber"]


def body_on_a_generic_joint(mbs):
    body = rigid(mbs, InertiaCuboid(1000, [0.1, 0.2, 0.3]), referencePosition=[0.1, 0, 0], gravity=GRAVITY)
    mbs.CreateGenericJoint(
        itemNumbers=[mbs.CreateGround(), body["bodyNumber"]],
        position=[0, 0, 0],
        constrainedAxes=[1, 1, 1, 1, 1, 0],
    )
    return body["nodeNumber"]


def disc_that_rolls_by_penalty(mbs, damping=50, zone=0.01):
    disc = rigid(
        mbs,
        InertiaCylinder(1000, 0.02, 0.1, 0),
        referencePosition=[0, 0, 0.1],
        gravity=[0, 0, -9.81],
        initialVelocity=[0, -0.2, 0],
        initialAngularVelocity=[2, 0, 0],
    )
    mbs.CreateRollingDiscPenalty(
        bodyNumbers=[mbs.CreateGround(), disc["bodyNumber"]],
        discRadius=0.1,
        planePosition=[0, 0, 0],
        axisPosition=[0, 0, 0],
        axisVector=[1, 0, 0],
        contactStiffness=1e4,
        contactDamping=damping,
        dryFriction=[0.5, 0.5],
        dryFrictionProportionalZone=zone,
    )
    return disc["nodeNumber"]


def two_coordinates(mbs, reference, **forces):
    """A node with matrices, and what acts on it."""
    start = {"initialCoordinates": [0.1, 0], "initialCoordinates_t": [0, 0]}
    node = mbs.AddNode(
        NodeGenericODE2(referenceCoordinates=[reference, 0], numberOfODE2Coordinates=2, **start)
    )
    mass, stiffness = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([[50.0, -20.0], [-20.0, 30.0]])
    mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=mass, stiffnessMatrix=stiffness, **forces))
    return node


def matrices_and_a_user_function(mbs):
    return two_coordinates(mbs, 0, forceUserFunction=lambda mbs, t, number, q, q_t: [np.sin(9 * t), 0])


def matrices_geared_to_a_mass(mbs):
    """A sum of two coordinates, of matrices that damp and gyrate, follows those of a mass point."""
    damping = np.array([[0.5, 3.0], [-3.0, 0.5]])
    node = two_coordinates(mbs, 0.5, dampingMatrix=damping, forceVector=[0.0, 2.0])
    point = mbs.CreateMassPoint(mass=0.4, referencePosition=[1, 0, 0], gravity=GRAVITY, returnDict=True)
    markers = [mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=n)) for n in (node, point["nodeNumber"])]
    weights = {"scalingMarker0": np.array([[1.0, 0.7]]), "scalingMarker1": np.array([[1.0, 2.0, 0.0]])}
    mbs.AddObject(CoordinateVectorConstraint(markerNumbers=markers, offset=[0.4], **weights))
    return node


def point_on_an_inclined_line(mbs):
    """Both markers of the constraint have coordinates of one node."""
    start = {"referencePosition": [0, 1, 0], "initialVelocity": [0.6, 1.2, 0]}
    point = mbs.CreateMassPoint(mass=0.4, gravity=[3, -9.81, 0], **start, returnDict=True)
    pair = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=point["nodeNumber"], coordinate=k)) for k in (1, 0)]
    mbs.AddObject(CoordinateConstraint(markerNumbers=pair, factor1=2.0))
    return point["nodeNumber"]


def body_that_turns_with_a_function(mbs):
    body = rigid(mbs, InertiaCuboid(1000, [0.1, 0.2, 0.3]), referencePosition=[0.1, 0, 0], gravity=GRAVITY)
    bodies = [mbs.CreateGround(), body["bodyNumber"]]
    mbs.CreateRevoluteJoint(itemNumbers=bodies, position=[0, 0, 0], axis=[0, 0, 1])
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    turn = mbs.AddMarker(MarkerBodiesRelativeRotationCoordinate(bodyNumbers=bodies, axis0=[0, 0, 1]))
    mbs.AddObject(
        CoordinateConstraint(
            markerNumbers=[ground, turn],
            offsetUserFunction=lambda mbs, t, number, offset: 1.0 - np.cos(9 * t),
            offsetUserFunction_t=lambda mbs, t, number, offset: 9 * np.sin(9 * t),
        )
    )
    return body["nodeNumber"]


ITEMS = [
    kinematic_tree,
    planar_body_on_a_hinge,
    planar_body_off_its_centre,
    body_on_a_torsional_spring,
    body_on_a_generic_joint,
    disc_that_rolls_by_penalty,
    matrices_and_a_user_function,
    matrices_geared_to_a_mass,
    point_on_an_inclined_line,
    body_that_turns_with_a_function,
]


@pytest.mark.parametrize("add", ITEMS, ids=lambda add: add.__name__)
def test_it_moves_so_by_exudyns_own_evaluation(by_exudyn, new_mbs, add_pendulum, solve, add):
    test_it_moves_as_under_the_implicit_solver(new_mbs, add_pendulum, solve, add)


@pytest.mark.parametrize("add", ITEMS, ids=lambda add: add.__name__)
def test_it_moves_as_under_the_implicit_solver(new_mbs, add_pendulum, solve, add):
    mbs = new_mbs()
    node = add(mbs)
    add_pendulum(mbs, numberOfElements=2)
    mbs.Assemble()
    solve(mbs, 0.2, stepSize=2e-4)
    found, native = coordinates(mbs, node), native_coordinates(add)
    start = np.zeros(len(found))
    start[: len(mbs.GetNode(node).get("initialCoordinates", []))] = mbs.GetNode(node)["initialCoordinates"]
    assert np.abs(native - start).max() > 0.02
    np.testing.assert_allclose(found, native, atol=1e-5 * max(1.0, np.abs(native).max()))


def coordinates(mbs, node):
    return np.array(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates))


@cache
def native_coordinates(add):
    """Of the item alone, under the implicit solver."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = add(mbs)
    mbs.Assemble()
    with silence():
        mbs.SolveDynamic(quiet_settings(0.2, 2000))
    return coordinates(mbs, node)


def test_automatic_steps_follow_contacts_that_close(new_mbs, add_pendulum, solve):
    """At the start, nothing presses on the ground: neither damping nor friction bounds the step yet."""
    found = []
    for beside_a_cable in (True, False):
        mbs = new_mbs()
        node = disc_that_rolls_by_penalty(mbs, damping=500, zone=0.03)
        if beside_a_cable:
            add_pendulum(mbs, numberOfElements=2)
        mbs.Assemble()
        if beside_a_cable:
            solve(mbs, 0.2, steps=100)
        else:
            with silence():
                mbs.SolveDynamic(quiet_settings(0.2, 4000))
        found.append(np.array(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Velocity)))
    np.testing.assert_allclose(*found, atol=2e-5)  # 6e-4 with steps that only an energy that jumps shortens


def test_the_size_of_states_of_first_order_does_not_matter_to_joints(new_mbs, add_pendulum, solve):
    """In pascals, say; native solvers lose digits of the body to their Newton tolerance."""
    found = []
    for pressure in (0.0, 1e7):
        mbs = new_mbs()
        node = body_on_a_generic_joint(mbs)
        state = {"referenceCoordinates": [0], "initialCoordinates": [pressure], "numberOfODE1Coordinates": 1}
        tank = mbs.AddNode(NodeGenericODE1(**state))
        mbs.AddObject(ObjectGenericODE1(nodeNumbers=[tank], systemMatrix=np.array([[-3.0]])))
        add_pendulum(mbs, numberOfElements=2)
        mbs.Assemble()
        report = solve(mbs, 0.2)
        found.append(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates))
        assert report["rejections"] == 0
    np.testing.assert_allclose(*found, atol=1e-7)
