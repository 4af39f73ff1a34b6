"""Mass points, rigid bodies, and masses with one coordinate, as records."""

from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, collected
from ...items.arguments import described
from ...multibody.bodies import BODY, MOST, place_body
from ..bodies import Body
from ..coordinates import CoordinateMap
from .unknown import UnknownItemError, require_no_functions

# node type -> numbers of translations and rotations
_COORDINATES = {
    "1D": (1, 0),
    "Point2D": (2, 0),
    "Point": (3, 0),
    "RigidBody2D": (2, 1),
    "RigidBodyRxyz": (3, 3),
    "RigidBodyEP": (3, 4),
}
_TREE = "KinematicTree"
_OF_MATRICES = {"GenericODE2", _TREE}  # objects whose coordinates are nothing but coordinates
_POINTS = {"Point", "Point2D"}  # nodes, each of which is one body: markers lie there
_NODES = {*_POINTS, "1D", "GenericODE2"}  # whose masses are those of their coordinates
MOST_CONDITION = 1e15  # of a mass
_OBJECTS = {"Mass1D", "RotationalMass1D", "MassPoint", "MassPoint2D", "RigidBody2D", "RigidBody"}
# numbers of translations and rotations -> directions in which a body can move, of the frame of the body
_FREE = {
    **{(size, 0): list(range(size)) for size in range(1, MOST + 1)},
    (2, 1): [0, 1, 5],
    (3, 3): [0, 1, 2, 3, 4, 5],
    (3, 4): [0, 1, 2, 3, 4, 5],
}


def read_body_records(
    mbs: Any, bodies: Sequence[Body], coordinates: CoordinateMap, q: Array, may_change: bool
) -> tuple[Any, dict[int, int], dict[int, Body], dict[int, int]]:
    """Records (B,), those that turn by quaternions first.

    Args:
        mbs: in the configuration q (n,).   bodies: all objects with mass but the cables.
        may_change: whether Exudyn may say masses at each evaluation.

    Returns:
        records, their numbers by those of the objects (those of matrices have any number of records, and no
        number), bodies whose masses Exudyn says by numbers of records, and numbers of trees as of others.

    Raises:
        UnknownItemError: one has no compiled form.
    """
    found: list[tuple[Body, bool, Any]] = []  # whether it has one record, and this
    for body in bodies:
        data = mbs.GetObject(body.number)
        if data["objectType"] in _OF_MATRICES:
            own = _bodies_of_matrix(mbs, body, data, coordinates, may_change)
            found += [(body, False, record) for record in own]
        else:
            found.append((body, True, _read_body(mbs, body, data, coordinates, q)))
    found.sort(key=lambda one: one[2]["rotations"] != 4)
    records = collected(BODY, [record for _, _, record in found])
    places = {place for body in bodies for place in body.coordinates.tolist()}
    if int((records["translations"] + records["rotations"]).sum()) > len(places):
        raise UnknownItemError("two bodies on one node")
    numbers = {body.number: k for k, (body, is_alone, _) in enumerate(found) if is_alone}
    of_matrices = ((k, body) for k, (body, is_alone, _) in enumerate(found) if not is_alone)
    changing = {k: body for k, body in of_matrices if not body.has_constant_mass}
    kinds = {k: mbs.GetObject(body.number)["objectType"] for k, body in changing.items()}
    trees = {changing.pop(k).number: k for k, kind in kinds.items() if kind == _TREE}
    return records, numbers, changing, trees


class ChangingMass(NamedTuple):
    """A mass that follows the configuration: Exudyn says it at each evaluation.

    record: number of the body's one.   body: that Exudyn evaluates.   block: (k, k) its mass there.
    """

    record: int
    body: Body
    block: Array


def weigh(mbs: Any, masses: Sequence[ChangingMass], memories: Sequence[Any]) -> None:
    """Give records of bodies the masses of mbs's configuration.   memories: records of bodies, to be set."""
    for record, body, block in masses:
        size = len(block)
        block[:] = body.mass(mbs)
        inverse = np.linalg.inv(block)
        for bodies in memories:
            bodies["mass"][record, :size, :size] = block
            bodies["inverse"][record, :size, :size] = inverse


def first_order_records(first: int, number: int) -> Any:
    """(number,) records of first order states, as velocities of unit masses.   first: place of the first."""
    records = np.zeros(number, BODY)
    records["first"], records["translations"] = first + np.arange(number), 1
    records["orientation"], records["mass"][:, 0, 0], records["inverse"][:, 0, 0] = np.eye(3), 1.0, 1.0
    return records


def _read_body(mbs: Any, body: Body, data: dict[str, Any], coordinates: CoordinateMap, q: Array) -> Any:
    name = described(data, body.number)
    if data["objectType"] not in _OBJECTS:
        raise UnknownItemError(name)
    require_no_functions(data, name)
    node = mbs.GetNode(data["nodeNumber"])
    if node["nodeType"] not in _COORDINATES:
        raise UnknownItemError(f"{name} on a node {node['nodeType']}")
    kind = _COORDINATES[node["nodeType"]]
    places = coordinates.all_places(body.coordinates).tolist()
    record, fields = _new_record(name, places, kind, np.asarray(node["referenceCoordinates"], dtype=float))
    place_body(fields, q)
    if not (body.has_constant_mass or body.tells_mass):
        raise UnknownItemError(f"{name}, of which Exudyn does not tell the mass")
    mass = body.initial_mass if body.has_constant_mass else body.mass(mbs)
    if not set_mass(fields, mass_in_frame(fields, mass)):
        raise UnknownItemError(f"{name}, which has no mass in one direction")
    return record


