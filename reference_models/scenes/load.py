"""Dead loads at points of a cable, and how they vary in time."""

import math
from dataclasses import dataclass

from exudyn_inext.checks import require_positive, require_vector

from .checks import Vector, require_fraction


@dataclass(frozen=True)
class Sine:
    """factor(t) = amplitude sin(w t).   angular_frequency: w [rad/s]; amplitude [-]."""

    angular_frequency: float
    amplitude: float = 1.0

    def __post_init__(self) -> None:
        require_positive("Sine: angular_frequency", self.angular_frequency)

    def factor(self, time: float) -> float:
        """Factor [-] at a time [s]."""
        return self.amplitude * math.sin(self.angular_frequency * time)


@dataclass(frozen=True)
class PointForce:
    """A dead force on a point: force * history.factor(t).

    at: fraction of the arc length.   force [N].   history: None: constant.
    """

    at: float
    force: Vector
    history: Sine | None = None

    def __post_init__(self) -> None:
        require_fraction("PointForce(at)", self.at)
        require_vector("PointForce: force", self.force)

    def value(self, time: float) -> Vector:
        """Force [N] at a time [s]."""
        factor = self.history.factor(time) if self.history else 1.0
        return (factor * self.force[0], factor * self.force[1], factor * self.force[2])
