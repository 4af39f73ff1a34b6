"""Weight that companions give a cable: LoadMassProportional, element by element, as native cables take it.

A companion has no mass, so that Exudyn finds no force. The element of the cable has the mass that counts,
and point masses on it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..errors import SceneError
from ..loads.weight import ElementWeight
from ..scene.model import CableItem
from .attach.inert import nodes_of_inert_cable
from .load_items import course_of

_MASSES = ("mass", "massPerLength")  # parameters of objects

Elements = Mapping[tuple[int, ...], tuple[int, int]]  # nodes -> number of the cable's object, element


def elements_by_nodes(cables: Mapping[int, CableItem]) -> Elements:
    """Where companions may lie.   cables: by the numbers of their objects."""
    found: dict[tuple[int, ...], tuple[int, int]] = {}
    for number, item in cables.items():
        found |= {nodes: (number, k) for k, nodes in enumerate(pairwise(item.node_names))}
    return {nodes[::-1]: element for nodes, element in found.items()} | found


def read_weight(mbs: Any, number: int, data: dict[str, Any], elements: Elements) -> ElementWeight | None:
    """Load `number` of mbs as weight of an element, or None if it is something else.   data: of it.

    Raises:
        SceneError: a LoadMassProportional acts on what has no mass, and is no companion of an element.
    """
    if data["loadType"] != "MassProportional":
        return None
    body = mbs.GetObject(mbs.GetMarker(data["markerNumber"])["bodyNumber"])
    element = elements.get(nodes_of_inert_cable(body))
    if element is None:
        _require_mass(number, data, body)
        return None
    value, user_function = data["loadVector"], data["loadVectorUserFunction"]
    constant, history, is_pure = course_of(mbs, user_function, value)
    return ElementWeight(element[0], (element[1],), constant, history, is_pure, number)


def _require_mass(number: int, load: dict[str, Any], body: dict[str, Any]) -> None:
    """A body without mass has no weight; that of the ground, and none at all, matter to nobody."""
    is_nothing = not (np.any(load["loadVector"]) or load["loadVectorUserFunction"])
    has_mass = any(body.get(name, 0.0) for name in _MASSES) or not any(name in body for name in _MASSES)
    if not (has_mass or is_nothing):
        raise SceneError(
            f"load {number} '{load['name']}' (MassProportional) acts on '{body['name']}' "
            f"({body['objectType']}), which has no mass and is no element of CreateCompanionCables: it would "
            "do nothing. Give that body a mass, or the load to a body that has one; the weight of an "
            "inextensible cable is its gravity=... or such loads on the objects of "
            "CreateCompanionCables(mbs, cable)."
        )


def put_together(weights: Sequence[ElementWeight]) -> list[ElementWeight]:
    """One weight for all elements of a cable with the same user function and vector; others stay."""
    alike: dict[Any, list[ElementWeight]] = {}
    for weight in weights:
        if weight.history is not None:
            key = weight.cable, id(weight.history.function), tuple(weight.constant)
            alike.setdefault(key, []).append(weight)
    return [weight for weight in weights if weight.history is None] + [
        replace(same[0], elements=tuple(k for weight in same for k in weight.elements))
        for same in alike.values()
    ]
