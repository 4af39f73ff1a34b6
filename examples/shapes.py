"""What pictures and animation ask of the points of a cable."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline


def smooth(nodes: np.ndarray) -> np.ndarray:
    """Points of a smooth curve through nodes (k, dim)."""
    place = np.arange(len(nodes))
    return CubicSpline(place, nodes)(np.linspace(0, len(nodes) - 1, 10 * len(nodes)))


def is_flat(cables: Sequence[np.ndarray]) -> bool:
    """Whether motions (n, k, dim) show nothing where the axes have equal scales."""
    *_, second, largest = np.sort(np.ptp(np.concatenate(cables, axis=1), axis=(0, 1)))
    return bool(second < 0.1 * largest)


def frame_axes(axes: Any, points: np.ndarray) -> None:
    """Limits that hold the whole motion (n, k, space), labels, and equal scales unless it is flat."""
    low, size = points.min(axis=(0, 1)), np.ptp(points, axis=(0, 1))
    for axis, start, width in zip("xyz", low, size, strict=False):
        getattr(axes, f"set_{axis}lim")(start - 0.05 * width, start + 1.05 * width)
        getattr(axes, f"set_{axis}label")(f"{axis} [m]")
    if points.shape[2] == 3:
        axes.set_box_aspect(size, zoom=1.15)
        axes.locator_params(nbins=4)
    elif is_flat([points]):
        axes.set_ylabel("y, enlarged [m]")
    else:
        axes.set_aspect("equal")
