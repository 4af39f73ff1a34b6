"""Contact of a planar cable with a circle by Exudyn's own object, which asks for native cables.

Companions lie on the nodes of the cable: native elements without mass and stiffness, which only lend
their shape.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import exudyn.utilities as eu
import numpy as np


@dataclass(frozen=True)
class Surface:
    """How the circle resists; stiffnesses and dampings are for a metre of the cable.

    radius: [m].   friction: coefficient [-].   stiffness, adhesion: normal, tangential [N/m^2].
    damping, viscosity: normal, tangential [N s/m^2].   segments: straight pieces of an element in contact.
    """

    radius: float
    friction: float
    stiffness: float
    damping: float
    adhesion: float
    viscosity: float
    segments: int = 4


def add_circle_contact(
    mbs: Any,
    nodes: Sequence[Any],
    length: float,
    surface: Surface,
    touches: Callable[[float], bool],
    centre: Sequence[float] = (0.0, 0.0, 0.0),
) -> None:
    """Contact of all elements with a circle.

    Args:
        mbs: the system.   nodes: of the cable.   length: of the cable [m].   surface: of the circle.
        touches: arc length [m] -> whether the cable touches there at the start.   centre: of the circle [m].
    """
    circle = mbs.AddMarker(eu.MarkerBodyRigid(bodyNumber=mbs.CreateGround(referencePosition=list(centre))))
    count, segments = len(nodes) - 1, surface.segments
    share = length / count / segments
    for k in range(count):
        companion = eu.Cable2D(massPerLength=0, bendingStiffness=0, axialStiffness=0, length=length / count)
        companion.nodeNumbers = nodes[k : k + 2]
        shape = eu.MarkerBodyCable2DShape(bodyNumber=mbs.AddObject(companion), numberOfSegments=segments)
        gap = -1.0 if touches((k + 0.5) * length / count) else 1.0
        memory = np.repeat([gap, -2.0, 0.0], segments)  # gap, not yet known whether it slips, where it sticks
        state = eu.NodeGenericData(initialCoordinates=memory, numberOfDataCoordinates=len(memory))
        mbs.AddObject(
            eu.ObjectContactFrictionCircleCable2D(
                markerNumbers=[circle, mbs.AddMarker(shape)],
                nodeNumber=mbs.AddNode(state),
                numberOfContactSegments=segments,
                circleRadius=surface.radius,
                contactStiffness=surface.stiffness * share,
                contactDamping=surface.damping * share,
                frictionCoefficient=surface.friction,
                frictionStiffness=surface.adhesion * share,
                frictionVelocityPenalty=surface.viscosity * share,
                useSegmentNormals=False,
            )
        )
