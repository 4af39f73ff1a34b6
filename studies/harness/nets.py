"""Square nets of cables that meet in knots."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from exudyn.itemInterface import MarkerBodyPosition, MarkerNodePosition, SphericalJoint

from exudyn_inext import CableShape, CreateInextensibleCable, InextensibleCable

GRAVITY = [0.0, 0.0, -9.81]
SECTION = InextensibleCable(massPerLength=0.2, bendingStiffness=2e-3)
SIDE, SAG = 0.25, 0.15  # of a mesh [m], of the net over its size


@dataclass(frozen=True)
class Net:
    """Meshes along each side; the net hangs from its corners, and is released in the shape of a bowl."""

    meshes: int

    @property
    def cables(self) -> int:
        return 2 * self.meshes * (self.meshes + 1)

    def place(self, i: int, j: int) -> list[float]:
        """Of a knot [m]."""
        x, y = i / self.meshes, j / self.meshes
        return [SIDE * i, SIDE * j, -4.0 * SAG * self.meshes * SIDE * (x * (1 - x) + y * (1 - y))]

    def build(
        self, mbs: Any, addCable: Callable[..., Any] = CreateInextensibleCable, elements: int = 6
    ) -> dict[str, Any]:
        """Add a cable for each side of a mesh; returns all cables."""
        cables: list[dict[str, Any]] = []
        ends: dict[tuple[int, int], list[Any]] = {}
        for i, j in np.ndindex(self.meshes + 1, self.meshes + 1):
            for other in ((i + 1, j), (i, j + 1)):
                if max(other) <= self.meshes:
                    line = CableShape.Line(self.place(i, j), self.place(*other), elements)
                    cables.append(addCable(mbs, shape=line, beamTemplate=SECTION, gravity=GRAVITY))
                    ends.setdefault((i, j), []).append(cables[-1]["nodes"][0])
                    ends.setdefault(other, []).append(cables[-1]["nodes"][-1])
        ground = mbs.CreateGround()
        for knot, nodes in ends.items():
            markers = [mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes]
            if set(knot) <= {0, self.meshes}:
                anchor = MarkerBodyPosition(bodyNumber=ground, localPosition=self.place(*knot))
                mbs.AddObject(SphericalJoint(markerNumbers=[mbs.AddMarker(anchor), markers[0]]))
            for marker in markers[1:]:
                mbs.AddObject(SphericalJoint(markerNumbers=[markers[0], marker]))
        return {"cables": cables, "bodies": []}
