"""Drawing of a cable in the renderer."""

from collections.abc import Sequence
from typing import Any

import exudyn
import numpy as np

from ..cable.cable import Cable
from ..element.shape_functions import shape_functions

POINTS_PER_ELEMENT = 6
COLOUR = [0.0, 0.45, 0.7, 1.0]


def cable_graphics(cable: Cable, nodes: Sequence[int]) -> Any:
    """Graphics user function that draws the Hermite curve through the nodes."""
    weights = [
        shape_functions(np.linspace(0, 1, POINTS_PER_ELEMENT), length) for length in cable.element_lengths
    ]

    def draw_cable(mbs: Any, itemNumber: int) -> list[dict[str, Any]]:
        what = exudyn.OutputVariableType.Coordinates, exudyn.ConfigurationType.Visualization
        displacements = [mbs.GetNodeOutput(node, *what) for node in nodes]
        q = cable.reference + np.reshape(displacements, cable.reference.shape)
        curve = np.concatenate([s.T @ np.concatenate([q[k], q[k + 1]]) for k, s in enumerate(weights)])
        points = np.zeros((len(curve), 3))
        points[:, : cable.dimension] = curve
        return [{"type": "Line", "color": COLOUR, "data": points.ravel().tolist()}]

    return draw_cable
