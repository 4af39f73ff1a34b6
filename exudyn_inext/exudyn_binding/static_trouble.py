"""Why a search for an equilibrium cannot succeed, or has not."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ..arrays import Array
from ..cable.axial import SHORTEST
from ..cable.cable import Cable
from ..constraints.prescribed_motion import KIND
from ..errors import SceneError
from ..scene.model import CableInScene

REACH_TOLERANCE = 1e-9
TAUT = 1.0 - 1e-6  # distance of supports over the reach of the cable between them
NEARLY = 1.5  # times the shortest |r_x|


def hint(scene_cable: CableInScene, q: Array, time: float) -> str:
    """Why a search may have failed at q (n, 2, dim), and what helps; empty if that is not known."""
    cable, names = scene_cable.cable, scene_cable.item.node_names
    shortest = np.linalg.norm(q[:, 1], axis=1)
    if cable.stretches and shortest.min() < NEARLY * SHORTEST:
        where = names[int(np.argmin(shortest))]
        return (
            f"cable '{scene_cable.name}' is compressed at node {where} to {shortest.min():.2g} of its "
            "length, so that it is about to turn inside out: let it be stiffer along its axis, or start "
            "nearer to the equilibrium"
        )
    if not cable.stretches and (taut := _taut(cable, time)):
        ends = " and ".join(str(names[k]) for k in taut)
        return (
            f"cable '{scene_cable.name}' is straight between the supports of nodes {ends}, where no tension "
            "holds it against forces across: give it its axialStiffness, or let it sag"
        )
    return ""


def _taut(cable: Cable, time: float) -> tuple[int, ...]:
    """Nodes whose supports are as far apart as the cable between them reaches."""
    return next((nodes for nodes, distance, reach in _spans(cable, time) if distance > TAUT * reach), ())


def _spans(cable: Cable, time: float) -> Iterator[tuple[tuple[int, int], float, float]]:
    """Two nodes that are held, the distance of their supports, and how far they reach [m]."""
    arc = np.append(0.0, np.cumsum(cable.element_lengths))
    for (a, here, slack_a), (b, there, slack_b) in combinations(_held_points(cable, time), 2):
        yield (a, b), float(np.linalg.norm(there - here)), abs(arc[b] - arc[a]) + slack_a + slack_b


def require_reach(cable: Cable, time: float, scene_cable: CableInScene) -> None:
    """Raise SceneError if supports are farther apart than cable and rods between them reach."""
    if cable.stretches:
        return
    names = scene_cable.item.node_names
    for (a, b), distance, reach in _spans(cable, time):
        if distance > reach * (1.0 + REACH_TOLERANCE):
            raise SceneError(
                f"the supports of nodes {names[a]} and {names[b]} of cable '{scene_cable.name}' are "
                f"{distance:.9g} m apart, but the cable between them reaches {reach:.9g} m only: lengthen "
                "the cable or move the supports together."
            )


def _held_points(cable: Cable, time: float) -> list[tuple[int, Array, float]]:
    """(node, point, how far the node may be from it) of pins, clamps, moving supports and hangers."""
    nodes = np.flatnonzero(cable.fixed[:, 0])
    points = [(int(k), cable.reference[k, 0], 0.0) for k in nodes if not (cable.closed and k == nodes[-1])]
    for node in {link.nodes[0] for link in cable.links if link.kind == KIND}:
        held = [link for link in cable.links if link.kind == KIND and link.nodes == (node,)]
        if len(held) == cable.dimension:
            points.append((node, sum(link.normal * link.anchor.at(time)[0] for link in held), 0.0))
    hangers = [link for link in cable.links if len(link.nodes) == 1 and np.isfinite(link.length)]
    return points + [(link.nodes[0], link.anchor.at(time)[0], link.length) for link in hangers]
