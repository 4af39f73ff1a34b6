"""Closed belts that touch wheels: compiled, however many there are, and as native ones."""

from dataclasses import replace

import numpy as np
import pytest
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    NodePoint2DSlope1,
    ObjectANCFCable2D,
)

from exudyn_inext import CableShape, CreateCompanionCables, CreateInextensibleCable, InextensibleCable
from tests.exudyn_binding.items import solve_native, trajectory
from tests.items.attach.contact import Circle, add_contact

ELEMENTS, RADIUS, END, GRAVITY = 24, 0.2, 0.07, [0, -9.81, 0]
SECTION = {"massPerLength": 0.1, "bendingStiffness": 0.02, "axialStiffness": 2e3}
WHEEL = Circle(radius=0.19, stiffness=1e4, damping=10.0, friction=0.3, friction_damping=10.0)


def add_native(mbs):
    """A ring about the origin: its nodes and elements."""
    angles = 2 * np.pi * np.arange(ELEMENTS) / ELEMENTS
    nodes = [
        mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[RADIUS * c, RADIUS * s, -s, c]))
        for c, s in zip(np.cos(angles), np.sin(angles), strict=True)
    ]
    length = 2 * np.pi * RADIUS / ELEMENTS
    elements = [
        mbs.AddObject(ObjectANCFCable2D(nodeNumbers=[one, other], length=length, **SECTION))
        for one, other in zip(nodes, [*nodes[1:], nodes[0]], strict=True)
    ]
    for element in elements:
        weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=element))
        mbs.AddLoad(LoadMassProportional(markerNumber=weight, loadVector=GRAVITY))
    return nodes, elements


def add_ours(mbs):
    shape = CableShape.Circle([0, 0, 0], RADIUS, ELEMENTS)
    cable = CreateInextensibleCable(
        mbs, shape=shape, beamTemplate=InextensibleCable(**SECTION), gravity=GRAVITY, extensible=True
    )
    return cable["nodes"], CreateCompanionCables(mbs, cable)


@pytest.fixture
def belts(new_mbs, add_sensor):
    """How to add a belt -> three of them that fall onto wheels, the first of which is softer; sensors."""

    def build(add):
        mbs, sensors = new_mbs(), []
        for share in (0.05, 1.0, 1.0):
            nodes, elements = add(mbs)
            add_contact(mbs, elements, replace(WHEEL, stiffness=share * WHEEL.stiffness))
            sensors.append(add_sensor(mbs, nodes[ELEMENTS // 4]))
        mbs.Assemble()
        return mbs, sensors

    return build


@pytest.mark.filterwarnings("ignore:.*vibrates along its axis faster than the steps resolve")
@pytest.mark.filterwarnings("ignore:.*how it folds depends on its elements")
def test_three_closed_belts_are_compiled_and_fall_as_native_ones(belts, solve):
    (mbs, sensors), (twin, native_sensors) = belts(add_ours), belts(add_native)
    assert "compiled call" in solve(mbs, END)["path"]
    solve_native(twin, END, step=5e-5)
    found, expected = (
        np.array([trajectory(*pair)[-1, 2] - RADIUS for pair in ((system, k) for k in numbers)])
        for system, numbers in ((mbs, sensors), (twin, native_sensors))
    )
    assert abs(expected[0] - expected[1]) > 1e-4
    np.testing.assert_allclose(found, expected, atol=2e-5)
