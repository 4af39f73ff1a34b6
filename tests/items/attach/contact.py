"""Circles that cables touch."""

from dataclasses import dataclass

import numpy as np
from exudyn.itemInterface import (
    MarkerBodyCable2DShape,
    MarkerBodyRigid,
    NodeGenericData,
    ObjectContactCircleCable2D,
    ObjectContactFrictionCircleCable2D,
)

SEGMENTS = 3


@dataclass(frozen=True)
class Circle:
    """A circle on ground at the origin."""

    radius: float
    stiffness: float
    damping: float
    friction: float
    friction_stiffness: float = 0.0
    friction_damping: float = 0.0


def add_contact(mbs, elements, circle, body=None, gap=0.1):
    """Contact of native ANCF cables with a circle.   gap: what it remembers at the start [m]."""
    body = mbs.CreateGround() if body is None else body
    centre = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))
    apart = [gap] * SEGMENTS + [-2] * SEGMENTS + [0] * SEGMENTS
    for element in elements:
        shape = mbs.AddMarker(MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=SEGMENTS))
        data = mbs.AddNode(NodeGenericData(initialCoordinates=apart, numberOfDataCoordinates=len(apart)))
        mbs.AddObject(
            ObjectContactFrictionCircleCable2D(
                markerNumbers=[centre, shape],
                nodeNumber=data,
                numberOfContactSegments=SEGMENTS,
                contactStiffness=circle.stiffness,
                contactDamping=circle.damping,
                frictionCoefficient=circle.friction,
                frictionStiffness=circle.friction_stiffness,
                frictionVelocityPenalty=circle.friction_damping,
                circleRadius=circle.radius,
                useSegmentNormals=False,
            )
        )


def add_frictionless_contact(mbs, elements, circle, body=None, gap=0.1):
    """The same by the object that knows neither friction nor damping."""
    body = mbs.CreateGround() if body is None else body
    centre = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))
    for element in elements:
        shape = mbs.AddMarker(MarkerBodyCable2DShape(bodyNumber=element, numberOfSegments=SEGMENTS))
        apart = NodeGenericData(initialCoordinates=[gap] * SEGMENTS, numberOfDataCoordinates=SEGMENTS)
        mbs.AddObject(
            ObjectContactCircleCable2D(
                markerNumbers=[centre, shape],
                nodeNumber=mbs.AddNode(apart),
                numberOfContactSegments=SEGMENTS,
                contactStiffness=circle.stiffness,
                circleRadius=circle.radius,
            )
        )


def add_general_contact(mbs, elements, circle, centre=None):
    """The same by Exudyn's contact between many bodies; its friction has a zone of its own."""
    contact = mbs.AddGeneralContact()
    contact.frictionProportionalZone = 0.05
    contact.ancfCableUseExactMethod = False
    contact.ancfCableNumberOfContactSegments = SEGMENTS
    contact.SetSearchTreeCellSize(numberOfCells=[8, 8, 1])
    contact.SetSearchTreeBox(pMin=np.full(3, -1.0), pMax=np.full(3, 1.0))
    springs = {
        "contactStiffness": circle.stiffness,
        "contactDamping": circle.damping,
        "frictionMaterialIndex": 0,
    }
    if centre is None:
        centre = mbs.AddMarker(MarkerBodyRigid(bodyNumber=mbs.CreateGround()))
    contact.AddSphereWithMarker(centre, radius=circle.radius, **springs)
    for element in elements:
        contact.AddANCFCable(objectIndex=element, halfHeight=0.0, **springs)
    contact.SetFrictionPairings(np.array([[circle.friction]]))
