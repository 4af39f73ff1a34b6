"""From the records of a scene's items to its system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..arrays import Array
from .build_joints import build_joints
from .build_nodes import Ends, ends_of_cables
from .cables import each_chain
from .implicit_contacts import mark_implicit
from .scene import Items, SceneSystem


class FunctionOfTime(Protocol):
    """Three numbers that depend on the time alone."""

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3) at these times [s]."""


@dataclass(frozen=True, eq=False)
class KnownItems:
    """All but the cables: records, and functions of time that rows and loads refer to, three numbers each."""

    bodies: Any
    points: Any
    sliders: Any
    rows: Any
    connectors: Any
    loads: Any
    contacts: Any
    functions: Sequence[FunctionOfTime]


def build_scene(
    cables: Any,
    external: int,
    places: Sequence[slice],
    known: KnownItems,
    size: int,
    zeta: float,
    foresight: Array,
    still: np.ndarray,
) -> SceneSystem:
    """The system of a scene.

    Args:
        cables: system of all cables, or `NoCables`.   external: numbers of external force that it takes.
        places: of each cable among the coordinates.   known: the items.   size: number of coordinates.
        zeta: stabilisation rate [1/s].   foresight: (m,) memory, see `CoupledSystem`.
        still: (n_cables,) coordinates of cables that supports hold.
    """
    ends = _without(ends_of_cables(cables, places), places, known.sliders.records["first"].tolist())
    joints = build_joints(places, known.bodies, known.points, known.rows, foresight, still, ends)
    path, counting = np.zeros((5, max(size, 7))), np.zeros(2, np.int64)
    force, given, predicted = np.zeros((3, size))
    mark_implicit(cables, known.contacts.records)
    records = known.bodies, known.points, known.sliders, known.connectors, known.loads, known.contacts
    items = Items(*records, joints, force, given, predicted, path, counting)
    number = places[-1].stop if places else 0
    forces = np.arange(number)
    for dofs, first, _ in each_chain(cables):  # motions of cables lie behind their forces
        forces[dofs:] = np.arange(first, first + number - dofs)
    return SceneSystem(cables, number, np.zeros(external), forces, items, zeta)


def _without(ends: Ends, places: Sequence[slice], firsts: Sequence[int]) -> Ends:
    """Without cables on which points slide: these may be anywhere.   firsts: a coordinate of each."""
    kept = {
        cable: own
        for cable, own in ends.of_cables.items()
        if not any(places[cable].start <= first < places[cable].stop for first in firsts)
    }
    return ends._replace(of_cables=kept)


def copied(memory: Any) -> Any:
    """The same tuple of tuples, with copies of its arrays."""
    if isinstance(memory, np.ndarray):
        return memory.copy()
    return type(memory)(*map(copied, memory)) if isinstance(memory, tuple) else memory
