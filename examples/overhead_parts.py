"""Parts of an overhead contact line: the shape of its messenger wire, and the force of a pantograph."""

from collections.abc import Callable, Sequence
from typing import Any

import exudyn.utilities as eu
import numpy as np

from exudyn_inext import CableShape


def parabolas(x: np.ndarray, span: float, height: float, bend: float) -> CableShape:
    """A wire that hangs from masts at each span, y = height - bend x (span - x); horizontal at masts between.

    x: (n,) of the nodes [m].   span, height: [m].   bend: [1/m].
    """
    place = x - span * np.minimum(x // span, x[-1] // span - 1)
    angle = np.arctan(bend * (2 * place - span)) * ((place > 0) | (x == 0))
    points = np.column_stack([x, height - bend * place * (span - place)])
    return CableShape(points, np.column_stack([np.cos(angle), np.sin(angle)]))


def add_moving_force(mbs: Any, nodes: Sequence[int], element: float, force: float, speed: float) -> None:
    """A force [N] along y that runs with that speed [m/s] along a level planar cable, from its start on.

    The cubic shape functions distribute it to positions and slopes of nodes.   element: length [m].
    """
    for k, node in enumerate(nodes):
        for coordinate, share in ((1, share_of_position), (3, share_of_slope)):
            marker = mbs.AddMarker(eu.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            function = _share(share, k * element, element, force, speed)
            mbs.AddLoad(eu.LoadCoordinate(markerNumber=marker, load=0, loadUserFunction=function))


def share_of_position(x: float, element: float) -> float:
    """Shape function of a node's position at a distance of x < element [m]."""
    return (1 - abs(x) / element) ** 2 * (1 + 2 * abs(x) / element)


def share_of_slope(x: float, element: float) -> float:
    """Shape function of a node's slope [m]."""
    return x * (1 - abs(x) / element) ** 2


def _share(
    share: Callable[[float, float], float], place: float, element: float, force: float, speed: float
) -> Callable[[Any, float, float], float]:
    def load(mbs: Any, t: float, load: float) -> float:
        x = speed * t - place
        return force * share(x, element) if abs(x) < element else 0.0

    return load
