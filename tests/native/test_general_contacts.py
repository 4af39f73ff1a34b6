"""A general contact that cannot act keeps no scene with Exudyn."""

import numpy as np
import pytest
from exudyn.itemInterface import (
    CoordinateConstraint,
    MarkerNodeCoordinate,
    MarkerNodeRigid,
    NodePointGround,
    NodeRigidBody2D,
    ObjectRigidBody2D,
)

from exudyn_inext.native.known.general_contacts import any_acts

RADIUS = 0.2  # [m]


def add_spheres(mbs, places, held=2):
    """A general contact with spheres on planar bodies, of whose coordinates so many are held; constraints."""
    contact = mbs.AddGeneralContact()
    contact.SetFrictionPairings(np.eye(1))
    contact.SetSearchTreeCellSize(numberOfCells=[4, 4, 1])
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    constraints = []
    for x in places:
        node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[x, 0, 0]))
        mbs.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=1.0, inertia=1.0))
        for axis in range(held):
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))
            constraints.append(mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker])))
        surface = {"radius": RADIUS, "contactStiffness": 1e4, "contactDamping": 1.0}
        contact.AddSphereWithMarker(
            mbs.AddMarker(MarkerNodeRigid(nodeNumber=node)), frictionMaterialIndex=0, **surface
        )
    mbs.Assemble()
    return contact, constraints


@pytest.mark.parametrize(
    "places, held, acts",
    [([0.0], 0, False), ([0.0, 0.5], 2, False), ([0.0, 0.3], 2, True), ([0.0, 0.5], 1, True)],
    ids=["one sphere", "at rest apart", "at rest in contact", "on rails"],
)
def test_spheres_act_unless_they_cannot_meet(new_mbs, places, held, acts):
    mbs = new_mbs()
    add_spheres(mbs, places, held)
    assert any_acts(mbs, frozenset()) is acts


def test_spheres_may_meet_where_a_constraint_is_moved(new_mbs):
    mbs = new_mbs()
    contact, constraints = add_spheres(mbs, [0.0, 0.5])
    moved = {int(constraints[2])}
    assert any_acts(mbs, moved)
    contact.sphereSphereContact = False
    assert not any_acts(mbs, moved)
