"""What an mbs contains, as far as the explicit solver is concerned."""

from collections.abc import Container, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import exudyn
import numpy as np

from ..cable.link import Link, rest
from ..constraints.prescribed_motion import prescribed
from ..errors import SceneError
from ..items.arguments import described, require_system
from ..items.attach.inert import is_inert_cable
from ..items.attach.markers import REMEDY, unsuitable_markers
from ..items.cable_data import belongs_to_a_cable, find_cable_item
from ..items.cable_item import supports_of_flags
from ..items.element_weights import Elements, elements_by_nodes, put_together, read_weight
from ..items.link_items import read_held_coordinate, read_moving_coordinate, read_rod
from ..items.load_items import read_load
from ..loads.weight import ElementWeight
from ..scene.links import MovingCoordinate, Rod, links_of_motions
from ..scene.model import CableInScene, CableItem, CableLoad, HeldCoordinate, Scene

_HARMLESS = {"Ground"}


@dataclass(eq=False)
class Contents:
    """The objects of an mbs by number, sorted.

    names: of the cables.
    enforcing: constraints by which cables keep their length under other solvers.
    others: descriptions for messages.
    """

    items: dict[int, CableItem] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)
    held: dict[int, "HeldCoordinate"] = field(default_factory=dict)
    moving: dict[int, MovingCoordinate] = field(default_factory=dict)
    rods: dict[int, Rod] = field(default_factory=dict)
    enforcing: list[int] = field(default_factory=list)
    others: list[str] = field(default_factory=list)


class ConstraintReader:
    """How native constraints become supports and links of cables; None if they are something else.

    number, data: of the object.
    """

    def held(self, mbs: Any, number: int, data: dict[str, Any]) -> HeldCoordinate | None:
        return read_held_coordinate(mbs, data)

    def moving(self, mbs: Any, number: int, data: dict[str, Any]) -> MovingCoordinate | None:
        return read_moving_coordinate(mbs, number, data)

    def rod(self, mbs: Any, number: int, data: dict[str, Any]) -> Rod | None:
        return read_rod(mbs, data)


@dataclass(eq=False)
class _OnOne:
    """What acts on one cable: its supports, links and loads."""

    held: list[HeldCoordinate] = field(default_factory=list)
    moving: list[MovingCoordinate] = field(default_factory=list)
    rods: list[Rod] = field(default_factory=list)
    loads: list[CableLoad] = field(default_factory=list)


def require_assembled(mbs: Any) -> None:
    """Raise SceneError unless mbs.Assemble() has been called after the last change."""
    require_system(mbs)
    if mbs.systemIsConsistent:
        return
    if refused := unsuitable_markers(mbs):
        raise SceneError(f"mbs cannot be assembled with {'; '.join(refused)}: {REMEDY}.")
    raise SceneError("mbs is not assembled: call mbs.Assemble() before it is solved or evaluated.")


def read_scene(mbs: Any, reader: ConstraintReader | None = None) -> Scene:
    """Inextensible cables of an assembled mbs, and what else there is.   reader: of its constraints."""
    contents = _contents(mbs, reader or ConstraintReader())
    cable_of = {node: number for number, item in contents.items.items() for node in item.nodes}
    loads, other_loads = _read_loads(mbs, cable_of, elements_by_nodes(contents.items))
    foreign = [*contents.others, *_foreign_nodes(mbs, cable_of), *other_loads]
    held_elsewhere = {number: held for number, held in contents.held.items() if held.node not in cable_of}
    foreign += _take_foreign_constraints(mbs, contents, cable_of)
    on_each = _on_each_cable(contents, loads, cable_of)
    if mbs.NumberOfGeneralContacts():
        foreign.append("a general contact")
    return Scene(
        cables=[_cable_in_scene(mbs, number, contents, on_each[number]) for number in contents.items],
        foreign=foreign,
        own_constraints=frozenset([*contents.held, *contents.moving, *contents.rods, *contents.enforcing]),
        enforcing=contents.enforcing,
        held=held_elsewhere,
    )


def read_cables(mbs: Any, who: str) -> list[CableInScene]:
    """All inextensible cables of an assembled mbs that contains nothing else; empty if there is none.

    Args:
        mbs: the system.   who: asks, for messages.

    Raises:
        SceneError: besides cables, the mbs has other items that move, connect or load; all are named.
    """
    scene = read_scene(mbs)
    if scene.cables and scene.foreign:
        raise SceneError(
            f"{who} deals with inextensible cables, coordinate constraints that hold or move positions of "
            "their nodes or clamp them, distance constraints between ground and their nodes, and forces on "
            f"their nodes; mbs has also: {'; '.join(scene.foreign)}. SolveExplicit takes such scenes."
        )
    return scene.cables


def _contents(mbs: Any, reader: ConstraintReader) -> Contents:
    contents = Contents()
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        item = find_cable_item(data)
        if item is not None:
            contents.items[number] = item
            contents.names[number] = data["name"]
        elif (held := reader.held(mbs, number, data)) is not None:
            contents.held[number] = held
        elif (moving := reader.moving(mbs, number, data)) is not None:
            contents.moving[number] = moving
        elif (rod := reader.rod(mbs, number, data)) is not None:
            contents.rods[number] = rod
        elif belongs_to_a_cable(data):
            contents.enforcing.append(number)
        elif _does_something(data):
            contents.others.append(described(data, number))
    return contents


def _does_something(data: dict[str, Any]) -> bool:
    """Whether an object moves, loads or connects; a connector that is switched off does not."""
    is_harmless = data["objectType"] in _HARMLESS or is_inert_cable(data)
    return not is_harmless and bool(data.get("activeConnector", True))


