"""A model with its loads: dead forces on nodes, at rest and from then on."""

from collections.abc import Callable, Sequence
from typing import Any

from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

from .model import Model, add_position_sensors, node_index
from .scenes import PointForce, Scene


def assembled(
    scene: Scene, container: Any, mbs: Any, nodes: tuple[int, ...], settle: Callable[[Model], Any]
) -> Model:
    """Loads, sensors and the static start, if the scene has one, by `settle`; then the motion may begin."""
    start_loads, loads = (_add_forces(mbs, forces, nodes) for forces in (scene.start_loads, scene.loads))
    model = Model(scene, container, mbs, nodes, add_position_sensors(mbs, scene, nodes))
    mbs.Assemble()
    if scene.starts_from_equilibrium:
        settle(model)
    for number in start_loads:
        mbs.SetLoadParameter(number, "loadVector", [0.0, 0.0, 0.0])
    for number, load in loads.items():
        _follow_history(mbs, number, load)
    return model


def _add_forces(mbs: Any, loads: Sequence[PointForce], nodes: Sequence[int]) -> dict[int, PointForce]:
    """The forces at t = 0, as constants: load number -> load, on the nodes of a cable of equal elements."""
    found = {}
    for load in loads:
        node = nodes[node_index(load.at, len(nodes) - 1)]
        marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=node))
        force = LoadForceVector(markerNumber=marker, loadVector=list(load.value(0.0)))
        found[int(mbs.AddLoad(force))] = load
    return found


def _follow_history(mbs: Any, number: int, load: PointForce) -> None:
    """From now on the force follows its history; a user function, unless it is constant."""

    def force(mbs: Any, time: float, load_vector: Any) -> list[float]:
        return list(load.value(time))

    if load.history:
        mbs.SetLoadParameter(number, "loadVectorUserFunction", force)
