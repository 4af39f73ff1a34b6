"""What holds a cable."""

from dataclasses import dataclass

from .checks import Vector, require_finite, require_fraction, require_positive


@dataclass(frozen=True)
class Pin:
    """Holds the position, leaves the slope free.   at: fraction of the arc length [-]."""

    at: float

    def __post_init__(self) -> None:
        require_fraction("Pin(at)", self.at)


@dataclass(frozen=True)
class Clamp:
    """Holds position and slope.   at: fraction of the arc length [-]."""

    at: float

    def __post_init__(self) -> None:
        require_fraction("Clamp(at)", self.at)


@dataclass(frozen=True)
class Hanger:
    """A rigid, massless, freely swinging rod: |r - anchor| = length.

    at: fraction of the arc length [-].   length [m].   anchor: its fixed end [m].
    """

    at: float
    length: float
    anchor: Vector

    def __post_init__(self) -> None:
        require_fraction("Hanger(at)", self.at)
        require_positive("Hanger", "m", "length", self.length)
        require_finite("Hanger", "anchor", self.anchor)


Support = Pin | Clamp | Hanger
