"""Pins and clamps of native cables: as exact constraints, or as stiff springs.

Exudyn's explicit integrators eliminate a CoordinateConstraint only after the unconstrained solve
for the accelerations, which is wrong for coupled mass matrices such as those of ANCF cables
(pendulum: 1.8e-2 m tip error after 0.5 s, silently). They get springs instead: k = 1e5 N/m holds
the pendulum's pin to 2e-5 m without lowering the stable step.
"""

from typing import Any

import exudyn
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
)

from exudyn_inext.errors import InputError

from ..scenes import Clamp, Pin

PIN_STIFFNESS = 1e5
"""Default spring of a pin [N/m]."""


def add_constraint(mbs: Any, node: int, support: Pin | Clamp, dimension: int) -> None:
    """Hold the position (pin) or position and slope (clamp) exactly; for implicit integrators."""
    ground_node = mbs.AddNode(NodePointGround())
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground_node, coordinate=0))
    held = 2 * dimension if isinstance(support, Clamp) else dimension
    for coordinate in range(held):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))


def add_spring(mbs: Any, node: int, support: Pin | Clamp, stiffness: float) -> None:
    """Hold the position by a spring of that stiffness [N/m]; for explicit integrators."""
    if isinstance(support, Clamp):
        raise InputError(
            f"{support}: a clamp cannot be held by the spring of a pin; use an implicit "
            "integrator (pin_stiffness=None)."
        )
    position = mbs.GetNodeOutput(node, exudyn.OutputVariableType.Position, exudyn.ConfigurationType.Reference)
    anchor = mbs.AddNode(NodePointGround(referenceCoordinates=list(position)))
    markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=number)) for number in (anchor, node)]
    mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, stiffness=[stiffness] * 3))
