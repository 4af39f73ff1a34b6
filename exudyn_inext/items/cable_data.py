"""What an inextensible cable in an mbs is, and how it is found there again."""

from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

import exudyn
import numpy as np

from ..cable.cable import Cable
from ..checks import as_number
from ..element.shape_functions import shape_functions
from ..errors import InputError
from ..scene.model import CableItem
from .arguments import node_number, object_number, require_system

POINTS_PER_ELEMENT = 6
COLOUR = [0.0, 0.45, 0.7, 1.0]


def cable_graphics(cable: Cable, nodes: Sequence[int]) -> Any:
    """Graphics user function that draws the Hermite curve through the nodes."""
    weights = [
        shape_functions(np.linspace(0, 1, POINTS_PER_ELEMENT), length) for length in cable.element_lengths
    ]

    def draw_cable(mbs: Any, itemNumber: int) -> list[dict[str, Any]]:
        what = exudyn.OutputVariableType.Coordinates, exudyn.ConfigurationType.Visualization
        displacements = [mbs.GetNodeOutput(node, *what) for node in nodes]
        q = cable.reference + np.reshape(displacements, cable.reference.shape)
        curve = np.concatenate([s.T @ np.concatenate([q[k], q[k + 1]]) for k, s in enumerate(weights)])
        points = np.zeros((len(curve), 3))
        points[:, : cable.dimension] = curve
        return [{"type": "Line", "color": COLOUR, "data": points.ravel().tolist()}]

    return draw_cable


def carrying_graphics(item: CableItem) -> Any:
    """The graphics user function of the cable's object: it also carries the cable's data.

    Every way of enforcement has it, and switching forces or mass of the object off leaves it alone.
    """
    draw = cable_graphics(item.cable, item.node_names)
    draw.cable_item = item
    return draw


def find_cable_item(object_data: dict[str, Any]) -> CableItem | None:
    """The cable behind mbs.GetObject(...) data, or None if the object is something else."""
    if object_data["objectType"] != "GenericODE2":
        return None
    function = object_data["VgraphicsDataUserFunction"]
    return getattr(function["function"], "cable_item", None) if isinstance(function, dict) else None


def belongs_to_a_cable(object_data: dict[str, Any]) -> bool:
    """Whether mbs.GetObject(...) data is a constraint object that enforces a cable's inextensibility."""
    if object_data["objectType"] != "ConnectorCoordinateVector":
        return False
    function = object_data["constraintUserFunction"]
    return isinstance(function, dict) and hasattr(function["function"], "enforces_inextensibility")


_objects: WeakKeyDictionary[Any, dict[int, int]] = WeakKeyDictionary()  # of cables, by their nodes


def remember_nodes(mbs: Any, nodes: Sequence[int], number: int) -> None:
    """Object `number` is a cable on these nodes."""
    _objects.setdefault(mbs, {}).update(dict.fromkeys(map(int, nodes), int(number)))


def cable_of_node(mbs: Any, node: int) -> CableItem | None:
    """The cable that a node belongs to, or None."""
    count = mbs.systemData.NumberOfObjects()
    remembered = _objects.get(mbs, {}).get(node, count)
    for number in (remembered, *range(count)):  # the system may have been built anew
        item = find_cable_item(mbs.GetObject(number)) if number < count else None
        if item is not None and node in item.nodes:
            return item
    return None


def require_cable(mbs: Any, cable: Any) -> tuple[int, CableItem]:
    """Object number and item of a cable of mbs.

    Args:
        cable: what CreateInextensibleCable returned, or the number of its object.

    Raises:
        InputError: mbs is no system, `cable` neither of the two, or not in mbs (any more).
    """
    require_system(mbs)
    elements = cable.get("elements") if isinstance(cable, dict) else [cable]
    number = object_number(elements[0]) if isinstance(elements, list) and elements else -1
    if number < 0:
        raise InputError(
            f"cable = {cable!r}: must be what CreateInextensibleCable returned, or its object number."
        )
    item = _item_of_object(mbs, number)
    if isinstance(cable, dict) and not _is_of_nodes(item, cable.get("nodes")):
        raise InputError(
            f"cable = {cable!r}: object {number} of mbs lies on the nodes {list(item.given_nodes)}; use what "
            "CreateInextensibleCable returned for this mbs, after its last Reset()."
        )
    return number, item


def _item_of_object(mbs: Any, number: int) -> CableItem:
    exists = number < mbs.systemData.NumberOfObjects()
    item = find_cable_item(mbs.GetObject(number)) if exists else None
    if item is None:
        raise InputError(f"object {number} is no inextensible cable: use CreateInextensibleCable's result.")
    return item


def _is_of_nodes(item: CableItem, nodes: Any) -> bool:
    is_list = isinstance(nodes, list) and len(nodes) == len(item.nodes)
    return is_list and all(node_number(n) == m for n, m in zip(nodes, item.given_nodes, strict=True))


def point_on_cable(arc_length: Any, length: float) -> float:
    """A checked arc length [m] on a cable of that length; InputError if it is beyond."""
    x = as_number(arc_length)
    if not 0.0 <= x <= length * (1.0 + 1e-12):
        raise InputError(
            f"arcLength = {arc_length!r} m is not on the cable: it runs from 0 to {length:.9g} m."
        )
    return x
