"""Square nets whose sides of meshes are cables, and a slack cable to one of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import exudyn.utilities as eu
import numpy as np

import exudyn_inext as inext


@dataclass(frozen=True)
class Net:
    """In the plane z = 0 about the origin.   meshes: along a side.   mesh: side of a mesh [m].

    speed: along z [m/s].   elements: of each side of a mesh.
    """

    meshes: int
    mesh: float
    speed: float
    elements: int

    @property
    def knots(self) -> list[tuple[int, int]]:
        return list(np.ndindex(self.meshes + 1, self.meshes + 1))

    @property
    def corners(self) -> list[tuple[int, int]]:
        return [knot for knot in self.knots if set(knot) <= {0, self.meshes}]

    @property
    def middle(self) -> tuple[int, int]:
        return self.meshes // 2, self.meshes // 2

    def place(self, knot: tuple[int, int]) -> list[float]:
        """[m]"""
        return [self.mesh * (k - 0.5 * self.meshes) for k in knot] + [0.0]

    def add(
        self, mbs: Any, add_cable: Callable[..., dict[str, Any]], template: Any
    ) -> tuple[list[dict[str, Any]], dict[tuple[int, int], list[Any]]]:
        """Add the cables; returns them, and the nodes that meet at each knot."""
        cables: list[dict[str, Any]] = []
        meeting: dict[tuple[int, int], list[Any]] = {knot: [] for knot in self.knots}
        velocities = {f"velocity{end}": [0, 0, self.speed] for end in ("Start", "End")}
        for i, j in self.knots:
            for other in {(i + 1, j), (i, j + 1)} & meeting.keys():
                ends = self.place((i, j)), self.place(other)
                line = inext.CableShape.Line(*ends, self.elements, **velocities)
                cables.append(add_cable(mbs, shape=line, beamTemplate=template))
                meeting[i, j].append(cables[-1]["nodes"][0])
                meeting[other].append(cables[-1]["nodes"][-1])
        return cables, meeting


def half_circle(diameter: float, elements: int, speed: float) -> inext.CableShape:
    """From x = -diameter [m] to the origin at z = 0; its end moves along z [m/s]."""
    share = np.linspace(0.0, 1.0, elements + 1)[:, np.newaxis]
    angle, zero, radius = np.pi * (1.0 - share), 0.0 * share, 0.5 * diameter
    return inext.CableShape(
        radius * np.hstack([np.cos(angle) - 1.0, np.sin(angle), zero]),
        np.hstack([np.sin(angle), -np.cos(angle), zero]),
        velocities=np.hstack([zero, zero, speed * share]),
        slopeVelocities=np.hstack([zero, zero, zero + speed / (np.pi * radius)]),
    )


def tie(mbs: Any, bodies: Sequence[Any], nodes: Sequence[Any]) -> Any:
    """Hold nodes, and bodies at their references, together by spherical joints; returns a marker there."""
    markers = [mbs.AddMarker(eu.MarkerBodyPosition(bodyNumber=body)) for body in bodies]
    markers += [mbs.AddMarker(eu.MarkerNodePosition(nodeNumber=node)) for node in nodes]
    for marker in markers[:-1]:
        mbs.AddObject(eu.SphericalJoint(markerNumbers=[marker, markers[-1]]))
    return markers[-1]
