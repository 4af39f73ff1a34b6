"""Whether axes of constrained angles tilt during a run.

MarkerNodeRotationCoordinate acts about a global axis, by the angular velocity there. If the body tilts, this
is not the rate of its angle any more, so that places and velocities contradict each other.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from .joint_item import JointItem

MOST_TILT = 0.1  # of the axis of a constrained angle [rad]
_NEXT = ((1, 2), (2, 0), (0, 1))  # the axes beside one


class TiltedAngles:
    """Looks at states of a run.

    Args:
        mbs: assembled.   joints: of the scene.   place: of a coordinate of mbs among those of the scene.

    tilts: (k,) of the axes, at most so far [rad].
    """

    def __init__(self, mbs: Any, joints: Sequence[JointItem], place: Callable[[int], int]) -> None:
        self._angles = []
        for joint in joints:
            markers = mbs.GetObject(joint.number)["markerNumbers"] if joint.is_angular else ()
            for marker in map(mbs.GetMarker, markers):
                if marker["markerType"] == "NodeRotationCoordinate":
                    node, axis = int(marker["nodeNumber"]), int(marker["rotationCoordinate"])
                    own = list(map(place, mbs.systemData.GetNodeLTGODE2(node)[3:]))
                    if len(own) > 1 and min(own) >= 0:
                        reference = np.array(mbs.GetNodeParameter(node, "referenceCoordinates"))[3:]
                        self._angles.append((joint.name, node, axis, own, reference))
        self.tilts = np.zeros(len(self._angles))

    def look(self, q: Array) -> None:
        """At states (k, n)."""
        for number, (*_, axis, places, reference) in enumerate(self._angles):
            cosines = _cosines(q[:, places] + reference, axis)
            tilt = float(np.arccos(np.clip(cosines.min(initial=1.0), -1.0, 1.0)))
            self.tilts[number] = max(self.tilts[number], tilt)

    @property
    def finding(self) -> str:
        """What to warn of; empty if all axes have stayed."""
        tilt = self.tilts.max(initial=0.0)
        if tilt <= MOST_TILT:
            return ""
        name, node, axis, *_ = self._angles[int(self.tilts.argmax())]
        return (
            f"{name} constrains an angle of node {node}, whose axis {'xyz'[axis]} was tilted by "
            f"up to {tilt:.2g} rad (limit {MOST_TILT:g}). The motion need not be exact then, as "
            "MarkerNodeRotationCoordinate acts about the global axis: use a GenericJoint, or a "
            "spring-damper on the angle."
        )


def _cosines(turns: Array, axis: int) -> Array:
    """(k,) of the tilt of an axis of bodies.

    turns: (k, 4) Euler parameters, or (k, 3) angles about x, y, z.
    """
    if turns.shape[1] == 4:
        i, j = _NEXT[axis]
        return 1.0 - 2.0 * (turns[:, 1 + i] ** 2 + turns[:, 1 + j] ** 2)
    (a, b, c), (sin_a, sin_b, sin_c) = np.cos(turns.T), np.sin(turns.T)
    return (b * c, a * c - sin_a * sin_b * sin_c, a * b)[axis]
