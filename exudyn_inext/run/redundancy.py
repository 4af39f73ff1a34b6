"""Constraints of a cable that depend on each other: seen by the pivots of its factorisation."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.implicit_bending import ImplicitBending
from ..cable.linked_cable import LinkedCableSystem
from ..cable.links import all_links
from ..errors import RedundantConstraintError
from ..scene.coupled_system import CoupledSystem
from ..scene.joints import JointBlock
from ..scene.model import CableInScene
from ..scene.redundant_rows import NOT_FINITE, not_independent
from .divergence import listed

LEAST_MOBILITY = 1e-10  # along a constraint, relative to that of the masses that it acts on
STRAIGHT = 1e-9  # share of its length that a straight cable's ends may lack
PULLED = 1e-3  # and those of one that something pulls straight, in the last good state


def element_masses(cable: Cable, implicit: ImplicitBending) -> Array:
    """(N,) rho_A l, and what implicit bending adds to it [kg]."""
    section, lengths = cable.section, cable.element_lengths
    masses: Array = section.mass_per_length * lengths
    return masses + 24.0 * implicit.factor(section) / lengths**3


def require_independent(scene_cable: CableInScene, system: Any, masses: Array) -> None:
    """Each length multiplier's pivot must be negative, each link's positive, clear of round-off.

    Args:
        scene_cable: the cable.   system: just evaluated.   masses: (N,) of its elements [kg].

    Raises:
        RedundantConstraintError: a pivot is not.
    """
    if not scene_cable.cable.stretches:
        _require_independent_lengths(scene_cable, system, masses)
    if isinstance(system, LinkedCableSystem):
        _require_independent_links(scene_cable, system.link_system.schur, 1.0 / masses.sum())


def _require_independent_lengths(scene_cable: CableInScene, system: Any, masses: Array) -> None:
    nodes = system.chain.nodes
    ends = np.flatnonzero(nodes["ends_group"])
    pivots = 1.0 / nodes["inverse_pivot"][ends, -1]
    dependent = ~(pivots < -LEAST_MOBILITY * 8.0 / masses[ends - 1])
    if dependent.any():
        k, names = int(ends[np.argmax(dependent)]), scene_cable.item.node_names
        raise RedundantConstraintError(
            f"the length constraint of the element between nodes {names[k - 1]} and {names[k]} of "
            f"cable '{scene_cable.name}' is not independent of the other constraints (a straight cable "
            "between two supports as far apart as it is long, or an element clamped at both ends): let it "
            "sag, free a support, or give it its axialStiffness."
        )


def _require_independent_links(scene_cable: CableInScene, factor: Array, mobility: float) -> None:
    """mobility: of the cable as a whole [1/kg], beside which that of a link held by lengths is round-off."""
    squares = np.tril(factor) ** 2
    dependent = ~(np.diag(squares) > LEAST_MOBILITY * np.maximum(squares.sum(axis=1), mobility))
    if dependent.any():
        link = all_links(scene_cable.cable)[int(np.argmax(dependent))]
        names = " and ".join(str(scene_cable.item.node_names[k]) for k in link.nodes)
        raise RedundantConstraintError(
            f"the {link.kind} constraint at node {names} of cable '{scene_cable.name}' is not independent "
            "of the other constraints (a node that is held or moved twice, or a cable pulled straight "
            "between what holds it): remove one of them, let the cable sag, or give it its axialStiffness."
        )


def require_mobile_points(system: CoupledSystem, cables: Sequence[Cable]) -> None:
    """Raise RedundantConstraintError for a joint to ground along a cable that lengths hold already.

    Its entry of S is round-off then, and positive or not by chance: it is compared with the cable's own mass.
    """
    blocks, names = system.native_items.blocks, system.native_items.joints
    parts = np.bincount(np.concatenate([block.rows for block in blocks]))
    of_parts = _by_part(blocks)
    for cable, part in zip(cables, system.parts, strict=False):
        mass = cable.section.mass_per_length * cable.length
        for block in of_parts[part.dofs.start]:
            entry = np.einsum("ij,ij->i", block.jacobian, block.response)
            least = LEAST_MOBILITY / mass * np.einsum("ij,ij->i", block.jacobian, block.jacobian)
            if (found := np.flatnonzero((parts[block.rows] == 1) & ~(entry > least))).size:
                raise not_independent([names[row] for row in block.rows[found]])


def _by_part(blocks: Iterable[JointBlock]) -> Mapping[int, list[JointBlock]]:
    """Of each part, by the first of its coordinates; none of a part without joints."""
    found = defaultdict[int, list[JointBlock]](list)
    for block in blocks:
        found[block.dofs.start].append(block)
    return found


def held_straight(scene: Any, q: Array, lacking: float = STRAIGHT) -> list[str]:
    """Names of straight cables that cannot stretch, and have supports, links or joints at both ends.

    Args:
        scene: see `native.evaluated_scene`; its joints have been evaluated.
        q: (n,) coordinates of all parts.   lacking: share of its length that the ends of a cable may lack.
    """
    names, of_parts = [], _by_part(scene.native_items.blocks)
    for (cable, *_), dofs in zip(scene.cables, scene.map.slices, strict=False):
        jacobians = [block.jacobian for block in of_parts[dofs.start]]
        if is_held_straight(cable.cable, q[dofs], jacobians, lacking):
            names.append(f"cable '{cable.name}'")
    return names


def is_held_straight(cable: Cable, q: Array, jacobians: Iterable[Array], lacking: float) -> bool:
    """q: (n_dof,) coordinates of the cable.   jacobians: (rows, n_dof) of joints by them; see above."""
    places = q.reshape(cable.reference.shape)[:, 0]
    is_straight = np.linalg.norm(places[-1] - places[0]) >= (1.0 - lacking) * cable.length
    if cable.stretches or not is_straight:
        return False
    held: np.ndarray = np.array(cable.fixed[:, 0], dtype=bool)
    held[[node for link in cable.links for node in link.nodes]] = True
    for jacobian in jacobians:
        by_nodes = jacobian.reshape(-1, *cable.reference.shape)
        held |= by_nodes[:, :, 0].any(axis=(0, 2))
    return bool(held[0] and held[-1])


def pulled_straight(names: Sequence[str]) -> str:
    """Likely cause of a failure, and what helps; empty if there are no such cables, see `held_straight`."""
    if not names:
        return ""
    return (
        f"Likely cause: {listed(names)} cannot stretch, and is pulled straight: keep what holds its ends "
        "within its length, or give it its axialStiffness."
    )


def with_straight_cables(
    error: RedundantConstraintError, straight: Sequence[str]
) -> RedundantConstraintError:
    """The same of joints, with the cables whose straightness may make them depend on each other.

    straight: names of those that are held at both ends.
    """
    if not straight or NOT_FINITE in str(error):
        return error
    return RedundantConstraintError(
        f"{error} Straight cables hold their ends apart by their length, as {listed(straight)} here: if all "
        "joints are needed, let these cables sag a little."
    )
