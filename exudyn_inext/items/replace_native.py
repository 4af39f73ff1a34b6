"""ReplaceNativeCables: cables in the place of the native ANCF elements of an mbs, on the same nodes."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from exudyn.itemInterface import NodePoint2DSlope1, NodePointSlope1

from ..cable.cable import Cable
from ..checks import require_flag
from ..errors import InputError, SceneError
from ..scene.model import CableItem
from .arguments import described, object_number, require_system
from .attach.companions import forget_companions
from .attach.inert import ANCF_CABLES, INERT, is_inert_cable
from .attach.shared_node import SharedNode, shared_node
from .attach.user_forces import add_user_forces, user_forces_of
from .cable_data import find_cable_item
from .cable_item import add_object, cable_of
from .enforcement import find_enforcement
from .native_chains import FUNCTIONS, Elements, NativeChain, native_chains, section_of
from .shape import check_shape
from .template import InextensibleCable, stiffness_left_out


def ReplaceNativeCables(mbs: Any, extensible: bool = True, objectNumbers: Any = None) -> list[dict[str, Any]]:
    """Let cables of this package take the place of native ANCF elements, so that SolveExplicit moves them.

    A script that builds ObjectANCFCable2D or ObjectANCFCable, in whatever way, needs this one line before
    mbs.Assemble(). Elements of the same section in a row become one cable on their nodes. They stay in mbs
    without mass and stiffness, as companions (see `CreateCompanionCables`): markers, loads, sensors, sliding
    joints and contact that were put on them act on the cable now. Sensors of their section forces and
    energies show zero, of which a warning tells; `CreateCableForceSensor` and `CreateCableEnergySensor` take
    the returned dicts. Where elements branch, or the section changes, cables share a node.

    Args:
        mbs: the system, with all of its elements; call mbs.Assemble() afterwards.
        extensible: whether the cables have the axial stiffness, axial damping and reference strain of the
            elements; otherwise they keep their length.
        objectNumbers: of the elements that are replaced; None: all of mbs.

    Returns:
        for each cable a dict as of CreateInextensibleCable: 'nodes', 'elements' (its object),
        'nodePositions', 'constraintObjects' (joints of shared nodes), 'loads' (none).

    Raises:
        InputError: no such element, or one without counterpart, see `InextensibleCable` and `CableShape`;
            mbs is unchanged then.

    Example:
        GenerateStraightLineANCFCable2D(mbs, [0, 0, 0], [1, 0, 0], 8, template, [0, -9.81, 0], [1, 1, 0, 0])
        cables = ReplaceNativeCables(mbs)
        mbs.Assemble()
        SolveExplicit(mbs, simulationSettings)
    """
    require_system(mbs)
    stretches = require_flag("extensible", extensible)
    objects = [mbs.GetObject(number) for number in range(mbs.systemData.NumberOfObjects())]
    taken = {node for data in objects if (item := find_cable_item(data)) for node in item.nodes}
    chains = native_chains(_elements(objects, objectNumbers), taken)
    made = [_add(mbs, new, taken) for new in [_replacement(mbs, chain, stretches) for chain in chains]]
    forget_companions(mbs)
    return made


def _elements(objects: Sequence[dict[str, Any]], given: Any) -> Elements:
    """Native elements with mass or stiffness, by their numbers.

    objects: data of all.   given: objectNumbers.
    """
    found = {
        number: data
        for number, data in enumerate(objects)
        if data["objectType"] in ANCF_CABLES and not is_inert_cable(data)
    }
    if given is None and not found:
        raise InputError(
            "mbs has no ObjectANCFCable2D or ObjectANCFCable with a mass that could be replaced: "
            + (_of_moving_cables(objects) or "call ReplaceNativeCables after they were added, and once.")
        )
    return found if given is None else {number: found[number] for number in _chosen(given, found)}


def _of_moving_cables(objects: Sequence[dict[str, Any]]) -> str:
    """What to do with elements through which the cable moves, if there are any; otherwise empty."""
    numbers = [k for k, data in enumerate(objects) if data["objectType"] == "ALEANCFCable2D"]
    if not numbers:
        return ""
    return (
        f"{described(objects[numbers[0]], numbers[0])} is an element through which the cable moves (ALE), "
        "which has no counterpart; move this mbs by mbs.SolveDynamic."
    )


def _chosen(given: Any, found: Elements) -> list[int]:
    """Numbers of elements among those that were found."""
    is_list = isinstance(given, list | tuple | np.ndarray) and len(given) > 0
    for one in given if is_list else [given]:
        if object_number(one) not in found:
            raise InputError(
                f"objectNumbers = {given!r}: {one!r} is no ObjectANCFCable2D or ObjectANCFCable with a mass; "
                "give a list of numbers of such elements, or None for all of them."
            )
    return [object_number(one) for one in given]


@dataclass(frozen=True, eq=False)
class _Replacement:
    """A cable in the place of a chain, before anything is changed.

    section: of the cable.   functions: see `user_forces_of`.
    """

    chain: NativeChain
    section: InextensibleCable
    cable: Cable
    functions: dict[str, Any]


def _replacement(mbs: Any, chain: NativeChain, stretches: bool) -> _Replacement:
    """Raises InputError if there is none."""
    try:
        section = InextensibleCable.from_template(chain.template, stretches)
        shape = check_shape(chain.shape(mbs, "straight" if stretches else "shape"), stretches)
        functions, damped = user_forces_of(mbs, chain.template, section, chain.dimension)
        return _Replacement(chain, section, cable_of(damped, shape, chain.dimension), functions)
    except InputError as error:
        raise InputError(f"{chain.name}: {error}") from None


def _add(mbs: Any, new: _Replacement, taken: set[int]) -> dict[str, Any]:
    """Add the cable, and let the elements be its companions.   taken: nodes of cables, changed in place."""
    nodes, cable = list(new.chain.nodes), new.cable
    joined: dict[int, SharedNode] = {}
    for place, end in () if cable.closed else ((0, "Start"), (-1, "End")):
        if nodes[place] in taken:
            joined[place] = shared_node(mbs, end, nodes[place], has_slope=True)
            nodes[place] = _copied_node(mbs, nodes[place])
        taken.add(nodes[place])
    taken.update(nodes)
    way, shared = find_enforcement("projection"), {nodes[k]: node.number for k, node in joined.items()}
    free = np.zeros(cable.reference.shape, dtype=bool)
    item = CableItem(cable, np.zeros(cable.dimension), tuple(nodes), way.name, free, shared)
    item.left_out = stiffness_left_out(new.chain.template, new.section)
    made = add_object(mbs, item, way)
    for place, node in joined.items():
        made["constraintObjects"] += node.join(mbs, nodes[place], cable.reference[place, 1])
    nothing = dict.fromkeys(new.chain.section.keys() & {*INERT, *FUNCTIONS}, 0)
    for element, pair in zip(new.chain.elements, pairwise(item.node_names), strict=True):
        mbs.SetObjectParameter(element, "nodeNumbers", list(pair))
        for name in nothing:
            mbs.SetObjectParameter(element, name, 0)
    item.replaced = {number: _left(mbs.GetObject(number)) for number in new.chain.elements}
    add_user_forces(mbs, item, new.section, new.functions)
    return made


def _copied_node(mbs: Any, node: int) -> int:
    """A new node in the same state; its number."""
    data = mbs.GetNode(node)
    node_type = NodePoint2DSlope1 if data["nodeType"] == "Point2DSlope1" else NodePointSlope1
    names = "referenceCoordinates", "initialCoordinates", "initialVelocities"
    return int(mbs.AddNode(node_type(**{name: list(data[name]) for name in names})))


def _left(data: dict[str, Any]) -> dict[str, Any]:
    """Properties of an element that a cable replaced.   data: of the object."""
    return section_of(data) | {"length": data["length"], "nodeNumbers": _nodes(data)}


def _nodes(data: dict[str, Any]) -> list[int]:
    return [*map(int, data.get("nodeNumbers", ()))]


def require_as_replaced(item: CableItem, name: str, objects: Sequence[dict[str, Any]]) -> None:
    """Raise SceneError if an element that a cable replaced has got other properties or numbers since then.

    name: of the cable.   objects: data of all of mbs.
    """
    for number, left in item.replaced.items():
        data = objects[number] if number < len(objects) else {}
        if _nodes(data) != left["nodeNumbers"]:
            raise SceneError(
                f"object {number} is no longer the element on nodes {left['nodeNumbers']}, in whose place "
                f"cable '{name}' is: delete items, if any, before ReplaceNativeCables is called."
            )
        present = _left(data)
        for what in (key for key in left if present[key] != left[key]):
            raise SceneError(
                f"{what} = {present[what]!r} was set of {described(objects[number], number)}, in whose place "
                f"cable '{name}' is, which would not have it: set it before ReplaceNativeCables is called, "
                "or leave all elements of that cable to Exudyn, by objectNumbers."
            )
