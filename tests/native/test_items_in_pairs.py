"""An item beside a cable moves as another one that says the same in other words."""

import exudyn
import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    CoordinateSpringDamper,
    GenericJoint,
    LoadCoordinate,
    LoadForceVector,
    LoadMassProportional,
    LoadTorqueVector,
    MarkerBodyCable2DShape,
    MarkerBodyMass,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodeGenericData,
    NodePointGround,
    NodeRigidBody2D,
    ObjectContactCircleCable2D,
    ObjectGenericODE2,
    ObjectRigidBody2D,
    PrismaticJoint2D,
    RevoluteJoint2D,
)
from exudyn.utilities import CreateSymbolicUserFunction

from exudyn_inext import CreateCompanionCables

SYMBOLS = exudyn.symbolic


def coordinate(mbs, node, which):
    return mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=which))


def mass_point(mbs, **changes):
    options = {"mass": 0.05, "referencePosition": [2, 0, 0], "gravity": [0, 9.81, 0], **changes}
    return mbs.CreateMassPoint(**options, returnDict=True)["nodeNumber"]


def spring_of_matrices(mbs, cable, as_matrices):
    """Between the tip and a mass point; its object has no mass."""
    tip, point = cable["nodes"][-1], mass_point(mbs)
    if as_matrices:
        stiffness = np.zeros((7, 7))
        stiffness[np.ix_([1, 5], [1, 5])] = [[20, -20], [-20, 20]]
        mbs.AddObject(ObjectGenericODE2(nodeNumbers=[tip, point], stiffnessMatrix=stiffness))
    else:
        pair = [coordinate(mbs, node, 1) for node in (tip, point)]
        mbs.AddObject(CoordinateSpringDamper(markerNumbers=pair, stiffness=20))


def mass_of_a_sparse_matrix(mbs, cable, as_sparse):
    """On the node of a mass point, whose own mass counts once."""
    point = mass_point(mbs)
    mbs.CreateSpringDamper(
        itemNumbers=[exudyn.NodeIndex(int(node)) for node in (cable["nodes"][-1], point)],
        stiffness=20,
        referenceLength=0.2,
    )
    mass = exudyn.MatrixContainer()
    mass.SetWithDenseMatrix(0.1 * np.eye(3), useDenseMatrix=not as_sparse)
    mbs.AddObject(ObjectGenericODE2(nodeNumbers=[point], massMatrix=mass))


def planar_body(mbs, x, **changes):
    node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[x, 0, 0], **changes))
    body = mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=0.05, inertia=1e-3))
    mbs.AddLoad(
        LoadMassProportional(
            markerNumber=mbs.AddMarker(MarkerBodyMass(bodyNumber=body)), loadVector=[0, -9.81, 0]
        )
    )
    return node, body


def slider_that_turns(mbs, cable, is_prismatic):
    """A body, which a torque turns, with its normal across what joins it to another one at the tip."""
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    (_, first), (_, second) = planar_body(mbs, 1.9), planar_body(mbs, 2.2)
    ends = [
        mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0, 0]))
        for body, x in ((first, -0.1), (first, 0.1), (second, 0.0))
    ]
    mbs.AddObject(RevoluteJoint2D(markerNumbers=[tip, ends[0]]))
    mbs.AddLoad(LoadTorqueVector(markerNumber=ends[2], loadVector=[0, 0, 0.1]))
    if is_prismatic:
        axes = {"axisMarker0": [1, 0, 0], "normalMarker1": [0, 1, 0]}
        mbs.AddObject(PrismaticJoint2D(markerNumbers=ends[1:], constrainRotation=False, **axes))
    else:
        mbs.AddObject(GenericJoint(markerNumbers=ends[:0:-1], constrainedAxes=[0, 1, 0, 0, 0, 0]))


