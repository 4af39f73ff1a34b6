"""A scene as an Exudyn model of native ANCF cable elements."""

from typing import Any

import exudyn

from exudyn_inext.checks import LARGEST_NUMBER_OF_ITEMS, require_integer

from ..loads import assembled
from ..model import Model, node_index
from ..scenes import Hanger, Scene
from ..scenes.support import Support
from .cable import Quadrature, add_cable
from .equilibrium import settle
from .supports import add_constraint, add_spring, spring_stiffness

__all__ = ["Quadrature", "build", "build_for_explicit"]


def build(
    scene: Scene,
    elements: int,
    quadrature: Quadrature = "full",
    pin_stiffness: float | None = None,
    hanger_stiffness: float | None = None,
) -> Model:
    """Build and assemble the scene with equal elements of ObjectANCFCable2D (in 3D ANCFCable).

    Args:
        scene: what to build.
        elements: number of elements.
        quadrature: "lobatto" is cheapest and locks least, but has hourglass modes.
        pin_stiffness: [N/m] springs instead of constraints, needed by native explicit integrators.
        hanger_stiffness: [N/m] springs instead of rigid hangers, needed by all explicit integrators.
    """
    require_integer("elements", elements, 1, LARGEST_NUMBER_OF_ITEMS)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    nodes = add_cable(mbs, scene, elements, quadrature)
    for support in scene.supports:
        stiffness = hanger_stiffness if isinstance(support, Hanger) else pin_stiffness
        _add_support(mbs, nodes[node_index(support.at, elements)], support, scene, stiffness)
    return assembled(scene, container, mbs, nodes, settle)


def build_for_explicit(scene: Scene, elements: int, quadrature: Quadrature = "full") -> Model:
    """Build the scene without constraints, as Exudyn's explicit integrators need it."""
    stiffness = spring_stiffness(scene)
    return build(scene, elements, quadrature, stiffness, stiffness)


def _add_support(mbs: Any, node: int, support: Support, scene: Scene, stiffness: float | None) -> None:
    if stiffness is None:
        add_constraint(mbs, node, support, dimension=2 if scene.is_planar else 3)
    else:
        add_spring(mbs, node, support, stiffness)