def _new_record(
    name: str, places: Sequence[int], kind: tuple[int, int], reference: Array
) -> tuple[Any, SimpleNamespace]:
    """A record without mass, and its fields, which are read faster; UnknownItemError unless it is one block.

    places: of its coordinates in the vectors of all parts.   kind: numbers of translations and rotations.
    """
    if list(places) != list(range(places[0], places[0] + sum(kind))) or places[0] < 0:
        raise UnknownItemError(f"{name}, whose coordinates are held, or do not follow each other")
    records = np.zeros(1, BODY)
    records["first"], records["translations"], records["rotations"] = places[0], *kind
    fields = SimpleNamespace(**{name: records[name][0] for name in BODY.names or ()})
    fields.reference[: kind[0]] = reference[: kind[0]]
    fields.reference[3 : 3 + kind[1]] = reference[kind[0] :][: kind[1]]
    fields.orientation[:] = np.eye(3)
    fields.rates[2, 0] = fields.inverse_rates[0, 2] = 1.0  # in the plane
    return records[0], fields


def _bodies_of_matrix(
    mbs: Any, body: Body, data: dict[str, Any], coordinates: CoordinateMap, may_change: bool
) -> Iterator[Any]:
    """Records of an object: one for those coordinates that its mass matrix couples, or of a node of points.

    Raises:
        UnknownItemError: the mass changes, or couples too many coordinates, or such as turn.
    """
    name = described(data, body.number)
    numbers = data["nodeNumbers"] if "nodeNumbers" in data else [data["nodeNumber"]]
    nodes = [mbs.GetNode(number) for number in numbers]
    if not all(node["nodeType"] in _NODES for node in nodes):
        raise UnknownItemError(f"{name} on nodes that turn")
    is_told = data["objectType"] == _TREE or (may_change and body.tells_mass)
    if not (body.has_constant_mass or is_told):
        raise UnknownItemError(f"{name}, whose mass changes")
    places = coordinates.all_places(body.coordinates)
    reference = np.concatenate([node["referenceCoordinates"] for node in nodes])
    first = _first_of_each(_coupled(body, nodes))
    for own in (np.flatnonzero(first == label) for label in np.unique(first)):
        size = len(own)
        if size > MOST:
            raise UnknownItemError(f"{name}, whose mass couples more than {MOST} coordinates")
        record, fields = _new_record(name, places[own].tolist(), (size, 0), reference[own])
        mass = np.zeros((MOST, MOST))
        mass[:size, :size] = body.initial_mass[np.ix_(own, own)]
        if not set_mass(fields, mass):
            raise UnknownItemError(f"{name}, which has no mass in one direction")
        yield record


def _first_of_each(meet: np.ndarray) -> np.ndarray:
    """(n,) the first of the coordinates that belong together.   meet: (n, n) which are neighbours."""
    meet = meet | meet.T
    before, first = np.full(len(meet), -1), np.arange(len(meet))
    while (before != first).any():
        before, first = first, np.minimum(first, np.where(meet, first, len(meet)).min(axis=1))
        first = first[first]
    return first


def _coupled(body: Body, nodes: Sequence[dict[str, Any]]) -> np.ndarray:
    """(n, n) which coordinates belong together; all, if other ones may do so later."""
    meet, begin = (body.initial_mass != 0.0) | (not body.has_constant_mass), 0
    for node in nodes:
        end = begin + len(node["referenceCoordinates"])
        meet[begin:end, begin:end] |= node["nodeType"] in _POINTS
        begin = end
    return meet


def set_mass(body: Any, mass: Array) -> bool:
    """Give a record this mass (k, k); returns whether that resists in all directions."""
    body.mass[: len(mass), : len(mass)] = mass
    rows = np.array(_FREE[int(body.translations), int(body.rotations)])[:, None]
    among = rows, rows.T
    own = mass[among]
    sizes = np.linalg.eigvalsh(own)
    if not sizes[-1] < MOST_CONDITION * sizes[0]:
        return False
    body.inverse[among] = np.linalg.inv(own)
    return True


def mass_of_parameters(data: dict[str, Any]) -> Array:
    """(6, 6) mass matrix, in its frame, of a mass point or rigid body, from the parameters of the object."""
    mass, total, in_plane = np.zeros((6, 6)), data["mass"], data["objectType"].endswith("2D")
    mass[range(3 - in_plane), range(3 - in_plane)] = total
    if "inertia" not in data:
        return mass
    x, y, z = np.append(total * np.asarray(data["centerOfMass"]), 0.0)[:3]
    lever = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
    mass[:3, 3:], mass[3:, :3] = lever, lever.T
    if in_plane:
        mass[5, 5] = data["inertia"]
    else:
        xx, yy, zz, yz, xz, xy = data["inertia"]
        mass[3:, 3:] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return mass


def mass_in_frame(body: Any, mass: Array) -> Array:
    """(6, 6) mass matrix in the frame of a body that is placed, from that of its coordinates."""
    translations, rotations = int(body.translations), int(body.rotations)
    moves = np.zeros((translations + rotations, 6))
    moves[:translations, :3] = body.orientation[:translations]
    moves[translations:, 3:] = body.inverse_rates[:rotations]
    result: Array = moves.T @ mass @ moves
    if translations == 2:  # what the static moments do out of the plane, for centrifugal forces within
        result[2, 3] = result[3, 2] = -result[0, 5]
        result[2, 4] = result[4, 2] = -result[1, 5]
    return result
