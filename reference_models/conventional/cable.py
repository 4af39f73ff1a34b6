"""The cable of a scene as native ANCF elements, with gravity and initial velocities."""

from typing import Any, Literal, get_args

import numpy as np
from exudyn.beams import GenerateBeamElementsAlongLine, PointsAndSlopes2ANCFCable2D
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D

from exudyn_inext.errors import InputError

from ..scenes import Line, Scene
from ..scenes.scene import ZERO

Quadrature = Literal["full", "reduced", "lobatto"]
"""Exudyn's useReducedOrderIntegration = 0, 1, 2: the quadrature of the elastic forces."""

CLOSED_ELEMENTS = 3
"""Fewest elements of a closed cable: with two, both would join the same nodes."""


def add_cable(mbs: Any, scene: Scene, elements: int, quadrature: Quadrature) -> tuple[int, ...]:
    """Equal elements of ObjectANCFCable2D (in 3D ANCFCable).

    Returns:
        node numbers along the cable; the last one of a closed cable is the first one again.
    """
    template = _element_template(scene, quadrature)
    if isinstance(scene.cable.shape, Line):
        nodes = _add_straight_cable(mbs, scene, scene.cable.shape, elements, template)
    else:
        nodes = _add_curved_cable(mbs, scene, elements, template)
    if scene.end_velocity != ZERO:
        _set_linear_velocity(mbs, scene, nodes)
    return nodes


def _element_template(scene: Scene, quadrature: Quadrature) -> ObjectANCFCable | ObjectANCFCable2D:
    if quadrature not in get_args(Quadrature):
        raise InputError(
            f"quadrature = {quadrature!r} is unknown; use one of {', '.join(get_args(Quadrature))}."
        )
    section = scene.cable.section
    element = ObjectANCFCable2D if scene.is_planar else ObjectANCFCable
    return element(
        massPerLength=section.mass_per_length,
        bendingStiffness=section.bending_stiffness,
        axialStiffness=section.axial_stiffness,
        useReducedOrderIntegration=get_args(Quadrature).index(quadrature),
    )


def _add_straight_cable(
    mbs: Any, scene: Scene, line: Line, elements: int, template: ObjectANCFCable | ObjectANCFCable2D
) -> tuple[int, ...]:
    end = [a + scene.cable.length * d for a, d in zip(line.start, line.direction, strict=True)]
    cable = GenerateBeamElementsAlongLine(
        mbs,
        positionStart=list(line.start),
        positionEnd=end,
        numberOfElements=elements,
        beamTemplate=template,
        gravity=list(scene.gravity),
    )
    return tuple(cable["nodes"])


def _add_curved_cable(mbs: Any, scene: Scene, elements: int, template: ObjectANCFCable2D) -> tuple[int, ...]:
    """Nodes on the curve; elements have the cable's length, not that of their cubics."""
    cable = scene.cable
    _require_buildable(scene, elements)
    if cable.stress_free == "shape":
        template.strainIsRelativeToReference = 1.0
    positions, slopes = cable.nodes(elements)
    nodes, *_ = PointsAndSlopes2ANCFCable2D(
        mbs,
        ancfPointsSlopes=list(np.hstack([positions[:, :2], slopes[:, :2]])),
        elementLengths=[cable.length / elements] * elements,
        cableTemplate=template,
        massProportionalLoad=list(scene.gravity),
        firstNodeIsLastNode=cable.shape.closed,
    )
    return tuple(nodes)


def _require_buildable(scene: Scene, elements: int) -> None:
    if not scene.is_planar:
        raise InputError(
            f"scene '{scene.name}': native cables are curved in the x-y plane only; keep the z of shape, "
            "gravity, loads and anchors at zero, or start from a Line."
        )
    if scene.cable.shape.closed and elements < CLOSED_ELEMENTS:
        raise InputError(
            f"elements = {elements}: the closed cable of scene '{scene.name}' needs at least "
            f"{CLOSED_ELEMENTS}."
        )


def _set_linear_velocity(mbs: Any, scene: Scene, nodes: tuple[int, ...]) -> None:
    """v(s) = v_end s / L, hence slope velocity v_end / L."""
    velocity = scene.end_velocity[: 2 if scene.is_planar else 3]
    slope_velocity = [v / scene.cable.length for v in velocity]
    for index, node in enumerate(nodes):
        position_velocity = [v * index / (len(nodes) - 1) for v in velocity]
        mbs.SetNodeParameter(node, "initialVelocities", position_velocity + slope_velocity)
