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


@dataclass(frozen=True)
class PlacedMass:
    """A point mass.

    element: its number.   xi: its place within, 0 to 1 [-].   mass: [kg].   heavy: that gravity acts on [kg].
    """

    element: int
    xi: float
    mass: float
    heavy: float


def place_on_elements(point: float, lengths: Array) -> tuple[int, float]:
    """Element and abscissa xi [-] of an arc length [m] on elements of these lengths (N,) [m]."""
    ends = np.cumsum(lengths)
    element = min(int(np.searchsorted(ends, point)), len(ends) - 1)
    xi = (point - (ends[element] - lengths[element])) / lengths[element]
    return element, min(max(float(xi), 0.0), 1.0)


def placed(masses: Sequence[PointMass], lengths: Array) -> list[PlacedMass]:
    """The point masses on elements of these lengths (N,) [m]."""
    return [
        PlacedMass(*place_on_elements(m.arc_length, lengths), m.mass, m.mass * m.has_weight) for m in masses
    ]


def mass_of_points(masses: Sequence[PointMass], lengths: Array) -> Array:
    """(N, 4, 4) scalar element matrices sum m S S^T of point masses [kg, kg m; kg m, kg m^2]."""
    result = np.zeros((len(lengths), 4, 4))
    for point in placed(masses, lengths):
        shape = shape_functions(point.xi, float(lengths[point.element]))
        result[point.element] += point.mass * np.outer(shape, shape)
    return result
