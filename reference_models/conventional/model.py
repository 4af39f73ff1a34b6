"""A scene as an Exudyn model of native ANCF cable elements."""

from typing import Any, Literal, get_args

import exudyn
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D

from exudyn_inext.errors import InputError

from ..model import Model, add_position_sensors, node_index, require_elements
from ..scenes import Clamp, Pin, Scene
from ..scenes.scene import ZERO
from .supports import add_constraint, add_spring

Quadrature = Literal["full", "reduced", "lobatto"]
"""Exudyn's useReducedOrderIntegration = 0, 1, 2: the quadrature of the elastic forces."""


def build(
    scene: Scene,
    elements: int,
    quadrature: Quadrature = "full",
    pin_stiffness: float | None = None,
) -> Model:
    """Build and assemble the scene with equal elements of ObjectANCFCable2D (in 3D ANCFCable).

    Args:
        scene: what to build.
        elements: number of elements.
        quadrature: "lobatto" is cheapest and locks least, but has hourglass modes.
        pin_stiffness: [N/m] springs instead of constraints, needed by explicit integrators.
    """
    require_elements(elements)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    nodes = _add_cable(mbs, scene, elements, quadrature)
    for support in scene.supports:
        _add_support(mbs, nodes[node_index(support.at, elements)], support, scene, pin_stiffness)
    sensors = add_position_sensors(mbs, scene, nodes)
    mbs.Assemble()
    return Model(scene, container, mbs, nodes, sensors)


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


def _add_cable(mbs: Any, scene: Scene, elements: int, quadrature: Quadrature) -> tuple[int, ...]:
    shape, length = scene.cable.shape, scene.cable.length
    end = [a + length * d for a, d in zip(shape.start, shape.direction, strict=True)]
    cable = GenerateBeamElementsAlongLine(
        mbs,
        positionStart=list(shape.start),
        positionEnd=end,
        numberOfElements=elements,
        beamTemplate=_element_template(scene, quadrature),
        gravity=list(scene.gravity),
    )
    nodes = tuple(cable["nodes"])
    if scene.end_velocity != ZERO:
        _set_linear_velocity(mbs, scene, nodes)
    return nodes


def _set_linear_velocity(mbs: Any, scene: Scene, nodes: tuple[int, ...]) -> None:
    """v(s) = v_end s / L, hence slope velocity v_end / L."""
    velocity = scene.end_velocity[: 2 if scene.is_planar else 3]
    slope_velocity = [v / scene.cable.length for v in velocity]
    for index, node in enumerate(nodes):
        position_velocity = [v * index / (len(nodes) - 1) for v in velocity]
        mbs.SetNodeParameter(node, "initialVelocities", position_velocity + slope_velocity)


def _add_support(
    mbs: Any, node: int, support: Pin | Clamp, scene: Scene, pin_stiffness: float | None
) -> None:
    if pin_stiffness is None:
        add_constraint(mbs, node, support, dimension=2 if scene.is_planar else 3)
    else:
        add_spring(mbs, node, support, pin_stiffness)
