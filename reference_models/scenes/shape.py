"""Initial shapes of a cable, parametrised by the fraction of its arc length.

Every shape tells `closed` (the end joins the start), `is_planar` (it lies in the x-y plane), checks
whether a cable of a given length fits (`require_length`), and gives its `curve`: positions (n, 3) [m]
and unit tangents (n, 3) [-] at fractions (n,) [-] of the arc length.
"""

import math
from dataclasses import dataclass

import numpy as np

from exudyn_inext.checks import LARGEST_NUMBER_OF_ITEMS, require_integer, require_positive, require_vector
from exudyn_inext.errors import InputError

from ..trajectory import Array
from .checks import ZERO, Vector

CLOSURE_TOLERANCE = 1e-9
"""Length of a ring over its circumference, minus 1 [-]."""


@dataclass(frozen=True)
class Line:
    """A straight initial shape.   start [m]; direction: unit vector [-]."""

    start: Vector = ZERO
    direction: Vector = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        norm = math.hypot(*self.direction)
        if not abs(norm - 1.0) < 1e-12:
            raise InputError(f"Line: direction has norm {norm!r}, not 1; divide it by its norm.")

    closed = False

    @property
    def is_planar(self) -> bool:
        return self.start[2] == 0.0 and self.direction[2] == 0.0

    def require_length(self, length: float) -> None:
        """Any length fits."""

    def curve(self, fractions: Array, length: float) -> tuple[Array, Array]:
        """Positions and unit tangents, see the head of this file."""
        tangents = np.tile(self.direction, (len(fractions), 1))
        return self.start + length * fractions[:, None] * tangents, tangents


@dataclass(frozen=True)
class Circle:
    """A closed ring in the x-y plane: starts at angle 0, counterclockwise.   center, radius [m]."""

    radius: float
    center: Vector = ZERO

    def __post_init__(self) -> None:
        require_positive("Circle: radius", self.radius)
        require_vector("Circle: center", self.center)

    closed = True

    @property
    def is_planar(self) -> bool:
        return self.center[2] == 0.0

    @property
    def circumference(self) -> float:
        """2 pi R [m]."""
        return 2.0 * math.pi * self.radius

    def require_length(self, length: float) -> None:
        """The ring must close."""
        if not abs(length / self.circumference - 1.0) <= CLOSURE_TOLERANCE:
            raise InputError(
                f"Cable: length = {length!r} m does not close a circle of radius {self.radius!r} m, "
                f"which is {self.circumference!r} m around; change the length or the radius."
            )

    def curve(self, fractions: Array, length: float) -> tuple[Array, Array]:
        """Positions and unit tangents, see the head of this file."""
        angle = 2.0 * math.pi * fractions
        cosine, sine, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
        radial, tangents = np.column_stack([cosine, sine, zero]), np.column_stack([-sine, cosine, zero])
        return self.center + self.radius * radial, tangents


@dataclass(frozen=True)
class Parabolas:
    """Parabolas that hang side by side between points of equal height, in x-direction, sagging along -y.

    start: the first point [m].   width: between two points [m].   sag [m].   spans: how many.
    Where two spans meet, the tangent is their mean, horizontal. A cable that is a little longer than
    the curve starts compressed; so this is where a static solution begins, not where a motion does.
    """

    width: float
    sag: float
    spans: int = 1
    start: Vector = ZERO

    def __post_init__(self) -> None:
        require_positive("Parabolas: width", self.width)
        require_positive("Parabolas: sag", self.sag)
        require_vector("Parabolas: start", self.start)
        require_integer("Parabolas: spans", self.spans, 1, LARGEST_NUMBER_OF_ITEMS)

    closed = False

    @property
    def is_planar(self) -> bool:
        return self.start[2] == 0.0

    @property
    def end(self) -> Vector:
        """The last point [m]."""
        return (self.start[0] + self.spans * self.width, self.start[1], self.start[2])

    def require_length(self, length: float) -> None:
        """The cable must reach from end to end."""
        distance = self.spans * self.width
        if not length > distance:
            raise InputError(
                f"Cable: length = {length!r} m is too short for {self.spans} spans of {self.width!r} m, "
                f"{distance!r} m from end to end; use a longer cable or narrower spans."
            )

    def curve(self, fractions: Array, length: float) -> tuple[Array, Array]:
        """Positions and unit tangents, see the head of this file."""
        scaled = fractions * self.spans
        span = np.minimum(np.floor(scaled), self.spans - 1)
        u = self._abscissa(2.0 * (scaled - span) - 1.0)
        steepness = self._curvature * u
        is_joint = (np.round(scaled) == scaled) & (scaled > 0) & (scaled < self.spans)
        angle = np.where(is_joint, 0.0, np.arctan(steepness))
        x = (span + 0.5) * self.width + u
        y = 0.5 * self._curvature * u**2 - self.sag
        zero = np.zeros_like(x)
        return (
            self.start + np.column_stack([x, y, zero]),
            np.column_stack([np.cos(angle), np.sin(angle), zero]),
        )

    @property
    def _curvature(self) -> float:
        """y'' [1/m] of y = y'' u^2 / 2 - sag, with u from the middle of the span."""
        return 8.0 * self.sag / self.width**2

    def _abscissa(self, arc: Array) -> Array:
        """u [m] at an arc length from the middle of the span; arc: -1 to 1, of half a span."""
        target = arc * self._arc_length(np.asarray(0.5 * self.width))
        u = 0.5 * self.width * arc
        for _ in range(20):
            u = u - (self._arc_length(u) - target) / np.sqrt(1.0 + (self._curvature * u) ** 2)
        return u

    def _arc_length(self, u: Array) -> Array:
        """int_0^u sqrt(1 + y'^2) du [m]."""
        slope = self._curvature * u
        return (slope * np.sqrt(1.0 + slope**2) + np.arcsinh(slope)) / (2.0 * self._curvature)


Shape = Line | Circle | Parabolas
