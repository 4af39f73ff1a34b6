"""Knots: points of several cables and bodies that spherical joints hold in one place.

Joints between p points have p - 1 forces, and the points one place: where three or more meet, the place is
the smaller unknown. The joints of a knot are a tree, so that their forces follow from those on the points.
"""

from collections.abc import Hashable, Iterator, Sequence
from typing import NamedTuple

FEWEST = 3  # points that move
GROUND = -1  # owner of points that do not
NONE = -1

Point = tuple[int, Hashable]
"""Owner, and which of its points."""


class Tie(NamedTuple):
    """x_1 - x_0 = 0 for one component of two points.   row: of the joints."""

    row: int
    points: tuple[Point, Point]


class Member(NamedTuple):
    """A point of a knot, after the one that it is tied to.

    owner: of the point.   source, side: a row whose Jacobian is the point's, times the side, 1 or -1.
    row: of the tie to its parent, or NONE: it is the root.   sign: 1 if it is the second point of that tie,
    -1 if the first one.   parent: number of another member, or NONE: the ground, or there is none.
    """

    owner: int
    source: int
    side: int
    row: int
    sign: int
    parent: int


def find_knots(ties: Sequence[Tie], taken: set[Point]) -> Iterator[list[Member]]:
    """All knots whose places are to be unknowns.

    Args:
        ties: all of one component.   taken: points that other joints hold, too.
    """
    of_points: dict[Point, list[Tie]] = {}
    for tie in ties:
        for point in tie.points:
            of_points.setdefault(point, []).append(tie)
    seen: set[Point] = set()
    for point in of_points:
        if point not in seen and point[0] != GROUND:
            points, own = _joined(point, of_points)
            seen |= points
            if not points & taken and _is_tree(points, own):
                yield _members(own)


def _joined(point: Point, of_points: dict[Point, list[Tie]]) -> tuple[set[Point], list[Tie]]:
    """All points that are tied to one, but by way of the ground, and the ties."""
    points, own, todo = {point}, dict.fromkeys(of_points[point]), [point]
    while todo:
        for tie in of_points[todo.pop()]:
            own[tie] = None
            new = {other for other in tie.points if other[0] != GROUND} - points
            points |= new
            todo += new
    return points, list(own)


def _is_tree(points: set[Point], ties: Sequence[Tie]) -> bool:
    """Whether the points are many, of different owners, and tied together once."""
    grounded = sum(any(point[0] == GROUND for point in tie.points) for tie in ties)
    once = len(ties) == len(points) - (0 if grounded else 1) and grounded <= 1
    return once and len(points) >= FEWEST and len({owner for owner, _ in points}) == len(points)


def _members(ties: Sequence[Tie]) -> list[Member]:
    """From the ground or the first point on."""
    grounded = [point for tie in ties for point in tie.points if point[0] == GROUND]
    root = grounded[0] if grounded else ties[0].points[0]
    members = [] if grounded else [Member(root[0], ties[0].row, -1, NONE, 0, NONE)]
    reached, left = {root: len(members) - 1}, list(ties)
    while left:
        tie = next(tie for tie in left if tie.points[0] in reached or tie.points[1] in reached)
        left.remove(tie)
        second = int(tie.points[0] in reached)
        point, sign = tie.points[second], 2 * second - 1
        parent = reached[tie.points[1 - second]]
        reached[point] = len(members)
        members.append(Member(point[0], tie.row, sign, tie.row, sign, parent))
    return members