def _take_foreign_constraints(mbs: Any, contents: Contents, cable_of: dict[int, int]) -> list[str]:
    """Remove constraints that do not act on one cable alone; returns what they are.

    cable_of: number of the cable that a node belongs to.
    """

    def is_on_one(nodes: Iterable[int]) -> bool:
        cables = {cable_of.get(node) for node in nodes}
        return len(cables) == 1 and None not in cables

    foreign = [number for number, held in contents.held.items() if not is_on_one([held.node])]
    foreign += [number for number, moving in contents.moving.items() if not is_on_one([moving.node])]
    foreign += [number for number, rod in contents.rods.items() if not is_on_one(rod.nodes)]
    for number in foreign:
        for kind in (contents.held, contents.moving, contents.rods):
            kind.pop(number, None)
    return [described(mbs.GetObject(number), number) for number in foreign]


def _on_each_cable(
    contents: Contents, loads: Iterable[CableLoad], cable_of: dict[int, int]
) -> dict[int, _OnOne]:
    """What acts on each cable; foreign constraints and loads have been taken out."""
    on_each = {number: _OnOne() for number in contents.items}
    for held in contents.held.values():
        on_each[cable_of[held.node]].held.append(held)
    for moving in contents.moving.values():
        on_each[cable_of[moving.node]].moving.append(moving)
    for rod in contents.rods.values():
        on_each[cable_of[rod.nodes[0]]].rods.append(rod)
    for load in loads:
        cable = load.cable if isinstance(load, ElementWeight) else cable_of[load.node]
        on_each[cable].loads.append(load)
    return on_each


def _read_loads(mbs: Any, on_cables: Container[int], elements: Elements) -> tuple[list[CableLoad], list[str]]:
    loads: list[CableLoad] = []
    weights: list[ElementWeight] = []
    others = []
    for number in range(mbs.systemData.NumberOfLoads()):
        if (weight := read_weight(mbs, number, elements)) is not None:
            weights.append(weight)
        elif (load := read_load(mbs, number)) is not None and load.node in on_cables:
            loads.append(load)
        else:
            data = mbs.GetLoad(number)
            others.append(f"load {number} '{data['name']}' ({data['loadType']})")
    return loads + put_together(weights), others


def _foreign_nodes(mbs: Any, on_cables: Container[int]) -> list[str]:
    foreign = []
    for number in range(mbs.systemData.NumberOfNodes()):
        if number in on_cables:
            continue
        data = mbs.GetNode(number)
        if data["nodeType"] != "PointGround":
            foreign.append(f"node {number} '{data['name']}' ({data['nodeType']})")
    return foreign


def _cable_in_scene(mbs: Any, number: int, contents: Contents, on_it: _OnOne) -> CableInScene:
    name, item = contents.names[number], contents.items[number]
    places = {node: place for place, node in enumerate(item.nodes)}
    fixed, links = _supports(item, on_it.held, places, name)
    links += links_of_motions(on_it.moving, places, item.cable.dimension)
    for rod in on_it.rods:
        links += rod.links([places[node] for node in rod.nodes], item.cable.dimension)
    indices = np.array(mbs.systemData.GetObjectLTGODE2(number))
    if item.cable.closed:
        indices = np.append(indices, indices[: 2 * item.cable.dimension])
    return CableInScene(
        cable=replace(item.cable, fixed=fixed, links=tuple(links)),
        item=item,
        indices=indices,
        loads=on_it.loads,
        moving=on_it.moving,
        number=number,
        name=name,
    )


def _supports(
    item: CableItem, held: Iterable[HeldCoordinate], places: dict[int, int], name: str
) -> tuple[np.ndarray, list[Link]]:
    """(n, 2) held nodes, and links where only some coordinates of a position are held."""
    reference = item.cable.reference
    flags = item.held.copy()
    for constraint in held:
        flags[places[constraint.node]].flat[constraint.coordinate] = True
    if item.cable.closed:
        flags[-1] = flags[0]
    fixed = np.zeros(flags.shape[:2], dtype=bool)
    links: list[Link] = []
    for k in np.flatnonzero(flags[: len(item.nodes)].any(axis=(1, 2))).tolist():
        node = item.nodes[k]
        fixed[k] = supports_of_flags(f"node {node} of cable '{name}'", flags[k], reference[k])
        if not fixed[k, 0]:
            links += prescribed(k, rest(reference[k, 0]), np.flatnonzero(flags[k, 0]).tolist())
    if item.cable.closed:
        fixed[-1] = fixed[0]
    return fixed, links


def initial_state(mbs: Any, scene_cable: CableInScene) -> tuple[np.ndarray, np.ndarray]:
    """Total coordinates and velocities (n, 2, dim) of the initial configuration."""
    return initial_states(mbs, [scene_cable])[0]


def initial_states(mbs: Any, cables: Iterable[CableInScene]) -> list[tuple[np.ndarray, np.ndarray]]:
    """As `initial_state`, of each of these cables."""
    configuration = exudyn.ConfigurationType.Initial
    all_q = np.asarray(mbs.systemData.GetODE2Coordinates(configuration))
    all_v = np.asarray(mbs.systemData.GetODE2Coordinates_t(configuration))
    states = []
    for scene_cable in cables:
        reference = scene_cable.cable.reference
        q, v = all_q[scene_cable.indices], all_v[scene_cable.indices]
        states.append((reference + q.reshape(reference.shape), v.reshape(reference.shape)))
    return states
