"""A rope falls onto a wheel by GeneralContact, as a native one does: its stiff damping bounds no step."""

import exudyn
import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import (
    MarkerBodyRigid,
    MarkerNodeRigid,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectGround,
    ObjectRigidBody2D,
    RevoluteJoint2D,
)

from exudyn_inext import CreateCompanionCables, CreateInextensibleCable, SolveExplicit
from reference_models.model import quiet_settings, silence
from tests.exudyn_binding.items import solve_native

RADIUS, HEIGHT, LENGTH, ELEMENTS = 0.3, 1e-3, 1.6, 32  # [m]
STIFFNESS, DAMPING = 1e5, 2e3  # [N/m^2, N s/m^2]
END, STEP = 0.4, 2e-4  # [s]
GRAVITY = [0, -9.81, 0]
SECTION = {"massPerLength": 0.1, "bendingStiffness": 1e-3, "axialStiffness": 1e4, "axialDamping": 1.0}


def build(native):
    """mbs, node at the rope's end, and node of the wheel."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    template = ObjectANCFCable2D(**SECTION)
    start, end = (
        [x, RADIUS + HEIGHT + 2e-3, 0.0] for x in (-0.3 * LENGTH, 0.7 * LENGTH)
    )  # the longer side pulls
    if native:
        cable = GenerateBeamElementsAlongLine(mbs, start, end, ELEMENTS, template, GRAVITY)
        elements = cable["elements"]
    else:
        cable = CreateInextensibleCable(mbs, start, end, ELEMENTS, template, GRAVITY, extensible=True)
        elements = CreateCompanionCables(mbs, cable)
    wheel = mbs.AddNode(NodeRigidBody2D())
    mbs.AddObject(ObjectRigidBody2D(nodeNumber=wheel, mass=0.5, inertia=0.01))
    marker = mbs.AddMarker(MarkerNodeRigid(nodeNumber=wheel))
    ground = mbs.AddMarker(MarkerBodyRigid(bodyNumber=mbs.AddObject(ObjectGround())))
    mbs.AddObject(RevoluteJoint2D(markerNumbers=[ground, marker]))
    contact = mbs.AddGeneralContact()
    contact.ancfCableUseExactMethod, contact.ancfCableNumberOfContactSegments = False, 4
    contact.frictionProportionalZone = 0.1
    contact.SetFrictionPairings(np.array([[0.4]]))
    contact.SetSearchTreeCellSize(numberOfCells=[8, 8, 1])
    contact.AddSphereWithMarker(marker, RADIUS, STIFFNESS, DAMPING, 0)
    for element in elements:
        contact.AddANCFCable(element, HEIGHT, STIFFNESS, DAMPING, 0)
    mbs.Assemble()
    return container, mbs, cable["nodes"][-1], wheel


def seen(mbs, tip, wheel):
    """Place of the tip [m], and turn of the wheel [rad]."""
    place = mbs.GetNodeOutput(tip, exudyn.OutputVariableType.Position)[:2]
    return np.array([*place, mbs.GetNodeOutput(wheel, exudyn.OutputVariableType.Coordinates)[2]])


def test_a_rope_moves_as_a_native_one():
    _ours, mbs, *nodes = build(native=False)
    with silence():
        report = SolveExplicit(mbs, quiet_settings(END, 10))
    assert "in one compiled call" in report["path"]
    resolved = SECTION["massPerLength"] / (2.0 * DAMPING)  # steps that resolve the damping
    assert report["steps"] < END / (2.0 * resolved)
    ours = seen(mbs, *nodes)
    _native, mbs, *nodes = build(native=True)
    solve_native(mbs, END, STEP)
    theirs = seen(mbs, *nodes)
    assert abs(theirs[2]) > 0.1
    np.testing.assert_allclose(ours, theirs, atol=0.01 * RADIUS)
