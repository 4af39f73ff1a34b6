"""What a cable carries, and what it moves in: point masses, a fluid. Plain data."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..element.shape_functions import shape_functions


@dataclass(frozen=True)
class PointMass:
    """A mass [kg] at an arc length [m].   has_weight: whether it feels the cable's gravity."""

    arc_length: float
    mass: float
    has_weight: bool = True

    @property
    def heavy(self) -> float:
        """What gravity acts on [kg]."""
        return self.mass * self.has_weight


@dataclass(frozen=True)
class Drag:
    """Drag against a uniform flow, see `element.drag`.

    normal, tangential: c_n, c_t [kg/m^2].   flow: u, one component a direction [m/s].
    """

    normal: float
    tangential: float
    flow: tuple[float, ...]

    def law(self) -> Array:
        """(2, 3) coefficients and flow, as the kernels take them."""
        flow = np.zeros(3)
        flow[: len(self.flow)] = self.flow
        return np.array([[self.normal, self.tangential, 0.0], flow])


def place_on_elements(point: float, lengths: Array) -> tuple[int, float]:
    """Element and abscissa xi [-] of an arc length [m] on elements of these lengths (N,) [m]."""
    ends = np.cumsum(lengths)
    element = min(int(np.searchsorted(ends, point)), len(ends) - 1)
    xi = (point - (ends[element] - lengths[element])) / lengths[element]
    return element, min(max(float(xi), 0.0), 1.0)


def mass_of_points(masses: Sequence[PointMass], lengths: Array) -> Array:
    """(N, 4, 4) scalar element matrices sum m S S^T of point masses [kg, kg m; kg m, kg m^2]."""
    result = np.zeros((len(lengths), 4, 4))
    for point in masses:
        element, xi = place_on_elements(point.arc_length, lengths)
        shape = shape_functions(xi, float(lengths[element]))
        result[element] += point.mass * np.outer(shape, shape)
    return result
