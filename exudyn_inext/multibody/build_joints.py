"""From the records of joints to what their solve needs: entries, knots, the order of elimination."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..sparse_factor import build_factor, find_order, places_of
from .build_nodes import (
    MANY,
    Ends,
    build_nodes,
    lay_out,
    order_with_nodes,
    pairs_on_nodes,
    rows_on_nodes,
)
from .joints import Entries, Holds, Joints, Members
from .knots import FEWEST, GROUND, NONE, Member, Tie, find_knots
from .points import ANGLE, COORDINATE, FIXED
from .rows import DIFFERENCE


class _Hold(NamedTuple):
    """Sorted by owners, those at knots first.   unknown: its number, or NONE."""

    owner: int
    is_row: bool
    entry: int
    sign: int
    unknown: int
    member: int


def build_joints(
    places: Sequence[slice],
    bodies: Any,
    points: Any,
    rows: Any,
    drift_correction: Array,
    still: np.ndarray,
    ends: Ends,
    holding: int | None = None,
) -> Joints:
    """The rows of all joints.

    Args:
        places: of each cable among the coordinates.   bodies, points, rows: records.
        drift_correction: (m,) memory, see `CoupledSystem`.
        still: (n_cables,) coordinates of cables that supports hold.
        ends: of cables whose nodes can be unknowns.
        holding: number of the rows that are not of dashpots; None: all.

    It sets `entry` of the rows.
    """
    owners = _owners_of_points(places, bodies, points)
    crowded = _crowded(rows, owners, ends)
    entries, numbers = _build_entries(places, bodies, points, rows, owners, crowded)
    knots = _knots_of(points, rows, owners, still, crowded)
    tied = {member.row for knot in knots for member in knot}
    free = [number for number, knot in enumerate(knots) if knot[0].row == NONE]
    alone = [row for row in range(len(rows)) if row not in tied]
    unknown_of_knot = {number: unknown for unknown, number in enumerate(free)}
    unknown_of_row = {row: unknown for unknown, row in enumerate(alone, len(free))}
    alone_on = {key: e for key, e in numbers.items() if key[0] not in crowded}
    found = sorted(_find_holds(knots, alone_on, unknown_of_knot, unknown_of_row))
    layout = lay_out(ends, crowded, len(free) + len(alone))
    on_nodes = rows_on_nodes(layout, entries, np.array([owner for owner, _ in numbers]), unknown_of_row)
    unknowns = len(free) + len(alone) + int(layout.is_owner.sum())
    pairs = _pairs(found, unknowns)
    if crowded:
        pairs = np.concatenate([pairs, pairs_on_nodes(layout, on_nodes)])
    place = order_with_nodes(pairs, unknowns, layout) if crowded else find_order(pairs, unknowns)
    factor = build_factor(place[pairs], unknowns)
    is_row = np.zeros(unknowns, dtype=bool)
    is_row[place[len(free) :]] = True
    is_row[place[layout.unknown[:, :-1]]] = False
    vectors, of_unknowns = np.zeros((7, len(rows))), np.zeros((2, unknowns))
    place_of_row = np.full(len(rows), NONE)
    place_of_row[alone] = place[len(free) : len(free) + len(alone)]
    return Joints(
        rows=rows,
        holding=len(rows) if holding is None else holding,
        entries=entries,
        holds=_build_holds(found, np.append(place, NONE), factor, len(places)),
        members=_build_members(knots, found),
        nodes=build_nodes(layout, on_nodes, _starts(places, bodies), place, factor),
        place=place_of_row,
        factor=factor,
        is_row=is_row,
        diagonal=of_unknowns[0],
        value=vectors[0],
        gamma=vectors[1],
        multipliers=vectors[2],
        foreseen=vectors[6],
        drift_correction=drift_correction,
        rate=vectors[3],
        target=vectors[4],
        unknowns=of_unknowns[1],
        solved=vectors[5],
        dependent=np.full(1, NONE),
    )


def _starts(places: Sequence[slice], bodies: Any) -> np.ndarray:
    """First coordinate of each owner: cables, then bodies."""
    return np.array([place.start for place in places] + bodies["first"].tolist(), dtype=np.int64)


def _owners_of_points(places: Sequence[slice], bodies: Any, points: Any) -> list[int]:
    """Cable, or body after the cables, of each point; GROUND of those that do not move."""
    starts = _starts(places, bodies)
    order = np.argsort(starts, kind="stable")
    found = order[np.searchsorted(starts[order], points["first"], side="right") - 1] if len(order) else []
    return np.where(points["kind"] == FIXED, GROUND, found).tolist() if len(points) else []


def _crowded(rows: Any, owners: Sequence[int], ends: Ends) -> list[int]:
    """Cables with so many rows that their nodes are unknowns."""
    number = dict.fromkeys(ends.of_cables, 0)
    for pair in rows["points"].tolist():
        for owner in {owners[k] for k in pair} & number.keys():
            number[owner] += 1
    return [cable for cable in sorted(number) if number[cable] >= MANY]


def _build_entries(
    places: Sequence[slice],
    bodies: Any,
    points: Any,
    rows: Any,
    owners: Sequence[int],
    crowded: Sequence[int],
) -> tuple[Entries, dict[tuple[int, int], int]]:
    """All entries, by owners; and their numbers by owner and row. Those of crowded cables keep no zeros."""
    starts = _starts(places, bodies)
    sizes = [place.stop - place.start for place in places]
    sizes += (bodies["translations"] + bodies["rotations"]).tolist()
    begin, width_of = points["first"].tolist(), points["width"].tolist()
    spans: dict[tuple[int, int], tuple[int, int]] = {}  # owner and row -> its coordinates, from and to
    for r, pair in enumerate(rows["points"].tolist()):
        for k in pair:
            if owners[k] != GROUND:
                first, end = spans.get((owners[k], r), (begin[k], begin[k] + width_of[k]))
                spans[owners[k], r] = min(first, begin[k]), max(end, begin[k] + width_of[k])
    keys = sorted(spans)
    numbers = {key: e for e, key in enumerate(keys)}
    rows["entry"] = [
        [numbers.get((owners[k], r), NONE) for k in pair] for r, pair in enumerate(rows["points"].tolist())
    ] or np.zeros((0, 2))
    owner = np.array([owner for owner, _ in keys], dtype=np.int64)
    width = np.array([sizes[owner] for owner in owner], dtype=np.int64)
    ranges = np.array([spans[key] for key in keys], dtype=np.int64).reshape(-1, 2) - starts[owner, None]
    is_crowded = np.isin(owner, crowded)
    kept = np.where(is_crowded, ranges[:, 1] - ranges[:, 0], width)
    memory = np.zeros((2, int(kept.sum())))
    entries = Entries(
        first=np.cumsum(kept) - kept - np.where(is_crowded, ranges[:, 0], 0),
        width=width,
        row=np.array([r for _, r in keys], dtype=np.int64),
        dof=starts[owner],
        begin=ranges[:, 0].copy(),
        stop=ranges[:, 1].copy(),
        jacobian=memory[0],
        response=memory[1],
    )
    return entries, numbers


def _knots_of(
    points: Any, rows: Any, owners: Sequence[int], still: np.ndarray, crowded: Sequence[int]
) -> list[list[Member]]:
    """Rows that hold one component of points together, but of points whose coordinates others hold, too.

    Nodes that supports hold are points of the ground. Points of crowded cables belong to no knot.
    """
    is_tie = (rows["kind"] == DIFFERENCE) & (rows["factor"] == 1.0) & (rows["offset"] == 0.0)
    is_tie &= (rows["functions"] < 0).all(axis=1)
    is_tie &= ~np.isin(points["kind"][rows["points"]], (COORDINATE, ANGLE)).any(axis=1)
    begin, end = points["first"].tolist(), (points["first"] + points["width"]).tolist()
    pairs, tied = rows["points"].tolist(), is_tie.nonzero()[0].tolist()
    component_of = rows["component"].tolist()
    places = [(component_of[r], begin[k]) for r in tied for k in pairs[r] if owners[k] != GROUND]
    if len(tied) < FEWEST - 1 or len(set(places)) == len(places):  # no two of them meet
        return []
    owners = [
        GROUND if still[a:b].any() and still[a:b].all() else owner
        for a, b, owner in zip(begin, end, owners, strict=True)
    ]
    others = {k for r in (~is_tie).nonzero()[0].tolist() for k in pairs[r] if owners[k] != GROUND}
    held = {coordinate for k in others for coordinate in range(begin[k], end[k])}
    weights, local = points["weights"], points["local"]
    names = [
        (owner, (begin[k], end[k], weights[k].tobytes(), local[k].tobytes()))
        for k, owner in enumerate(owners)
    ]
    found: list[list[Member]] = []
    for component in range(3):
        mine = [r for r in tied if component_of[r] == component]
        ties = [Tie(r, (names[pairs[r][0]], names[pairs[r][1]])) for r in mine]
        of_ties = {k for r in mine for k in pairs[r] if owners[k] != GROUND}
        taken = {names[k] for k in of_ties if not held.isdisjoint(range(begin[k], end[k]))}
        taken |= {names[k] for k in of_ties if owners[k] in crowded}
        found += find_knots(ties, taken)
    return found


def _find_holds(
    knots: Sequence[Sequence[Member]],
    numbers: dict[tuple[int, int], int],
    unknown_of_knot: dict[int, int],
    unknown_of_row: dict[int, int],
) -> Iterator[_Hold]:
    """All of them.   numbers: of entries, by owner and row."""
    member = 0
    for number, knot in enumerate(knots):
        unknown = unknown_of_knot.get(number, NONE)
        for one in knot:
            entry = numbers[one.owner, one.source]
            yield _Hold(one.owner, False, entry, one.side, unknown, member)
            member += 1
    for (owner, row), entry in numbers.items():
        if row in unknown_of_row:
            yield _Hold(owner, True, entry, 1, unknown_of_row[row], NONE)


def _parts(holds: Sequence[_Hold]) -> np.ndarray:
    """(P,) after the holds of each owner."""
    owners = np.array([hold.owner for hold in holds] + [NONE], dtype=np.int64)
    return (owners[1:] != owners[:-1]).nonzero()[0] + 1


def _pairs(holds: Sequence[_Hold], unknowns: int) -> np.ndarray:
    """(Q, 2) of unknowns that meet on a part, each once, and each with itself."""
    unknown = np.array([hold.unknown for hold in holds], dtype=np.int64)
    keys, begin = [np.arange(unknowns) * (unknowns + 1)], 0
    for end in _parts(holds).tolist():
        own = unknown[begin:end]
        own = own[own >= 0]
        keys.append((own[:, None] * unknowns + own)[own[:, None] <= own])
        begin = end
    return np.stack(np.divmod(np.unique(np.concatenate(keys)), max(unknowns, 1)), axis=1)


def _build_holds(holds: Sequence[_Hold], place: np.ndarray, factor: Any, cables: int) -> Holds:
    """place: of each unknown, NONE at the end.   cables: how many owners are cables."""
    owner, is_row, entry, sign, unknown, member = np.array(holds, dtype=np.int64).reshape(-1, 6).T.copy()
    at, ends = place[unknown], _parts(holds)
    sizes = np.diff(ends, prepend=0)
    square = np.cumsum(sizes**2) - sizes**2
    part = np.repeat(np.arange(len(sizes)), sizes**2)
    first, within = (ends - sizes)[part], np.arange(len(part)) - square[part]
    rows, columns = at[first + within // sizes[part]], at[first + within % sizes[part]]
    into, goes = np.full(len(rows), NONE), np.minimum(rows, columns) >= 0
    rows, columns = np.maximum(rows, columns), np.minimum(rows, columns)
    into[goes] = places_of(factor, columns[goes], rows[goes])
    at_knots = np.diff(np.cumsum(is_row == 0)[ends - 1], prepend=0)
    memory = np.zeros((2, len(holds)))
    return Holds(
        entry=entry,
        sign=sign.astype(float),
        place=at,
        member=member,
        body=np.where(owner < cables, NONE, owner - cables),
        end=ends,
        at_knots=at_knots,
        square=square,
        local=np.zeros(len(into)),
        into=into,
        rate=memory[0],
        force=memory[1],
        on_cables=int(np.count_nonzero(owner < cables)),
    )


def _build_members(knots: Sequence[Sequence[Member]], holds: Sequence[_Hold]) -> Members:
    hold_of = {hold.member: number for number, hold in enumerate(holds)}
    members: list[Member] = []
    parents: list[int] = []
    for knot in knots:
        done = len(members)
        parents += [NONE if one.parent == NONE else done + one.parent for one in knot]
        members += knot
    memory = np.zeros((2, len(members)))
    return Members(
        hold=np.array([hold_of[number] for number in range(len(members))], dtype=np.int64),
        row=np.array([one.row for one in members], dtype=np.int64),
        sign=np.array([one.sign for one in members], dtype=np.float64),
        parent=np.array(parents, dtype=np.int64),
        offset=memory[0],
        force=memory[1],
    )
