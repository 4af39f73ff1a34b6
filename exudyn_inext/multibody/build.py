"""From the records of a scene's items to its system."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..arrays import Array
from ..scene.joints import order_of_band
from .joints import NONE, Joints
from .points import FIXED
from .scene import Items, SceneSystem


class FunctionOfTime(Protocol):
    """Three numbers that depend on the time alone."""

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3) at these times [s]."""


@dataclass(frozen=True, eq=False)
class KnownItems:
    """All but the cables: records, and functions of time that the loads refer to, three numbers each."""

    bodies: Any
    points: Any
    rows: Any
    connectors: Any
    loads: Any
    functions: Sequence[FunctionOfTime]


def build_scene(
    cables: Any,
    external: int,
    places: Sequence[slice],
    known: KnownItems,
    size: int,
    zeta: float,
    foresight: Array,
) -> SceneSystem:
    """The system of a scene.

    Args:
        cables: system of all cables, or `NoCables`.   external: numbers of external force that it takes.
        places: of each cable among the coordinates.   known: the items.   size: number of coordinates.
        zeta: stabilisation rate [1/s].   foresight: (m,) memory, see `CoupledSystem`.
    """
    joints = _build_joints(places, known, foresight)
    path, counting = np.zeros((5, max(size, 7))), np.zeros(2, np.int64)
    force, given, predicted = np.zeros((3, size))
    records = known.bodies, known.points, known.connectors, known.loads
    items = Items(*records, joints, force, given, predicted, path, counting)
    number = places[-1].stop if places else 0
    return SceneSystem(cables, number, np.zeros(external), items, zeta)


def _build_joints(places: Sequence[slice], known: KnownItems, foresight: Array) -> Joints:
    """Entries of all rows, by cables and bodies."""
    rows, bodies, number = known.rows, known.bodies, len(known.rows)
    starts = np.array([place.start for place in places] + bodies["first"].tolist(), dtype=np.int64)
    sizes = [place.stop - place.start for place in places]
    sizes += (bodies["translations"] + bodies["rotations"]).tolist()
    order = np.argsort(starts, kind="stable")
    owner_of = order[np.searchsorted(starts[order], known.points["first"], side="right") - 1].tolist()
    begin, width_of = known.points["first"].tolist(), known.points["width"].tolist()
    moves = (known.points["kind"] != FIXED).tolist()
    spans: dict[tuple[int, int], tuple[int, int]] = {}  # owner and row -> its coordinates, from and to
    for r, pair in enumerate(rows["points"].tolist()):
        for k in filter(moves.__getitem__, pair):
            first, end = spans.get((owner_of[k], r), (begin[k], begin[k] + width_of[k]))
            spans[owner_of[k], r] = min(first, begin[k]), max(end, begin[k] + width_of[k])
    keys = sorted(spans)
    owners = np.array([owner for owner, _ in keys], dtype=np.int64)
    numbers = {key: e for e, key in enumerate(keys)}
    rows["entry"] = [
        [numbers.get((owner_of[k], r), NONE) if moves[k] else NONE for k in pair]
        for r, pair in enumerate(rows["points"].tolist())
    ] or np.zeros((0, 2))
    width = np.array([sizes[owner] for owner in owners], dtype=np.int64)
    ranges = np.array([spans[key] for key in keys], dtype=np.int64).reshape(-1, 2) - starts[owners, None]
    on_cables = int(np.count_nonzero(owners < len(places)))
    row_of = np.array([r for _, r in keys], dtype=np.int64)
    place, width_of_band = _places_in_band(owners, row_of, number)
    memory = np.zeros((2, int(width.sum())))
    vectors = np.zeros((6, number))
    return Joints(
        rows=rows,
        first=np.cumsum(width) - width,
        width=width,
        row=row_of,
        dof=starts[owners],
        begin=ranges[:, 0].copy(),
        stop=ranges[:, 1].copy(),
        body=np.where(owners < len(places), NONE, owners - len(places)),
        end=np.flatnonzero(np.diff(owners, append=-1)) + 1,
        on_cables=on_cables,
        place=place,
        jacobian=memory[0],
        response=memory[1],
        schur=np.zeros((number, width_of_band)),
        factor=np.zeros((number, width_of_band)),
        value=vectors[0],
        gamma=vectors[1],
        multipliers=vectors[2],
        foresight=foresight,
        rate=vectors[3],
        target=vectors[4],
        sorted=vectors[5],
        dependent=np.full(1, NONE),
    )


def _places_in_band(owners: np.ndarray, rows: np.ndarray, number: int) -> tuple[np.ndarray, int]:
    """(m,) of the rows in the band, and how wide its lower half is."""
    place = np.argsort(order_of_band(rows, owners, number))
    spans = [np.ptp(place[rows[owners == owner]]) for owner in np.unique(owners)]
    return place, int(max(spans, default=0)) + 1


def copied(memory: Any) -> Any:
    """The same tuple of tuples, with copies of its arrays."""
    if isinstance(memory, np.ndarray):
        return memory.copy()
    return type(memory)(*map(copied, memory)) if isinstance(memory, tuple) else memory
