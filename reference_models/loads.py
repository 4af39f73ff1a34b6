"""Dead forces on nodes of a cable: at rest, and from then on."""

from collections.abc import Sequence
from typing import Any

from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

from .model import node_index
from .scenes import PointForce


def add_forces(mbs: Any, loads: Sequence[PointForce], nodes: Sequence[int]) -> dict[int, PointForce]:
    """The forces at t = 0, as constants: load number -> load, on the nodes of a cable of equal elements."""
    found = {}
    for load in loads:
        node = nodes[node_index(load.at, len(nodes) - 1)]
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        force = LoadForceVector(markerNumber=marker, loadVector=list(load.value(0.0)))
        found[int(mbs.AddLoad(force))] = load
    return found


def follow_history(mbs: Any, number: int, load: PointForce) -> None:
    """From now on the force follows its history; a user function, unless it is constant."""

    def force(mbs: Any, time: float, load_vector: Any) -> list[float]:
        return list(load.value(time))

    if load.history:
        mbs.SetLoadParameter(number, "loadVectorUserFunction", force)


def remove_force(mbs: Any, number: int) -> None:
    """The load stays in the model, without a force."""
    mbs.SetLoadParameter(number, "loadVector", [0.0, 0.0, 0.0])
