"""What an mbs contains, as far as the explicit solver is concerned."""

from collections import defaultdict
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass, field, replace
from typing import Any, TypeGuard

import exudyn
import numpy as np

from ..cable.attached import PointMass
from ..cable.link import Link, Motion, rest
from ..checks import require_flag
from ..constraints.prescribed_motion import prescribed
from ..errors import SceneError
from ..items.arguments import described, require_system
from ..items.attach.inert import is_inert_cable, nodes_of_inert_cable
from ..items.attach.markers import REMEDY, unsuitable_items
from ..items.cable_data import belongs_to_a_cable, find_cable_item
from ..items.cable_item import supports_of_flags
from ..items.element_weights import Elements, elements_by_nodes, put_together, read_weight
from ..items.functions_of_time import functions_at_rest
from ..items.link_items import read_held_coordinate, read_moving_coordinate, read_rod
from ..items.load_items import read_load
from ..items.mass_points import node_of_mass_point, require_none_connected
from ..items.parameters import require_numbers
from ..items.replace_native import require_as_replaced
from ..loads.nodal import NodalLoad
from ..loads.weight import ElementWeight
from ..run.load_functions import Asked, LoadFunctions
from ..scene.links import MovingCoordinate, Rod, links_of_motions
from ..scene.model import CableInScene, CableItem, CableLoad, HeldCoordinate, Reaction, Scene
from .shared_nodes import shared_coordinates

_HARMLESS = {"Ground"}
_MATRICES = ("massMatrix", "stiffnessMatrix", "dampingMatrix")  # of ObjectGenericODE2
COINCIDENT = 1e-10  # difference of coordinates that are meant to be the same [m, -]
_OUT_OF_PLANE = {"ForceVector": ("z", "N"), "TorqueVector": ("xy", "Nm")}  # components, unit
_KINDS = (HeldCoordinate, MovingCoordinate, Rod)
Constraint = HeldCoordinate | MovingCoordinate | Rod


@dataclass(eq=False)
class Contents:
    """The objects of an mbs by number, sorted.

    names: of the cables.   constraints: that may be supports and links of them.
    enforcing: constraints by which cables keep their length under other solvers.
    mass_points: on nodes of cables, node and mass [kg].
    others: descriptions for messages.
    """

    items: dict[int, CableItem] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)
    constraints: dict[int, Constraint] = field(default_factory=dict)
    enforcing: list[int] = field(default_factory=list)
    mass_points: dict[int, tuple[int, float]] = field(default_factory=dict)
    others: list[str] = field(default_factory=list)


def require_assembled(mbs: Any) -> None:
    """Raise SceneError unless mbs.Assemble() has been called after the last change."""
    require_system(mbs)
    if mbs.systemIsConsistent:
        return
    if refused := unsuitable_items(mbs):
        raise SceneError(f"mbs cannot be assembled with {'; '.join(refused)}: {REMEDY}.")
    raise SceneError("mbs is not assembled: call mbs.Assemble() before it is solved or evaluated.")


def assemble(mbs: Any, who: str, autoAssemble: bool) -> None:
    """Assemble mbs if it is not, and that is asked for, as Exudyn's own solvers do.   who: for the console.

    Raises:
        InputError: autoAssemble is no flag.
        SceneError: mbs is not assembled, or cannot be.
    """
    is_asked_for = require_flag("autoAssemble", autoAssemble)
    require_system(mbs)
    if is_asked_for and not mbs.systemIsConsistent and not unsuitable_items(mbs):
        exudyn.Print(  # type: ignore[call-arg]
            f"WARNING: {who}: mbs is not assembled, so that mbs.Assemble() is called, and it begins with "
            "the initial values of the nodes; autoAssemble=False refuses it instead"
        )
        mbs.Assemble()
    require_assembled(mbs)


def read_constraint(mbs: Any, number: int, data: dict[str, Any]) -> Constraint | None:
    """A native constraint that becomes a support or link of a cable; None if it is something else.

    number, data: of the object.
    """
    held = read_held_coordinate(mbs, data)
    return held or read_moving_coordinate(mbs, number, data) or read_rod(mbs, data)


