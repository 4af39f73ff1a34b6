"""What a scene is made of: geometry, section, supports, loads, end time. Plain data in SI units."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from exudyn_inext.errors import InputError

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


def _require_positive(owner: str, unit: str, name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise InputError(
            f"{owner}: {name} = {value!r} {unit}: must be finite and > 0; check value and units."
        )


def _require_fraction(owner: str, value: float) -> None:
    if not 0.0 <= value <= 1.0:
        raise InputError(f"{owner}: {value!r} must be a fraction of the arc length, 0 (start) to 1 (end).")


@dataclass(frozen=True)
class Round:
    """Solid round cross-section.   radius [m], density [kg/m^3], youngs_modulus [Pa]."""

    radius: float
    density: float
    youngs_modulus: float

    def __post_init__(self) -> None:
        for name, unit in (("radius", "m"), ("density", "kg/m^3"), ("youngs_modulus", "Pa")):
            _require_positive("Round section", unit, name, getattr(self, name))

    @property
    def area(self) -> float:
        """A = pi R^2 [m^2]."""
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        """I = pi R^4 / 4 [m^4]."""
        return math.pi * self.radius**4 / 4

    @property
    def mass_per_length(self) -> float:
        """rho_A = rho A [kg/m]."""
        return self.density * self.area

    @property
    def bending_stiffness(self) -> float:
        """EI [N m^2]."""
        return self.youngs_modulus * self.second_moment

    @property
    def axial_stiffness(self) -> float:
        """EA [N]."""
        return self.youngs_modulus * self.area


@dataclass(frozen=True)
class Line:
    """A straight initial shape.   start [m]; direction: unit vector [-]."""

    start: Vector = ZERO
    direction: Vector = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        norm = math.hypot(*self.direction)
        if not abs(norm - 1.0) < 1e-12:
            raise InputError(f"Line: direction has norm {norm!r}, not 1; divide it by its norm.")


@dataclass(frozen=True)
class Cable:
    """length [m], section, and the shape in which the motion starts (stress-free)."""

    length: float
    section: Round
    shape: Line = field(default_factory=Line)

    def __post_init__(self) -> None:
        _require_positive("Cable", "m", "length", self.length)


@dataclass(frozen=True)
class Pin:
    """Holds the position, leaves the slope free.   at: fraction of the arc length [-]."""

    at: float

    def __post_init__(self) -> None:
        _require_fraction("Pin(at)", self.at)


@dataclass(frozen=True)
class Clamp:
    """Holds position and slope.   at: fraction of the arc length [-]."""

    at: float

    def __post_init__(self) -> None:
        _require_fraction("Clamp(at)", self.at)


@dataclass(frozen=True)
class Reference:
    """An independent trajectory of the first observed point.

    file: name inside reference_models/data.   source: what computed it.
    axes: the file's columns that are the scene's x, y, z; a leading minus turns the sign.
    uncertainty: how far the true limit may be from it [m].
    """

    file: str
    axes: tuple[str, str, str]
    uncertainty: float
    source: str


@dataclass(frozen=True)
class Scene:
    """One benchmark.

    gravity [m/s^2]; end_time [s].
    observe: name -> fraction of the arc length; the first one is compared with the reference.
    end_velocity: velocity of the free end [m/s]; the initial field grows linearly from zero.
    """

    name: str
    cable: Cable
    supports: tuple[Pin | Clamp, ...]
    gravity: Vector
    end_time: float
    observe: Mapping[str, float]
    reference: Reference | None = None
    end_velocity: Vector = ZERO

    def __post_init__(self) -> None:
        _require_positive(f"Scene '{self.name}'", "s", "end_time", self.end_time)
        if not self.observe:
            raise InputError(f"Scene '{self.name}' observes no point; give observe={{'tip': 1.0}}.")
        for point, fraction in self.observe.items():
            _require_fraction(f"Scene '{self.name}', observe['{point}']", fraction)
        object.__setattr__(self, "observe", MappingProxyType(dict(self.observe)))

    @property
    def is_planar(self) -> bool:
        """Whether everything happens in the x-y plane."""
        shape = self.cable.shape
        vectors = (shape.start, shape.direction, self.gravity, self.end_velocity)
        return all(vector[2] == 0.0 for vector in vectors)

    @property
    def main_point(self) -> str:
        """Name of the point that is compared with the reference."""
        return next(iter(self.observe))
