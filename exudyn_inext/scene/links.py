"""Constraints of an mbs that become links of a cable: distances and moving coordinates."""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..cable.link import Link, Motion, rest
from ..constraints.distance import hanger, rod
from ..constraints.motion import require_smooth
from ..constraints.prescribed_motion import prescribed
from ..errors import SceneError


@dataclass(frozen=True, eq=False)
class Rod:
    """A distance constraint.

    nodes: one or two node numbers.   point: (3,) end on the ground, or None.   length: [m].
    motion: of that end (dim,), if it has been moved during a run.
    """

    nodes: tuple[int, ...]
    point: Array | None
    length: float
    name: str
    motion: Motion | None = None

    def links(self, places: list[int], dim: int) -> list[Link]:
        """The link on a cable's nodes at `places`.

        Raises:
            SceneError: the fixed end is out of the plane of a planar cable.
        """
        if self.point is None:
            return [rod((places[0], places[1]), dim, self.length)]
        if self.point[dim:].any():
            raise SceneError(
                f"{self.name} ends at {self.point.tolist()}, out of the plane of its cable: create the cable "
                "with dimension=3, or move that end to z = 0."
            )
        return [hanger(places[0], self.motion or rest(self.point[:dim]), self.length)]


@dataclass(frozen=True, eq=False)
class MovingCoordinate:
    """A coordinate constraint that moves one coordinate of a node's position.

    node: number.   axis: 0 for x, ...   motion: of the whole position (dim,), or of this axis alone.
    """

    node: int
    axis: int
    motion: Motion
    name: str

    @property
    def nodes(self) -> tuple[int, ...]:
        return (self.node,)


def links_of_motions(moving: list[MovingCoordinate], places: dict[int, int], dim: int) -> list[Link]:
    """The links of moving coordinates on a cable; places: node number -> index on the cable."""
    links: list[Link] = []
    motions: dict[int, Motion] = {}
    for coordinate in moving:
        motion = motions.setdefault(id(coordinate.motion), in_space(coordinate, dim).motion)
        links += prescribed(places[coordinate.node], motion, [coordinate.axis])
    return links


def in_space(coordinate: MovingCoordinate, dim: int) -> MovingCoordinate:
    """The same one, with the motion of its whole position (dim,)."""
    motion, direction = coordinate.motion, np.eye(dim)[coordinate.axis]
    if motion.at(0.0).shape[1] == dim:
        return coordinate

    def along(values: Array) -> Array:
        return values * direction

    in_all = replace(
        motion,
        at=lambda t: along(motion.at(t)),
        at_times=lambda times: along(motion.sample(times)),
        position=lambda t: along(motion.place(t)),
    )
    return replace(coordinate, motion=in_all)


def require_smooth_motions(moving: list[MovingCoordinate], time: float) -> None:
    """Raise InputError unless all motions are differentiable twice at the start of the run [s]."""
    checked: set[int] = set()
    for coordinate in moving:
        motion = coordinate.motion
        if motion.is_smooth and not motion.rests and id(motion) not in checked:
            checked.add(id(motion))
            require_smooth(motion, time, f"the motion prescribed by {coordinate.name}")
