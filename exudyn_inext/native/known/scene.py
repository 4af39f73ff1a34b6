"""All items of a scene but its cables, if each has a compiled form."""

from collections.abc import Collection, Sequence, Set
from contextlib import nullcontext, suppress
from functools import cache, cached_property, lru_cache, partial
from typing import Any

import numpy as np

from ...arrays import Array, collected
from ...errors import SceneError
from ...items.arguments import described
from ...items.attach.inert import is_inert_cable
from ...items.functions_that_look import FunctionsOfSteps
from ...items.parameters import Parameter, markers_placed_by
from ...multibody.build import KnownItems
from ...multibody.connectors import CONNECTOR
from ...multibody.linear_forces import LINEAR_FORCE
from ...multibody.loads import LOAD
from ...multibody.points import POINT
from ...multibody.ramps import CONNECTORS, LINEAR_FORCES, LOADS, POINTS, Numbers
from ...multibody.scene import Items
from ...run.compiled_scene import ChangedItem
from ...run.load_functions import Asked
from ...run.moved_offsets import MovedOffsets
from ...run.spring_functions import AskedSpring
from ..coordinates import CoordinateMap
from ..evaluated_scene import SceneOfExudyn
from .bodies import (
    ChangingMass,
    first_order_records,
    mass_of_parameters,
    read_body_records,
    set_mass,
    weigh,
)
from .connectors import VALUES, KnownConnector, read_connector
from .contacts import ContactReader
from .general_contacts import read_general_contacts
from .joints import is_joint, read_rows
from .linear_forces import OF_MATRICES, read_linear_forces
from .loads import KnownLoad, read_load
from .points import PointReader
from .trees import ACTING, ActingOnTree, read_links
from .unknown import UnknownItemError

_WEIGHT = "MassProportional"  # load
_FORCES = "load", "loadVector"


def read_known_items(
    scene: SceneOfExudyn, q: Array, has_forces: bool, follows_state: bool
) -> tuple[KnownItems, "KnownNumbers"]:
    """Read all items but the cables; and by their numbers, those that may be read again.

    Args:
        scene: whose mbs is in the configuration q (n,).
        has_forces: whether springs, contacts and loads are read, and there are no states of first order.
        follows_state: whether functions of loads may depend on the state.

    Raises:
        UnknownItemError: an item has no compiled form.
    """
    mbs, bodies, coordinates, moved = scene.mbs, scene.bodies, scene.map, scene.moved
    states = mbs.systemData.ODE1Size()
    if has_forces and states:
        raise UnknownItemError("states of first order")
    records, of_bodies, changes, trees = read_body_records(mbs, bodies, coordinates, q, not has_forces)
    mass, start = scene.body_system.mass_at, coordinates.slices[-1].start
    changing = [ChangingMass(k, body, mass(int(records["first"][k]) - start)) for k, body in changes.items()]
    if states:
        records = np.append(records, first_order_records(len(coordinates.indices), states))
    links = read_links(mbs, trees, records)
    reader = PointReader(mbs, coordinates, start, records, of_bodies, links, trees)
    rows, functions, of_moved, movable, sliders = read_rows(mbs, scene.joints, reader, moved)
    if of_moved.steered and not has_forces:
        raise UnknownItemError("joints whose functions read what step functions change")
    of_cables = (part.cable.number for part in scene.cables)
    done = {*of_bodies, *scene.elsewhere, *of_cables, *(joint.number for joint in scene.joints)}
    others = 3 * (len(functions) + len(of_moved.joints))
    items = KnownNumbers(mbs, coordinates, reader, others, of_moved, movable, of_bodies, follows_state)
    items.changing_masses, items.trees = changing, trees
    ends = (place.stop for place in coordinates.slices)
    sections = [(end, part.cable.cable.section) for end, part in zip(ends, scene.cables, strict=False)]
    touching = ContactReader(mbs, reader, scene.friction.numbers, sections)
    if has_forces:
        for number in range(mbs.systemData.NumberOfObjects()):
            if number not in done and not touching.adds(number):
                items.add_object(number)
        for number in range(mbs.systemData.NumberOfLoads()):
            items.add_load(number)
    springs, loads = collected(CONNECTOR, items.connectors), collected(LOAD, items.loads)
    data = touching.data(bool((springs["place"] >= 0).any()))
    evaluate = scene.native_items.evaluate
    general = read_general_contacts(mbs, reader, moved, evaluate) if has_forces else None
    if general and data.size:
        raise UnknownItemError("GeneralContact beside what keeps data: circles, or springs that turn or rub")
    contacts = general or touching.contacts(scene.friction.sums, data)
    placed = records, links, reader.records, sliders, rows
    return KnownItems(*placed, springs, items.linear_forces, loads, contacts, data, functions), items


