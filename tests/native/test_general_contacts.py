"""A general contact is read as it was given, and one whose spheres cannot meet keeps no scene with Exudyn."""

import numpy as np
import pytest
from exudyn import SimulationSettings, SystemContainer
from exudyn.itemInterface import (
    CoordinateConstraint,
    LoadForceVector,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    MarkerNodeRigid,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectRigidBody2D,
)

from exudyn_inext import CreateInextensibleCable, InextensibleCable, SolveExplicit
from exudyn_inext.native.known.belts import elements_of
from exudyn_inext.native.known.general_contacts import read_general_contacts, spheres_may_meet
from exudyn_inext.native.known.unknown import UnknownItemError
from exudyn_inext.native.native_items import evaluator
from reference_models.model import quiet_settings

RADIUS = 0.2  # [m]
OF_SPHERE = ("radius", "contactStiffness", "contactDamping", "frictionMaterialIndex")


def add_spheres(mbs, places, held=2, finish=True):
    """A general contact with spheres on planar bodies, of whose coordinates so many are held; constraints.

    finish: whether mbs is assembled.
    """
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
    if finish:
        mbs.Assemble()
    return contact, constraints


@pytest.mark.parametrize(
    "places, held, may_meet",
    [
        ([0.0], 0, False),
        ([0.0, 0.5], 2, False),
        ([0.0, 0.3], 2, True),
        ([0.0, 0.5], 1, False),
        ([0.0, 0.3], 1, True),
        ([0.0, 0.5], 0, True),
    ],
    ids=["one sphere", "at rest apart", "at rest in contact", "on rails apart", "on rails", "free"],
)
def test_spheres_meet_unless_what_is_held_keeps_them_apart(new_mbs, places, held, may_meet):
    mbs = new_mbs()
    contact, _ = add_spheres(mbs, places, held)
    assert spheres_may_meet(mbs, contact, frozenset()) is may_meet


def test_spheres_may_meet_where_a_constraint_is_moved(new_mbs):
    mbs = new_mbs()
    contact, constraints = add_spheres(mbs, [0.0, 0.5])
    moved = {int(constraints[2])}
    assert spheres_may_meet(mbs, contact, moved)
    contact.sphereSphereContact = False
    assert not spheres_may_meet(mbs, contact, moved)


def with_cables(mbs, laws):
    """A contact, and what lets Exudyn evaluate it: forces on all coordinates.

    laws: number of an element of an arc, half height, stiffness, damping and material of each.
    """
    angles, length = np.linspace(0.0, 2.0, 5), 0.2
    nodes = [
        mbs.AddNode(
            NodePoint2DSlope1(
                referenceCoordinates=[0.5 * np.sin(x), 0.5 * np.cos(x), np.cos(x), -np.sin(x)],
                initialVelocities=[0.1, -0.2, 0.3, 0.1],
            )
        )
        for x in angles
    ]
    elements = [
        mbs.AddObject(ObjectANCFCable2D(nodeNumbers=nodes[k : k + 2], length=length)) for k in range(4)
    ]
    contact, _ = add_spheres(mbs, [0.3, 0.8], finish=False)
    contact.SetFrictionPairings(np.array([[0.1, 0.0, 0.3], [0.0, 0.2, 0.4], [0.3, 0.4, 0.0]]))
    contact.ancfCableUseExactMethod, contact.ancfCableNumberOfContactSegments = False, 3
    for number, *law in laws:
        contact.AddANCFCable(elements[number], *law)
    mbs.Assemble()
    solver, settings = evaluator(mbs), SimulationSettings()

    def evaluate():
        solver.PostNewton(mbs, settings)
        solver.ComputeODE2RHS(mbs)
        return np.array(solver.GetSystemResidual())

    return contact, sorted((int(elements[number]), *law) for number, *law in laws), evaluate


LAWS = [(2, 0.0, 2e4, 7.0, 1), (0, 3e-3, 1e7, 0.0, 2), (3, 1e-3, 3e3, 900.0, 0)]


def test_what_cables_are_is_found_out_from_their_forces(new_mbs):
    mbs = new_mbs()
    contact, given, evaluate = with_cables(mbs, LAWS)
    before = [contact.GetSphereMarkerBased(k, addData=True) for k in range(2)]
    forces = evaluate()
    found = elements_of(mbs, contact, evaluate)
    np.testing.assert_allclose(found, given, rtol=1e-9, atol=1e-11)
    for k, sphere in enumerate(before):
        now = contact.GetSphereMarkerBased(k, addData=True)
        assert all(sphere[name] == now[name] for name in OF_SPHERE)
    np.testing.assert_array_equal(evaluate(), forces)