def read_scene(mbs: Any, read: Callable[..., Constraint | None] = read_constraint) -> Scene:
    """Inextensible cables of an assembled mbs, and what else there is.   read: its constraints."""
    with functions_at_rest(mbs):
        contents = _contents(mbs, read)
        cable_of = {node: number for number, item in contents.items.items() for node in item.nodes}
        loads, other_loads = _read_loads(mbs, cable_of, contents.items)
    foreign = [*contents.others, *_foreign_nodes(mbs, cable_of), *other_loads]
    elsewhere = _take_foreign_constraints(contents.constraints, cable_of)
    foreign += [described(mbs.GetObject(number), number) for number in elsewhere]
    held = {number: it for number, it in elsewhere.items() if isinstance(it, HeldCoordinate)}
    if mbs.NumberOfGeneralContacts():
        foreign.append("a general contact")
    if foreign:
        links = _take_links(contents, cable_of)
        foreign += [described(mbs.GetObject(number), number) for number in links]
    constraints_on: defaultdict[int, dict[int, Constraint]] = defaultdict(dict)
    loads_on = defaultdict(list)
    for number, constraint in contents.constraints.items():
        constraints_on[cable_of[constraint.nodes[0]]][number] = constraint
    for load in loads:
        loads_on[load.cable if isinstance(load, ElementWeight) else cable_of[load.node]].append(load)
    cables = [
        _cable_in_scene(mbs, number, contents, constraints_on[number], loads_on[number])
        for number in contents.items
    ]
    _require_references(mbs, cables)
    return Scene(
        cables=cables,
        foreign=foreign,
        own_constraints=frozenset([*contents.constraints, *contents.enforcing]),
        enforcing=contents.enforcing,
        held=held,
    )


def _contents(mbs: Any, read: Callable[..., Constraint | None]) -> Contents:
    contents, objects = Contents(), [mbs.GetObject(k) for k in range(mbs.systemData.NumberOfObjects())]
    for number, data in enumerate(objects):
        if (item := find_cable_item(data)) is not None:
            _require_no_matrices(item, data)
            require_as_replaced(item, data["name"], objects)
            contents.items[number] = item
            contents.names[number] = data["name"]
    on_cables = {node for item in contents.items.values() for node in item.nodes}
    for number, data in enumerate(objects):
        require_numbers(data, "Object", described(data, number))
        require_none_connected(mbs, number, data, contents.mass_points)
        if number in contents.items:
            continue
        if (constraint := read(mbs, number, data)) is not None:
            contents.constraints[number] = constraint
        elif belongs_to_a_cable(data):
            contents.enforcing.append(number)
        elif (node := node_of_mass_point(data)) in on_cables:
            contents.mass_points[number] = node, float(data["mass"])
        elif _does_something(data):
            contents.others.append(described(data, number))
    return contents


def _require_no_matrices(item: CableItem, data: dict[str, Any]) -> None:
    """Raise SceneError if a cable's object was given what no run would read.   data: of the object."""
    if item.enforcement != "projection":  # that object has matrices of its own
        return
    values = {name: data[name].Convert2DenseMatrix() for name in _MATRICES}
    for name, value in {**values, "forceVector": data["forceVector"]}.items():
        if value.size:
            raise SceneError(
                f"{name} of cable '{data['name']}' was set, but its motion follows from its template, "
                "gravity and loads: leave it empty, and use loads, springs and AddPointMass on the cable."
            )


def _does_something(data: dict[str, Any]) -> bool:
    """Whether an object moves, loads or connects; a connector that is switched off does not."""
    is_harmless = data["objectType"] in _HARMLESS or is_inert_cable(data)
    return not is_harmless and bool(data.get("activeConnector", True))


def _take_foreign_constraints(
    constraints: dict[int, Constraint], cable_of: dict[int, int]
) -> dict[int, Constraint]:
    """Remove constraints that do not act on one cable alone, or follow user functions of the state.

    Returns them, one kind after the other.

    cable_of: number of the cable that a node belongs to.
    """

    def is_of_one(constraint: Constraint) -> bool:
        if isinstance(constraint, MovingCoordinate) and _follows_state(constraint.motion):
            return False
        cables = {cable_of.get(node) for node in constraint.nodes}
        return len(cables) == 1 and None not in cables

    foreign = [number for number, constraint in constraints.items() if not is_of_one(constraint)]
    foreign.sort(key=lambda number: _KINDS.index(type(constraints[number])))
    return {number: constraints.pop(number) for number in foreign}


def _follows_state(motion: Motion) -> bool:
    """Whether a user function of the state gives it; what is set between steps goes on in between."""
    return not motion.is_pure and motion.is_smooth


