"""Contacts that are said to be closed at the start, and are open, do not pull."""

import numpy as np
import pytest
from exudyn.itemInterface import (
    MarkerNodeCoordinate,
    NodeGenericData,
    NodePointGround,
    ObjectContactCoordinate,
)

from exudyn_inext import CreateCompanionCables, CreateInextensibleCable, InextensibleCable
from tests.items.attach.contact import Circle, add_contact, add_frictionless_contact

GRAVITY, END, ELEMENTS = 9.81, 0.05, 4  # [m/s^2], [s]; it falls by 12 mm
STIFFNESS, BELOW = 2e3, 0.05  # of contact [N/m]; from the cable to what it would touch [m]
CIRCLE = Circle(0.2, STIFFNESS, 2.0, 0.2, 1e3, 1.0)


def with_friction(mbs, cable, gap):
    below = mbs.CreateGround(referencePosition=[0, -CIRCLE.radius - BELOW, 0])
    add_contact(mbs, CreateCompanionCables(mbs, cable), CIRCLE, below, gap)


def without_friction(mbs, cable, gap):
    below = mbs.CreateGround(referencePosition=[0, -CIRCLE.radius - BELOW, 0])
    add_frictionless_contact(mbs, CreateCompanionCables(mbs, cable), CIRCLE, below, gap)


def of_coordinates(mbs, cable, gap):
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    for node in cable["nodes"]:
        data = mbs.AddNode(NodeGenericData(initialCoordinates=[gap], numberOfDataCoordinates=1))
        height = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
        mbs.AddObject(
            ObjectContactCoordinate(
                markerNumbers=[ground, height], nodeNumber=data, contactStiffness=STIFFNESS, offset=-BELOW
            )
        )


@pytest.mark.parametrize("gap", [0.0, -0.01])
@pytest.mark.parametrize("add", [with_friction, without_friction, of_coordinates])
def test_a_cable_falls_freely_above_what_it_does_not_touch_yet(new_mbs, solve, add, gap):
    mbs = new_mbs()
    section = InextensibleCable(massPerLength=0.2, bendingStiffness=0.02)
    weight = {"gravity": [0, -GRAVITY, 0]}
    cable = CreateInextensibleCable(mbs, [-0.5, 0, 0], [0.5, 0, 0], ELEMENTS, section, **weight)
    add(mbs, cable, gap)
    mbs.Assemble()
    solve(mbs, END, steps=round(END / 0.001))
    q = np.array(mbs.systemData.GetODE2Coordinates())
    fallen = np.tile([0, -GRAVITY * END**2 / 2, 0, 0], ELEMENTS + 1)
    np.testing.assert_allclose(q, fallen, atol=1e-12)