@pytest.mark.parametrize(
    "name, value, said",
    [
        ("ancfCableUseExactMethod", True, "ancfCableUseExactMethod"),
        ("keepContactWhilePenetrating", True, "keepContactWhilePenetrating"),
        ("frictionProportionalZone", 0.0, "frictionProportionalZone"),
    ],
)
def test_what_has_no_compiled_form_is_named(new_mbs, name, value, said):
    mbs = new_mbs()
    contact, _, evaluate = with_cables(mbs, LAWS)
    contact.sphereSphereContact = False
    setattr(contact, name, value)
    with pytest.raises(UnknownItemError, match=said):
        read_general_contacts(mbs, None, frozenset(), evaluate)


def test_a_cable_twice_in_a_contact_is_named(new_mbs):
    mbs = new_mbs()
    contact, _, evaluate = with_cables(mbs, [*LAWS, (2, 1e-3, 1e4, 1.0, 0)])
    contact.sphereSphereContact = False
    with pytest.raises(UnknownItemError, match="twice"):
        read_general_contacts(mbs, None, frozenset(), evaluate)


def test_two_contacts_are_named(new_mbs):
    """Exudyn shows the last one, whichever is asked for."""
    mbs = new_mbs()
    _, _, evaluate = with_cables(mbs, LAWS)
    assert mbs.AddGeneralContact().isActive
    with pytest.raises(UnknownItemError, match="more than one"):
        read_general_contacts(mbs, None, frozenset(), evaluate)


@pytest.mark.parametrize("register", ["SetPreStepUserFunction", "SetPostStepUserFunction"])
def test_a_step_function_that_knows_the_contact_keeps_it_with_exudyn(new_mbs, register):
    mbs = new_mbs()
    contact, _, evaluate = with_cables(mbs, LAWS)
    contact.sphereSphereContact = False

    def let_go(mbs, t):
        contact.isActive = t < 0.1
        return True

    getattr(mbs, register)(let_go)
    with pytest.raises(UnknownItemError, match="user function may change"):
        read_general_contacts(mbs, None, frozenset(), evaluate)


def controlled_by_distance(by_steps, is_native=False):
    """(k, 2) height of a falling ball that a force holds back by what a distance sensor shows, and that."""
    mbs = SystemContainer().AddSystem()
    line = {"positionStart": [0, 0, 0], "positionEnd": [1, 0, 0], "numberOfElements": 4}
    enforcement = "algebraic" if is_native else "projection"
    CreateInextensibleCable(mbs, **line, beamTemplate=InextensibleCable(0.3, 0.05), enforcement=enforcement)
    ball = mbs.CreateMassPoint(referencePosition=[1, 1, 0], mass=1.0, gravity=[0, -9.81, 0])
    marker = mbs.AddMarker(MarkerBodyPosition(bodyNumber=ball))
    contact = mbs.AddGeneralContact()
    contact.SetFrictionPairings(np.zeros((1, 1)))
    contact.SetSearchTreeCellSize(numberOfCells=[4, 4, 1])
    contact.AddSphereWithMarker(marker, 0.1, contactStiffness=1e3, contactDamping=1, frictionMaterialIndex=0)
    given = {"positionOrMarker": [1, -5, 0], "dirSensor": [0, 1, 0], "maxDistance": 10}
    distance = mbs.CreateDistanceSensor(0, **given, storeInternal=True, addGraphicsObject=False)

    def force(mbs, t, load):
        return [0, 50 * (5.6 - mbs.GetSensorValues(distance)), 0]

    if by_steps:
        load = mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0]))
        mbs.SetPreStepUserFunction(
            lambda mbs, t: mbs.SetLoadParameter(load, "loadVector", force(mbs, t, 0)) or True
        )
    else:
        mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0], loadVectorUserFunction=force))
    mbs.Assemble()
    settings = quiet_settings(0.3, 300)
    if is_native:
        mbs.SolveDynamic(settings)
    else:
        assert "Exudyn evaluates" not in SolveExplicit(mbs, settings)["path"]
    return np.array(mbs.GetSensorStoredData(distance))[:, 1]


@pytest.mark.parametrize("by_steps", [False, True])
def test_a_controller_sees_the_present_distances_of_a_general_contact(by_steps):
    """They stayed what they were at the start where compiled code moves the scene."""
    ours, native = (controlled_by_distance(by_steps, is_native) for is_native in (False, True))
    assert np.ptp(native) > 0.1
    assert np.abs(ours - native).max() < 0.005 * np.ptp(native)
