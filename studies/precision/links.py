"""Rigid links in MuJoCo, tuned over links, steps, integrators and the rotary inertia of a link."""

import math
from collections.abc import Sequence
from dataclasses import replace

from reference_models.peers.rigid_links import (
    RigidLinks,
    has_integrator,
    is_installed,
    largest_step,
    rigid_links_case,
)
from reference_models.scenes import Scene

from .selection import Selection

SCENES = ("planar_pendulum", "spatial_pendulum")
LINKS = (4, 6, 8, 10, 14, 20, 28, 40, 56, 68)
QUICK_LINKS = (6, 10)
LONG = 40  # links from which on the step has no influence left, and what is costly is not repeated
FRACTIONS = (0.95, 0.5)  # of the stability limit
TUNED_INERTIA = 8.0 / 7.0  # over a uniform rod's: about the least error on both scenes, 3/4 to 3/2 tried
LOW_ORDER = {"Euler": (6, 10, 14), "implicitfast": (6, 10), "discrete": (6, 10, 20)}
LOW_ORDER_FRACTIONS = (0.95, 0.25, 0.05)
NOT_INSTALLED = "MuJoCo is not installed: no rows of rigid links; pip install 'exudyn_inext[peers]'."


def has_links(scene: Scene) -> bool:
    """Whether rows of rigid links belong to the scene."""
    return scene.name in SCENES


def links_selection(scene: Scene, quick: bool) -> Selection:
    """All of them for a scene; none if MuJoCo is not installed."""
    selection = Selection()
    if not (has_links(scene) and is_installed()):
        return selection
    for links in QUICK_LINKS if quick else LINKS:
        fractions = FRACTIONS[:1] if links >= LONG else FRACTIONS
        for inertia in (TUNED_INERTIA,) if links > LONG else (1.0, TUNED_INERTIA):
            _add(selection, scene, RigidLinks(links, 1.0, rotary_inertia=inertia), fractions)
    for integrator, meshes in LOW_ORDER.items():
        if has_integrator(integrator):
            for links in meshes[:1] if quick else meshes:
                chain = RigidLinks(links, 1.0, integrator, TUNED_INERTIA)
                _add(selection, scene, chain, LOW_ORDER_FRACTIONS)
    return selection


def _add(selection: Selection, scene: Scene, chain: RigidLinks, fractions: Sequence[float]) -> None:
    """At fractions of the stability limit; of Euler's, for integrators that have none."""
    limit = largest_step(scene, chain)
    if math.isinf(limit):
        limit = largest_step(scene, replace(chain, integrator="Euler"))
    for fraction in fractions:
        selection.add(rigid_links_case(scene, replace(chain, step_size=fraction * limit)))
