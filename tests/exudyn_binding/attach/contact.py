"""Circles that cables touch."""

from dataclasses import dataclass

from exudyn.itemInterface import (
    MarkerBodyCable2DShape,
    MarkerBodyRigid,
    NodeGenericData,
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


def add_contact(mbs, elements, circle, body=None):
    """Contact of native ANCF cables with a circle."""
    body = mbs.CreateGround() if body is None else body
    centre = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body))
    apart = [0.1] * SEGMENTS + [-2] * SEGMENTS + [0] * SEGMENTS
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