def _take_links(contents: Contents, cable_of: dict[int, int]) -> dict[int, Constraint]:
    """Remove rods, and what holds positions in part, if several cables have them; returns them.

    Among other items they are joints: a cable with links of its own shares its records with no other one. So
    is what is set between steps.
    """
    held: defaultdict[int, set[int]] = defaultdict(set)  # coordinates of each node
    for constraint in contents.constraints.values():
        if isinstance(constraint, HeldCoordinate):
            held[constraint.node].add(constraint.coordinate)

    def is_link(constraint: Constraint) -> bool:
        if not isinstance(constraint, HeldCoordinate):
            return isinstance(constraint, Rod)
        position = set(range(contents.items[cable_of[constraint.node]].cable.dimension))
        return constraint.coordinate in position and not position <= held[constraint.node]

    def is_set(constraint: Constraint) -> bool:
        motion = None if isinstance(constraint, HeldCoordinate) else constraint.motion
        return motion is not None and not motion.is_pure

    links = {number: one for number, one in contents.constraints.items() if is_link(one)}
    if len({cable_of[one.nodes[0]] for one in links.values()}) < 2:
        links = {}
    links |= {number: one for number, one in contents.constraints.items() if is_set(one)}
    for number in links:
        del contents.constraints[number]
    return links


def _read_loads(
    mbs: Any, on_cables: Container[int], items: dict[int, CableItem]
) -> tuple[list[CableLoad], list[str]]:
    elements = elements_by_nodes(items)
    planar = {nodes: one for nodes, one in elements.items() if items[one[0]].cable.dimension == 2}
    loads: list[CableLoad] = []
    weights: list[ElementWeight] = []
    others = []
    for number in range(mbs.systemData.NumberOfLoads()):
        data = mbs.GetLoad(number)
        name = f"load {number} '{data['name']}' ({data['loadType']})"
        require_numbers(data, "Load", name)
        if (weight := read_weight(mbs, number, data, elements)) is not None:
            weights.append(weight)
            if weight.follows_state:
                others.append(name)
        elif _is_of_cables(load := read_load(mbs, number, data), on_cables):
            loads.append(load)
        else:
            others.append(name)
            _require_numbers(mbs, load, name)
            _require_in_plane(mbs, data, name, planar)
    return loads + put_together(weights), others


def _require_in_plane(mbs: Any, data: dict[str, Any], name: str, elements: Elements) -> None:
    """Raise SceneError if a constant load on a planar cable has components out of its plane.

    Native cables pass these over.   data, name: of the load.   elements: of planar cables.
    """
    axes, unit = _OUT_OF_PLANE.get(data["loadType"], ("", ""))
    if not axes or data["loadVectorUserFunction"] or not _is_on(mbs, int(data["markerNumber"]), elements):
        return
    for axis in axes:
        if value := data["loadVector"]["xyz".index(axis)]:
            raise SceneError(
                f"{name} has the {axis} component {value:g} {unit}, but its cable is planar: set that to 0, "
                "or create the cable with dimension=3, which takes forces."
            )


def _is_on(mbs: Any, marker: int, elements: Elements) -> bool:
    """Whether a marker is a point of one of these elements, or a frame at one of their nodes."""
    data = mbs.GetMarker(marker)
    if data["markerType"] == "NodeRigid":
        return any(int(data["nodeNumber"]) in nodes for nodes in elements)
    is_point = data["markerType"] in ("BodyPosition", "BodyRigid")
    return is_point and nodes_of_inert_cable(mbs.GetObject(data["bodyNumber"])) in elements


def _is_of_cables(load: NodalLoad | None, on_cables: Container[int]) -> TypeGuard[NodalLoad]:
    """Whether a cable takes it: a user function of the state is Exudyn's, which knows the state."""
    if load is None or load.node not in on_cables:
        return False
    return load.history is None or load.is_pure


def _require_numbers(mbs: Any, load: NodalLoad | None, name: str) -> None:
    """Raise SceneError if the user function of a load, asked now, does not return its components."""
    if load is not None and load.history is not None:
        functions = LoadFunctions([Asked(load.history, len(load.constant), name)])
        functions.values([mbs.systemData.GetTime()])


def _foreign_nodes(mbs: Any, on_cables: Container[int]) -> list[str]:
    foreign = []
    for number in range(mbs.systemData.NumberOfNodes()):
        if number in on_cables:
            continue
        data = mbs.GetNode(number)
        if data["nodeType"] != "PointGround":
            foreign.append(f"node {number} '{data['name']}' ({data['nodeType']})")
    return foreign


