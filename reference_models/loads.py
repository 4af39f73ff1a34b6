"""Dead forces on nodes of a cable: at rest, and from then on."""

from collections.abc import Callable, Sequence
from typing import Any

from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

from .model import node_index
from .scenes import Constant, PointForce

ForceFunction = Callable[[Any, float, Any], list[float]]


def add_force(mbs: Any, node: int, load: PointForce) -> int:
    """The force at t = 0, as a constant; returns the number of the load."""
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
    return int(mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=list(load.value(0.0)))))


def add_forces(mbs: Any, loads: Sequence[PointForce], nodes: Sequence[int]) -> dict[int, PointForce]:
    """Load number -> load, on the nodes of a cable of equal elements."""
    elements = len(nodes) - 1
    return {add_force(mbs, nodes[node_index(load.at, elements)], load): load for load in loads}


def follow_history(mbs: Any, number: int, load: PointForce) -> None:
    """From now on the force follows its history; a user function, unless it is constant."""
    if not isinstance(load.history, Constant):
        mbs.SetLoadParameter(number, "loadVectorUserFunction", _force_function(load))


def remove_force(mbs: Any, number: int) -> None:
    """The load stays in the model, without a force."""
    mbs.SetLoadParameter(number, "loadVector", [0.0, 0.0, 0.0])


def _force_function(load: PointForce) -> ForceFunction:
    def force(mbs: Any, time: float, load_vector: Any) -> list[float]:
        return list(load.value(time))

    return force
