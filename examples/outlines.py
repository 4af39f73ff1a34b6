"""Bodies in pictures: points that move with them, and the outline of such points."""

from collections.abc import Sequence
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.utilities import SensorBody
from scipy.spatial import ConvexHull


def box(sides: Sequence[float]) -> np.ndarray:
    """(8, 3) corners of a box about the origin.   sides: [m]."""
    signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)
    return signs * np.array(sides) / 2


def disc(radius: float) -> np.ndarray:
    """(48, 3) points of a circle in the x-y plane.   radius: [m]."""
    angle = 2 * np.pi * np.arange(48) / 48
    return radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(48)])


def follow(mbs: Any, bodies: Sequence[int], *shapes: np.ndarray) -> list[list[int]]:
    """Position sensors of the points (k, 3) of each body."""
    kept = {"storeInternal": True, "outputVariableType": exu.OutputVariableType.Position}
    return [
        [mbs.AddSensor(SensorBody(bodyNumber=body, localPosition=point, **kept)) for point in shape.tolist()]
        for body, shape in zip(bodies, shapes, strict=True)
    ]


def carried(way: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n, k, 3) points (k, 3) that move along a way (n, 3), without turning."""
    return way[:, None] + points


def outline(points: np.ndarray) -> np.ndarray:
    """(m, 2) corners of the smallest convex area with points (k, 2)."""
    return points[ConvexHull(points).vertices]
