"""Native ANCF cable elements of an mbs in the rows that they form."""

from collections import defaultdict
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D

from ..arrays import Array
from .attach.inert import INERT
from .shape import CableShape

_PROPERTIES = (*INERT, "referenceAxialStrain", "referenceCurvature", "strainIsRelativeToReference")
FUNCTIONS = "axialForceUserFunction", "bendingMomentUserFunction"
_DIMENSIONS = {"ANCFCable2D": 2, "ANCFCable": 3}

Elements = Mapping[int, dict[str, Any]]  # what mbs.GetObject(number) returns


@dataclass(frozen=True, eq=False)
class NativeChain:
    """Elements of the same section, each of which begins at the node where the one before it ends.

    elements: their numbers.   nodes: theirs, one more; without the last one if `closed`, which is the first.
    dimension: 2 or 3.   section: see `section_of`.   lengths: of each element [m].
    """

    elements: tuple[int, ...]
    nodes: tuple[int, ...]
    dimension: int
    section: dict[str, Any]
    lengths: tuple[float, ...]
    closed: bool

    @property
    def template(self) -> ObjectANCFCable2D | ObjectANCFCable:
        """Of the section, as of scripts that create such elements."""
        return (ObjectANCFCable2D if self.dimension == 2 else ObjectANCFCable)(**self.section)

    @property
    def name(self) -> str:
        first, last = self.elements[0], self.elements[-1]
        return f"native elements {first} to {last}" if first != last else f"native element {first}"

    def shape(self, mbs: Any, length_reference: str) -> CableShape:
        """In the reference configuration."""
        reference = [mbs.GetNodeParameter(node, "referenceCoordinates") for node in self.nodes]
        q: Array = np.reshape(reference, (-1, 2, self.dimension))
        return CableShape(
            q[:, 0], q[:, 1], list(self.lengths), closed=self.closed, lengthReference=length_reference
        )


def native_chains(elements: Elements, ends: Container[int]) -> list[NativeChain]:
    """The rows of these elements, in the order of their first ones.

    A row goes on through a node where one element ends and one of the same section begins, and no other one
    is about; else it ends there.   ends: nodes where rows end in any case.
    """
    after = _followers(elements, ends)
    followed = set(after.values())
    rows = [_row(number, after) for number in elements if number not in followed]
    left = set(elements).difference(*rows)
    rings = []
    while left:
        rings.append(_row(min(left), after))
        left.difference_update(rings[-1])
    chains = [_chain(elements, row, closed=False) for row in rows]
    chains += [_chain(elements, ring, closed=True) for ring in rings]
    return sorted(chains, key=lambda chain: chain.elements)


def _followers(elements: Elements, breaks: Container[int]) -> dict[int, int]:
    """The element that goes on where an element ends, by its number."""
    starts, ends = defaultdict(list), defaultdict(list)
    for number, data in elements.items():
        first, last = map(int, data["nodeNumbers"])
        starts[first].append(number)
        ends[last].append(number)
    through = [node for node in ends if len(ends[node]) == len(starts[node]) == 1 and node not in breaks]
    pairs = [(ends[node][0], starts[node][0]) for node in through]
    return {one: other for one, other in pairs if _are_alike(elements[one], elements[other])}


def _are_alike(one: dict[str, Any], other: dict[str, Any]) -> bool:
    return one["objectType"] == other["objectType"] and section_of(one) == section_of(other)


def section_of(data: dict[str, Any]) -> dict[str, Any]:
    """What an element has of its template.   data: of the object."""
    return {name: _value(data[name]) for name in (*_PROPERTIES, *FUNCTIONS) if name in data}


def _value(value: Any) -> Any:
    """A user function as an argument of a template; another value as it is."""
    return value["function"] if isinstance(value, dict) else value


def _row(first: int, after: Mapping[int, int]) -> list[int]:
    numbers = [first]
    while (number := after.get(numbers[-1], first)) != first:
        numbers.append(number)
    return numbers


def _chain(elements: Elements, numbers: list[int], closed: bool) -> NativeChain:
    row = [elements[number] for number in numbers]
    nodes = [int(row[0]["nodeNumbers"][0]), *(int(data["nodeNumbers"][1]) for data in row)]
    return NativeChain(
        tuple(numbers),
        tuple(nodes[: len(nodes) - closed]),
        _DIMENSIONS[row[0]["objectType"]],
        section_of(row[0]),
        tuple(float(data["length"]) for data in row),
        closed,
    )
