"""From the records of a scene's items to its system."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, copy_of
from ..called_system import Called, behind, called_as, called_part
from .build_joints import build_joints
from .build_nodes import Ends, ends_of_cables
from .cables import Cables, provide_cables, provide_damping, show_matrix
from .circle_contacts import add_contacts, check_friction
from .connectors import Connectors, add_connectors
from .dashpots import rows_of_dashpots
from .implicit_contacts import add_contact, complete_contacts, mark_implicit, press, reconsider_contacts
from .points import move_rare_points, place_rare_points
from .ramps import ramps_of
from .rows import ROW
from .scene import Items, SceneSystem
from .sliding import Sliders, span_chains
from .trees import Trees

_OF_CONTACTS = add_contacts, check_friction, press, complete_contacts, reconsider_contacts

FunctionOfTime = Callable[[Sequence[float]], Array]
"""Times (T,) [s] -> (T, 3) numbers that depend on the time alone."""


@dataclass(frozen=True, eq=False)
class KnownItems:
    """All but the cables: records, and functions of time that rows refer to, three numbers each.

    data: see `Items`, at the start.
    """

    bodies: Any
    links: Any
    points: Any
    sliders: Sliders
    rows: Any
    connectors: Any
    linear_forces: Any
    loads: Any
    contacts: Any
    data: Array
    functions: Sequence[FunctionOfTime]


def build_scene(
    cables: Cables,
    chains: Sequence[Any],
    places: Sequence[slice],
    known: KnownItems,
    size: int,
    zeta: float,
    drift_correction: Array,
    still: np.ndarray,
    path: Array,
) -> SceneSystem:
    """The system of a scene.

    Args:
        cables: systems of all cables.   chains: the same ones, see `in_few_chains`.
        places: of each cable among the coordinates.   known: the items.   size: number of coordinates.
        zeta: stabilisation rate [1/s].   drift_correction: (m,) memory, see `CoupledSystem`.
        still: (n_cables,) coordinates of cables that supports hold.   path: see `Items`.
    """
    ends = _ends(chains, places, known.sliders)
    joints = build_joints(places, known.bodies, known.points, known.rows, drift_correction, still, ends)
    force, given, predicted = np.zeros((3, size))
    implicit = mark_implicit(cables, chains, known.contacts.records)
    if len(joints.nodes.dof):
        provide_cables(cables, chains, show_matrix)
    if len(joints.rows):
        provide_damping(cables, chains)
    if implicit:
        provide_cables(cables, chains, add_contact)
    trees, sliders, springs, contacts = _called_parts(known, cables)
    acting = known.connectors, known.linear_forces, known.loads
    called = springs, contacts
    records = known.bodies, trees, known.points, sliders, *acting, *called, known.data, known.data[:1].copy()
    memory = force, given, predicted, path, np.zeros(3, np.int64)
    items = Items._make((*records, ramps_of(*acting, known.points), joints, *memory))
    number = places[-1].stop if places else 0
    ahead = np.repeat(cables.inputs[:-1] - cables.dofs[:-1], np.diff(cables.dofs))  # motions of those before
    of_cables = np.zeros(cables.inputs[-1]), np.arange(number) + ahead
    unjoined, left = np.zeros((2, size))
    return SceneSystem(cables, number, *of_cables, unjoined, left, items, zeta)


def _called_parts(known: KnownItems, cables: Cables) -> tuple[Called, ...]:
    """Trees, sliders, springs and contacts."""
    trees = Trees(known.links, known.bodies, known.points)
    sliders = known.sliders._replace(points=known.points)
    contacts = known.contacts._replace(points=known.points, cables=cables)
    placed = (called_part(one, place_rare_points, move_rare_points) for one in (trees, sliders))
    springs = called_part(Connectors(known.connectors, known.points, known.data), add_connectors)
    return *placed, springs, called_part(contacts, *_OF_CONTACTS)


def with_dashpots(
    system: SceneSystem, chains: Sequence[Any], places: Sequence[slice], still: np.ndarray
) -> SceneSystem | None:
    """The same one, with rows for its dashpots; None if it has none.   Arguments: see `build_scene`.

    Drift corrections of its joints are then the first ones of a longer memory.
    """
    items, joints = system.items, system.items.joints
    dashpots = rows_of_dashpots(items.connectors)
    if not len(dashpots):
        return None
    drift_correction = np.concatenate([joints.drift_correction, np.zeros(len(dashpots))])
    holding = len(joints.rows)
    rows = np.zeros(holding + len(dashpots), ROW)
    rows[:holding], rows[holding:] = joints.rows, dashpots
    sliders = behind(items.sliders)
    span_chains(sliders)
    given = places, items.bodies, items.points, rows, drift_correction, still
    built = build_joints(*given, _ends(chains, places, sliders), holding)
    if len(built.nodes.dof):
        provide_cables(system.cables, chains, show_matrix)
    provide_damping(system.cables, chains)
    return system._replace(items=items._replace(joints=built))


def _ends(chains: Sequence[Any], places: Sequence[slice], sliders: Sliders) -> Ends:
    """Of cables whose nodes can be unknowns."""
    return _without(ends_of_cables(chains, places), places, sliders.records["first"].tolist())


def held_coordinates(systems: Sequence[Any]) -> np.ndarray:
    """(n_cables,) which coordinates of cables their supports hold."""
    chains = [system.chain for system in systems]
    held = [np.repeat(chain.nodes["free"].ravel() == 0.0, len(chain.axes)) for chain in chains]
    return np.concatenate([np.zeros(0, dtype=bool), *held])


def _without(ends: Ends, places: Sequence[slice], firsts: Sequence[int]) -> Ends:
    """Without cables on which points slide: these may be anywhere.   firsts: a coordinate of each."""
    kept = {
        cable: own
        for cable, own in ends.of_cables.items()
        if not any(places[cable].start <= first < places[cable].stop for first in firsts)
    }
    return ends._replace(of_cables=kept)


def copied(memory: Any, copies: dict[int, Any]) -> Any:
    """The same named tuple of such tuples and arrays, with copies of its arrays, and of what is called.

    copies: by identity, what takes the place of an array or a tuple; copies of arrays are added.
    """
    if id(memory) in copies:
        return copies[id(memory)]
    if isinstance(memory, Called):
        return called_as(memory, copied(behind(memory), copies))
    if isinstance(memory, np.ndarray):
        copies[id(memory)] = copy_of(memory)
        return copies[id(memory)]
    if not isinstance(memory, tuple):
        return memory
    return type(memory)(*[copied(one, copies) for one in memory])
