"""Cross-sections: what a cable resists and weighs."""

import math
from dataclasses import dataclass

from exudyn_inext.checks import require_positive


@dataclass(frozen=True)
class Section:
    """A section given by values.

    mass_per_length: rho_A [kg/m].   bending_stiffness: EI [N m^2].   axial_stiffness: EA [N].
    """

    mass_per_length: float
    bending_stiffness: float
    axial_stiffness: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            require_positive(f"Section: {name}", value)


def Round(radius: float, density: float, youngs_modulus: float) -> Section:
    """Solid round cross-section.   radius [m], density [kg/m^3], youngs_modulus [Pa]."""
    require_positive("Round section: radius", radius)
    require_positive("Round section: density", density)
    require_positive("Round section: youngs_modulus", youngs_modulus)
    area, second_moment = math.pi * radius**2, math.pi * radius**4 / 4
    return Section(density * area, youngs_modulus * second_moment, youngs_modulus * area)