class KnownNumbers:
    """Items as records, by their numbers, so that they can be read again.

    connectors, loads: records, in the order in which they were added.   moved, movable: see `read_rows`.
    bodies: number of the record of each body, by that of the object.
    functions: those of loads; each has three values, which follow the `others` of joints.
    """

    def __init__(
        self,
        mbs: Any,
        coordinates: CoordinateMap,
        reader: PointReader,
        others: int,
        moved: MovedOffsets,
        movable: Set[int],
        bodies: dict[int, int],
        follows_state: bool,
    ) -> None:
        self._mbs, self._coordinates, self._reader = mbs, coordinates, reader
        self._others, self.moved = others, moved
        self._movable, self._bodies = movable, bodies
        self._markers_placed_by = cache(partial(markers_placed_by, mbs))
        self._follows_state = follows_state
        self._asked_alone = FunctionsOfSteps(mbs) if follows_state else None
        self.connectors: list[Any] = []
        self.linear_forces: Any = np.zeros(0, LINEAR_FORCE)
        self.loads: list[Any] = []
        self.functions: list[Asked] = []
        self.asked_springs: dict[int, AskedSpring] = {}
        self.changing_masses: list[ChangingMass] = []
        self.trees: dict[int, int] = {}  # numbers of their records, by those of the objects
        self._on_trees: dict[int, tuple[slice, slice, ActingOnTree]] = {}  # places of springs and loads
        self._springs: dict[int, tuple[int, KnownConnector]] = {}  # place of each, by its number
        self._matrices: dict[int, slice] = {}  # places of their linear forces
        self._forces: dict[int, tuple[int, KnownLoad]] = {}
        self.places_of = lru_cache(self._places_of)

    def add_object(self, number: int) -> None:
        """A connector, or what does nothing; UnknownItemError if it has no compiled form."""
        data = self._mbs.GetObject(number)
        is_inert = data["objectType"] == "Ground" or is_inert_cable(data)
        if is_inert or self._reader.is_on_other_node(data):
            return
        if number in self.trees:
            self._add_tree(number)
            return
        if data["objectType"] == "GenericODE2":
            begin = len(self.linear_forces)
            self.linear_forces = np.append(self.linear_forces, self._read_matrices(number))
            self._matrices[number] = slice(begin, len(self.linear_forces))
            return
        acts = data.get("activeConnector", True) and not is_joint(data)  # those that hold axes are rows
        with nullcontext() if acts else suppress(UnknownItemError):  # to be switched on, it may be
            spring = read_connector(self._mbs, number, self._reader, self._asked_alone)
            self._set_spring(number, len(self.connectors), spring)
            self.connectors.append(spring.record)

    def _set_spring(self, number: int, place: int, spring: KnownConnector) -> None:
        self._springs[number] = place, spring
        self.asked_springs.pop(number, None)
        if spring.law:
            self.asked_springs[number] = spring.law._replace(place=place)

    def _add_tree(self, number: int) -> None:
        tree = ActingOnTree(self._mbs, number, self._reader.bodies[self.trees[number]], self._reader)
        springs, loads = len(self.connectors), len(self.loads)
        self.connectors += list(tree.springs)
        self.loads += list(tree.loads)
        self._on_trees[number] = slice(springs, len(self.connectors)), slice(loads, len(self.loads)), tree

    def add_load(self, number: int) -> None:
        """UnknownItemError if it has no compiled form."""
        read = read_load(self._mbs, number, self._reader, self._follows_state)
        if read is None:
            return
        if read.function is not None:
            read.record.function = self._others + 3 * len(self.functions)
            self.functions.append(read.function)
        self._forces[number] = len(self.loads), read
        self.loads.append(read.record)

    def weigh(self, memories: Sequence[Items]) -> None:
        """Masses that change, as mbs is; see `weigh`."""
        if self.changing_masses:
            weigh(self._mbs, self.changing_masses, [memory.bodies for memory in memories])

    def can_weigh(self, item: ChangedItem) -> bool:
        """Whether a body may get that mass, inertia or centre of mass between steps.

        The mass must be that of the parameters, and no function its weight.
        That of a planar body becomes one that depends on its angle if its centre leaves the node.
        """
        number = item[1]
        if number not in self._bodies or not Parameter(*item).is_mass:
            return False
        data = self._mbs.GetObject(number)
        if data["objectType"].endswith("1D"):
            return False
        is_planar = data["objectType"].endswith("2D")
        if Parameter(*item).is_centre and is_planar and not self._reader.has_lever(number):
            return False
        return all(self._forces[load][1].function is None for load in self._weights.get(number, ()))

    def can_move(self, number: int) -> bool:
        """Whether the offset of a joint may be set between steps."""
        return number in self.moved.joints

    def moves_springs_alone(self, markers: Collection[int], objects: Collection[int]) -> bool:
        """Whether these markers may get other places as springs and loads do other values.

        objects: that act on the markers.
        """
        return self._springs.keys() >= set(objects) and self._are_placeable(markers)

    def _are_placeable(self, markers: Collection[int]) -> bool:
        """Whether the points of markers may be placed again."""
        return all(map(self._reader.is_placeable, markers)) and not self._mbs.NumberOfGeneralContacts()

    def joints_to_move(self, markers: Collection[int], objects: Collection[int]) -> set[int] | None:
        """Those that have to be built as moved ones before these markers may get other places.

        objects: that act on the markers.   None: others act there, too, or they are markers of other kinds.
        """
        joints = set(objects) - self._springs.keys()
        if not (joints <= self._movable and self._are_placeable(markers)):
            return None
        return joints.difference(self.moved.joints)

    @cached_property
    def _weights(self) -> dict[int, list[int]]:
        """Loads that are proportional to the mass of a body, by the number of its object."""
        weights: dict[int, list[int]] = {}
        for load in self._forces:
            data = self._mbs.GetLoad(load)
            if data["loadType"] == _WEIGHT:
                body = int(self._mbs.GetMarkerParameter(data["markerNumber"], "bodyNumber"))
                weights.setdefault(body, []).append(load)
        return weights

    def read_again(self, item: ChangedItem, value: Any, memories: Sequence[Items]) -> bool:
        """Bring records of a changed item up to date; False if they cannot be.

        value: of the parameter.
        memories: of all systems that have them; connectors and loads are the same ones in all of them.
        """
        kind, number, name = item
        connectors, loads = memories[0].connectors, memories[0].loads
        if kind == "Object" and number in self._on_trees:
            if can := name in ACTING:
                own_springs, own_loads, tree = self._on_trees[number]
                tree.read_again(name, connectors[own_springs], loads[own_loads])
            return can
        if kind == "Object" and number in self._matrices:
            return name in OF_MATRICES and self._matrices_again(number, memories[0].linear_forces)
        if kind == "Object" and number in self._bodies:
            return self._weigh_again(number, memories)
        if kind in ("Marker", "Node") or number not in (self._forces if kind == "Load" else self._springs):
            return self._place_again(item, memories)
        try:
            is_known = (
                self._load_again(item, value, loads)
                if kind == "Load"
                else self._spring_again(item, value, connectors)
            )
        except UnknownItemError:
            return False
        return is_known and self._reader.number_of_points == len(memories[0].points)

    def _places_of(self, items: Sequence[ChangedItem]) -> Numbers:
        """Numbers of records that follow parameters, if nothing else does."""
        rows = sorted({row for item in items for row in self._rows_of(item)})
        found = [(kind, place) for kind, first, end in rows for place in range(first, end)]
        kind, place = np.array(found, np.int64).reshape(-1, 2).T.copy()
        return Numbers(kind, place, np.zeros(len(found)))

    def _rows_of(self, item: ChangedItem) -> list[tuple[int, int, int]]:
        """Kind, first and end of the numbers that follow a parameter."""
        kind, number, name = item
        found: list[tuple[int, Any, slice]] = []
        if kind == "Load" and name in _FORCES and number in self._forces:
            found = [(LOADS, LOAD, _one(self._forces[number]))]
        elif kind == "Object" and name in VALUES and number in self._springs.keys() - self.asked_springs:
            found = [(CONNECTORS, CONNECTOR, _one(self._springs[number]))]
        elif kind == "Object" and number in self._matrices and name in OF_MATRICES:
            found = [(LINEAR_FORCES, LINEAR_FORCE, self._matrices[number])]
        elif kind == "Object" and number in self._on_trees and name in ACTING:
            springs, loads, _ = self._on_trees[number]
            found = [(CONNECTORS, CONNECTOR, springs), (LOADS, LOAD, loads)]
        else:
            markers = self._markers_placed_by(Parameter(*item)) or ()
            places = filter(None, map(self._reader.place_of, markers))
            found = [(POINTS, POINT, _one((place.point, place))) for place in places]
        sizes = [(kind, record.itemsize // 8, own) for kind, record, own in found]
        return [(kind, size * own.start, size * own.stop) for kind, size, own in sizes]

    def _read_matrices(self, number: int) -> Any:
        return read_linear_forces(self._mbs, number, self._coordinates)

    def _matrices_again(self, number: int, linear_forces: Any) -> bool:
        linear_forces[self._matrices[number]] = self._read_matrices(number)
        return True

    def has_same_entries(self, number: int) -> bool:
        """Whether matrices of an object are zero where they were when they were read."""
        if number not in self._matrices:
            return True
        found, own = self._read_matrices(number), self.linear_forces[self._matrices[number]]
        return all(np.array_equal(found[name], own[name]) for name in ("row", "column"))

    def _place_again(self, item: ChangedItem, memories: Sequence[Items]) -> bool:
        markers = self._markers_placed_by(Parameter(*item))
        for marker in markers or ():
            self._reader.place_again(marker, [memory.points for memory in memories])
        return markers is not None

    def _weigh_again(self, number: int, memories: Sequence[Items]) -> bool:
        mass, loads = mass_of_parameters(self._mbs.GetObject(number)), memories[0].loads
        for memory in memories:
            body = memory.bodies[self._bodies[number]]
            if not set_mass(body, mass):
                raise SceneError(
                    f"{described(self._mbs.GetObject(number), number)} was given a mass that is none or "
                    "negative in some direction, in which explicit steps have nothing to accelerate: set a "
                    "small one. Inertia is that about the node, at least mass * distance^2 of the centre."
                )
            self._reader.centre_again(number, memory.points, body)
        for load in self._weights.get(number, ()):
            place, known = self._forces[load]
            self._forces[load] = place, known._replace(scale=mass[0, 0])
            item = "Load", load, "loadVector"
            self._load_again(item, Parameter(*item).value(self._mbs), loads)
        return True

    def _load_again(self, item: ChangedItem, value: Any, loads: Any) -> bool:
        _, number, name = item
        place, known = self._forces[number]
        if known.function is not None:
            return False
        if name in _FORCES:
            values = [known.scale * x for x in (value if isinstance(value, list) else np.ravel(value))]
            loads["constant"][place, : len(values)] = values
            return True
        read = read_load(self._mbs, number, self._reader)
        if read is None or read.function is not None:
            return False
        self._forces[number], loads[place] = (place, read), read.record
        self.places_of.cache_clear()
        return True

    def _spring_again(self, item: ChangedItem, value: Any, connectors: Any) -> bool:
        _, number, name = item
        place, known = self._springs[number]
        if name in VALUES:
            known.set(name, value, connectors[place])
            return True
        asked = self._asked_alone if self.asked_springs else None
        known = read_connector(self._mbs, number, self._reader, asked)
        self._set_spring(number, place, known)
        connectors[place] = known.record
        self.places_of.cache_clear()
        return True


def _one(known: tuple[int, Any]) -> slice:
    """The place of a record among all of them."""
    return slice(known[0], known[0] + 1)
