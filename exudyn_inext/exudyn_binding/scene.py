"""What an mbs contains, as far as the explicit solver is concerned."""

from dataclasses import dataclass, replace
from typing import Any

import exudyn
import numpy as np

from ..chain.cable import Cable
from ..errors import SceneError
from .cable_item import CableItem, find_cable_item, supports_of_flags
from .load_items import NodalLoad, read_load

_HARMLESS = {"Ground"}


@dataclass(frozen=True, eq=False)
class CableInScene:
    """A cable with its supports and loads.

    cable: model with supports.
    item: the items that it came from.
    indices: (n_dof,) places of its coordinates in the system vector.
    loads: nodal loads.
    name: for messages.
    """

    cable: Cable
    item: CableItem
    indices: np.ndarray
    loads: list[NodalLoad]
    name: str


@dataclass(frozen=True, eq=False)
class HeldCoordinate:
    """A native constraint that holds one nodal coordinate at its reference value."""

    node: int
    coordinate: int


def require_assembled(mbs: Any) -> None:
    """Raise SceneError unless mbs.Assemble() has been called after the last change."""
    if not mbs.systemIsConsistent:
        raise SceneError("mbs is not assembled: call mbs.Assemble() before SolveExplicit.")


def read_scene(mbs: Any) -> list[CableInScene]:
    """All inextensible cables of an assembled mbs; empty if there is none.

    Raises:
        SceneError: besides cables, the mbs has other items that move, connect or load; all are named.
    """
    items: dict[int, CableItem] = {}
    held: list[HeldCoordinate] = []
    unsupported: list[str] = []
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        item = find_cable_item(data)
        constraint = read_held_coordinate(mbs, data)
        if item is not None:
            items[number] = item
        elif constraint is not None:
            held.append(constraint)
        elif data["objectType"] not in _HARMLESS:
            unsupported.append(f"object {number} '{data['name']}' ({data['objectType']})")
    if not items:
        return []
    on_cables = {node for item in items.values() for node in item.nodes}
    loads, other_loads = _read_loads(mbs, on_cables)
    unsupported += _foreign_nodes(mbs, on_cables) + other_loads
    unsupported += [
        f"constraint on coordinate {c.coordinate} of node {c.node}" for c in held if c.node not in on_cables
    ]
    if unsupported:
        raise SceneError(
            "SolveExplicit supports inextensible cables, coordinate constraints that pin or clamp their "
            "nodes, and forces on their nodes; not supported yet: " + "; ".join(unsupported) + "."
        )
    return [_cable_in_scene(mbs, number, item, held, loads) for number, item in items.items()]


def read_held_coordinate(mbs: Any, data: dict[str, Any]) -> HeldCoordinate | None:
    """A CoordinateConstraint that holds a nodal coordinate to ground, or None if it is not one."""
    plain = (
        data["objectType"] == "ConnectorCoordinate"
        and data["activeConnector"]
        and not data["velocityLevel"]
        and data["offset"] == 0.0
        and not data["offsetUserFunction"]
    )
    if not plain:
        return None
    markers = [mbs.GetMarker(number) for number in data["markerNumbers"]]
    if any(marker["markerType"] != "NodeCoordinate" for marker in markers):
        return None
    moving = [m for m in markers if mbs.GetNode(m["nodeNumber"])["nodeType"] != "PointGround"]
    if len(moving) != 1:
        return None
    return HeldCoordinate(int(moving[0]["nodeNumber"]), int(moving[0]["coordinate"]))


def _read_loads(mbs: Any, on_cables: set[int]) -> tuple[list[NodalLoad], list[str]]:
    loads, others = [], []
    for number in range(mbs.systemData.NumberOfLoads()):
        load = read_load(mbs, number)
        if load is None or load.node not in on_cables:
            data = mbs.GetLoad(number)
            others.append(f"load {number} '{data['name']}' ({data['loadType']})")
        else:
            loads.append(load)
    return loads, others


def _foreign_nodes(mbs: Any, on_cables: set[int]) -> list[str]:
    foreign = []
    for number in range(mbs.systemData.NumberOfNodes()):
        data = mbs.GetNode(number)
        if number not in on_cables and data["nodeType"] != "PointGround":
            foreign.append(f"node {number} '{data['name']}' ({data['nodeType']})")
    return foreign


def _cable_in_scene(
    mbs: Any, number: int, item: CableItem, held: list[HeldCoordinate], loads: list[NodalLoad]
) -> CableInScene:
    name = mbs.GetObject(number)["name"]
    flags = np.zeros(item.cable.reference.shape, dtype=bool)
    for constraint in held:
        if constraint.node in item.nodes:
            flags[item.nodes.index(constraint.node)].flat[constraint.coordinate] = True
    fixed = np.array(
        [
            supports_of_flags(f"node {item.nodes[k]} of cable '{name}'", flags[k], item.cable.reference[k])
            for k in range(len(flags))
        ]
    )
    return CableInScene(
        cable=replace(item.cable, fixed=fixed),
        item=item,
        indices=np.array(mbs.systemData.GetObjectLTGODE2(number)),
        loads=[load for load in loads if load.node in item.nodes],
        name=name,
    )


def initial_state(mbs: Any, scene_cable: CableInScene) -> tuple[np.ndarray, np.ndarray]:
    """Total coordinates and velocities (n, 2, dim) of the initial configuration."""
    configuration = exudyn.ConfigurationType.Initial
    reference = scene_cable.cable.reference
    q = np.asarray(mbs.systemData.GetODE2Coordinates(configuration))[scene_cable.indices]
    v = np.asarray(mbs.systemData.GetODE2Coordinates_t(configuration))[scene_cable.indices]
    return reference + q.reshape(reference.shape), v.reshape(reference.shape)
