"""What holds a cable."""

from dataclasses import dataclass

from exudyn_inext.checks import require_positive, require_vector

from .checks import Vector, require_fraction


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
        require_positive("Hanger: length", self.length)
        require_vector("Hanger: anchor", self.anchor)


Support = Pin | Clamp | Hanger
