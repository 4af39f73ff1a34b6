"""Cross-sections: what a cable resists and weighs."""

import math
from dataclasses import dataclass

from .checks import require_positive


@dataclass(frozen=True)
class Section:
    """A section given by values.

    mass_per_length: rho_A [kg/m].   bending_stiffness: EI [N m^2].   axial_stiffness: EA [N].
    """

    mass_per_length: float
    bending_stiffness: float
    axial_stiffness: float

    def __post_init__(self) -> None:
        units = {"mass_per_length": "kg/m", "bending_stiffness": "N m^2", "axial_stiffness": "N"}
        for name, unit in units.items():
            require_positive("Section", unit, name, getattr(self, name))


@dataclass(frozen=True)
class Round:
    """Solid round cross-section.   radius [m], density [kg/m^3], youngs_modulus [Pa]."""

    radius: float
    density: float
    youngs_modulus: float

    def __post_init__(self) -> None:
        for name, unit in (("radius", "m"), ("density", "kg/m^3"), ("youngs_modulus", "Pa")):
            require_positive("Round section", unit, name, getattr(self, name))

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