def _cable_in_scene(
    mbs: Any, number: int, contents: Contents, constraints: dict[int, Constraint], loads: list[CableLoad]
) -> CableInScene:
    name, item = contents.names[number], contents.items[number]
    places = {node: place for place, node in enumerate(item.nodes)}
    held = [it for it in constraints.values() if isinstance(it, HeldCoordinate)]
    moving = [it for it in constraints.values() if isinstance(it, MovingCoordinate)]
    rods = [it for it in constraints.values() if isinstance(it, Rod)]
    fixed, links = _supports(item, held, places, name)
    links += links_of_motions(moving, places, item.cable.dimension)
    for rod in rods:
        links += rod.links([places[node] for node in rod.nodes], item.cable.dimension)
    ends = np.append(0.0, np.cumsum(item.cable.element_lengths))
    masses = [*item.cable.point_masses]
    found = [(places[node], mass) for node, mass in contents.mass_points.values() if node in places]
    masses += [PointMass(float(ends[place]), mass, has_weight=False) for place, mass in found]
    indices = np.array(mbs.systemData.GetObjectLTGODE2(number))
    if item.cable.closed:
        indices = np.append(indices, indices[: 2 * item.cable.dimension])
    return CableInScene(
        cable=replace(item.cable, fixed=fixed, links=tuple(links), point_masses=tuple(masses)),
        item=item,
        indices=indices,
        loads=loads,
        moving=moving,
        reactions=_reactions(mbs, item, constraints, places, len(links) - len(rods)),
        number=number,
        name=name,
    )


def _require_references(mbs: Any, cables: Iterable[CableInScene]) -> None:
    """Raise SceneError if a node has another reference than its cable was created with.

    Also one that was set after mbs.Assemble: native elements have it at once.
    """
    all_of_them = np.asarray(mbs.systemData.GetODE2Coordinates(exudyn.ConfigurationType.Reference))
    for scene_cable in cables:
        created, names = scene_cable.cable.reference, scene_cable.item.node_names
        of_nodes = [mbs.GetNodeParameter(node, "referenceCoordinates") for node in names]
        present = all_of_them[scene_cable.indices], np.asarray(of_nodes)
        changes = np.max([np.abs(q.reshape(created.shape) - created).max(axis=(1, 2)) for q in present], 0)
        k = int(changes.argmax())
        if changes[k] > COINCIDENT:
            raise SceneError(
                f"referenceCoordinates of node {names[k]} of cable "
                f"'{scene_cable.name}' were changed by {changes[k]:.3g} (limit {COINCIDENT:g}), but its "
                "elements keep the shape that they were created with: create the cable in the new shape, or "
                "set initialCoordinates."
            )


def _reactions(
    mbs: Any, item: CableItem, constraints: dict[int, Constraint], places: dict[int, int], first_rod: int
) -> list[Reaction]:
    """Of supports, motions and rods.   first_rod: place of the first rod among the links."""
    reactions, size = [], 2 * item.cable.dimension
    for number, constraint in constraints.items():
        row = int(mbs.systemData.GetObjectLTGAE(number)[0])
        first = size * places[constraint.nodes[0]]
        if isinstance(constraint, HeldCoordinate):
            reactions.append(Reaction(row, first + constraint.coordinate, constraint.gradient))
        elif isinstance(constraint, MovingCoordinate):
            reactions.append(Reaction(row, first + constraint.axis, 1.0))
        else:
            reactions.append(Reaction(row, first_rod))
            first_rod += 1
    return reactions


def _supports(
    item: CableItem, held: Iterable[HeldCoordinate], places: dict[int, int], name: str
) -> tuple[np.ndarray, list[Link]]:
    """(n, 2) held nodes, and links where only some coordinates of a position or slope are held."""
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
        described_node = f"node {node} of cable '{name}'"
        fixed[k] = supports_of_flags(described_node, flags[k], reference[k], item.cable.stretches)
        for j in np.flatnonzero(~fixed[k]).tolist():
            axes = np.flatnonzero(flags[k, j]).tolist()
            links += prescribed(k, rest(reference[k, j]), axes, of_slope=j == 1)
    if item.cable.closed:
        fixed[-1] = fixed[0]
    return fixed, links


def initial_states(mbs: Any, cables: Iterable[CableInScene]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Total coordinates and velocities (n, 2, dim) of each cable in the initial configuration."""
    configuration = exudyn.ConfigurationType.Initial
    all_q = np.asarray(mbs.systemData.GetODE2Coordinates(configuration))
    all_v = np.array(mbs.systemData.GetODE2Coordinates_t(configuration))
    states = []
    for scene_cable in cables:
        _share_velocities(mbs, scene_cable.item, all_q, all_v)
        reference = scene_cable.cable.reference
        q, v = all_q[scene_cable.indices], all_v[scene_cable.indices]
        states.append((reference + q.reshape(reference.shape), v.reshape(reference.shape)))
    return states


def _share_velocities(mbs: Any, item: CableItem, q: np.ndarray, v: np.ndarray) -> None:
    """Give a cable's own nodes the velocities of the shared ones, which the user knows, if both coincide.

    q, v: (n,) displacements, and velocities in place, of the whole system.
    """
    for node in shared_coordinates(mbs, [item]):
        if np.allclose(q[node.own], q[node.shared] + node.offset, rtol=0.0, atol=COINCIDENT):
            v[node.own] = v[node.shared]
