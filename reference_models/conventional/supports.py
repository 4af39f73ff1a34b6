"""Pins, clamps and hangers of native cables: as exact constraints, or as stiff springs.

Exudyn's explicit integrators eliminate a CoordinateConstraint only after the unconstrained solve
for the accelerations, which is wrong for coupled mass matrices such as those of ANCF cables
(pendulum: 1.8e-2 m tip error after 0.5 s, silently), and know no distance constraint. They get
springs instead: k = 1e5 N/m holds the pendulum's pin to 2e-5 m without lowering the stable step.

A cable that is held in several places is more sensitive: its sag changes by several times what its
supports give way. Power line, 40 elements, all springs alike, largest effect on P1, P2 over 5 s and on
the stable step of velocity Verlet: 1e5 N/m: 1.6e-3 m; 1e6: 2.3e-4 m, 1 % below that; 3e6: 1.3e-4 m, 2 %;
1e7: 6e-5 m, 6 %.
"""

from collections.abc import Sequence
from typing import Any

import exudyn
from exudyn.itemInterface import (
    CartesianSpringDamper,
    CoordinateConstraint,
    DistanceConstraint,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    SpringDamper,
)

from exudyn_inext.errors import InputError

from ..scenes import Clamp, Hanger, Pin, Scene
from ..scenes.support import Support

PIN_STIFFNESS = 1e5
"""Spring of the only pin of a cable [N/m]."""

TAUT_STIFFNESS = 3e6
"""Springs of a cable that is held in several places [N/m]."""


def spring_stiffness(scene: Scene) -> float:
    """Stiffness [N/m] of the springs that replace the constraints of the scene."""
    return PIN_STIFFNESS if len(scene.supports) <= 1 else TAUT_STIFFNESS


def add_constraint(mbs: Any, node: int, support: Support, dimension: int) -> None:
    """Hold the position (pin), position and slope (clamp) or distance (hanger) exactly."""
    if isinstance(support, Hanger):
        markers = _anchor_markers(mbs, node, support.anchor)
        mbs.AddObject(DistanceConstraint(markerNumbers=markers, distance=support.length))
    else:
        _hold_coordinates(mbs, node, 2 * dimension if isinstance(support, Clamp) else dimension)


def _hold_coordinates(mbs: Any, node: int, held: int) -> None:
    ground_node = mbs.AddNode(NodePointGround())
    ground = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground_node, coordinate=0))
    for coordinate in range(held):
        marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[ground, marker]))


def add_spring(mbs: Any, node: int, support: Support, stiffness: float) -> None:
    """Hold the position (pin) or the distance (hanger) by a spring of that stiffness [N/m]."""
    if isinstance(support, Clamp):
        raise InputError(
            f"{support}: a clamp cannot be held by the spring of a pin; use an implicit "
            "integrator (pin_stiffness=None)."
        )
    if isinstance(support, Pin):
        place = mbs.GetNodeOutput(
            node, exudyn.OutputVariableType.Position, exudyn.ConfigurationType.Reference
        )
        markers = _anchor_markers(mbs, node, place)
        mbs.AddObject(CartesianSpringDamper(markerNumbers=markers, stiffness=[stiffness] * 3))
        return
    markers = _anchor_markers(mbs, node, support.anchor)
    mbs.AddObject(SpringDamper(markerNumbers=markers, stiffness=stiffness, referenceLength=support.length))


def _anchor_markers(mbs: Any, node: int, anchor: Sequence[float]) -> list[int]:
    """Markers at a fixed point [m] and at the node."""
    ground = mbs.AddNode(NodePointGround(referenceCoordinates=list(anchor)))
    return [int(mbs.AddMarker(MarkerNodePosition(nodeNumber=number))) for number in (ground, node)]