def circle_about_a_point(mbs, cable, is_point):
    """Under the cable, at the node of a body."""
    node, _ = planar_body(mbs, 1.5, initialCoordinates=[0, -0.055, 0], initialVelocities=[0, 1, 0])
    centre = mbs.AddMarker((MarkerNodePosition if is_point else MarkerNodeRigid)(nodeNumber=node))
    for element in CreateCompanionCables(mbs, cable):
        data = mbs.AddNode(NodeGenericData(initialCoordinates=[0.1] * 3, numberOfDataCoordinates=3))
        segments = mbs.AddMarker(MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=3))
        law = {"contactStiffness": 200, "circleRadius": 0.05, "numberOfContactSegments": 3}
        mbs.AddObject(ObjectContactCircleCable2D(markerNumbers=[centre, segments], nodeNumber=data, **law))


def symbolic(mbs, function, name, kind):
    return CreateSymbolicUserFunction(mbs, function, name, itemTypeName=kind)


def load_of_symbols(mbs, cable, is_symbolic):
    def pull(mbs, t, load):
        return load * (SYMBOLS if is_symbolic else np).sin(20 * t)

    given = symbolic(mbs, pull, "loadUserFunction", "LoadCoordinate") if is_symbolic else pull
    tip = coordinate(mbs, cable["nodes"][-1], 1)
    mbs.AddLoad(LoadCoordinate(markerNumber=tip, load=0.5, loadUserFunction=given))
    return given


def force_of_symbols(mbs, cable, is_symbolic):
    def pull(mbs, t, load):
        if is_symbolic:
            return SYMBOLS.Vector([load[0] * SYMBOLS.sin(20 * t), load[1], 0])
        return [load[0] * np.sin(20 * t), load[1], 0]

    given = symbolic(mbs, pull, "loadVectorUserFunction", "LoadForceVector") if is_symbolic else pull
    tip = mbs.AddMarker(MarkerNodePosition(nodeNumber=cable["nodes"][-1]))
    mbs.AddLoad(LoadForceVector(markerNumber=tip, loadVector=[0.5, 0.2, 0], loadVectorUserFunction=given))
    return given


def motion_of_symbols(mbs, cable, is_symbolic):
    """The tip is driven across."""

    def functions(sin, cos):
        return (
            lambda mbs, t, number, offset: offset * (1.0 - cos(9 * t)),
            lambda mbs, t, number, offset: offset * 9 * sin(9 * t),
        )

    given = list(functions(np.sin, np.cos))
    names = ["offsetUserFunction", "offsetUserFunction_t"]
    if is_symbolic:
        pairs = zip(functions(SYMBOLS.sin, SYMBOLS.cos), names, strict=True)
        given = [symbolic(mbs, one, name, "ObjectConnectorCoordinate") for one, name in pairs]
    ground = coordinate(mbs, mbs.AddNode(NodePointGround()), 0)
    pair = [ground, coordinate(mbs, cable["nodes"][-1], 1)]
    options = dict(zip(names, given, strict=True))
    mbs.AddObject(CoordinateConstraint(markerNumbers=pair, offset=0.05, **options))
    return given


PAIRS = [
    spring_of_matrices,
    mass_of_a_sparse_matrix,
    slider_that_turns,
    circle_about_a_point,
    load_of_symbols,
    force_of_symbols,
    motion_of_symbols,
]


@pytest.mark.parametrize("add", PAIRS)
def test_both_move_alike_and_otherwise_than_without(new_mbs, add_pendulum, solve, add):
    def moved(*given):
        mbs = new_mbs()
        cable = add_pendulum(mbs)
        _kept = [add(mbs, cable, which) for which in given]  # symbols live as long as this
        mbs.Assemble()
        solve(mbs, 0.1, stepSize=5e-4)
        return np.array(mbs.systemData.GetODE2Coordinates())

    one, other, without = moved(True), moved(False), moved()
    np.testing.assert_allclose(one, other, atol=1e-8)
    assert np.abs(one[: len(without)] - without).max() > 1e-4
