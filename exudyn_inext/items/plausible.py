"""A warning of cables whose numbers cannot be meant in kg, m, s: usually millimetres in one of them."""

import math
import warnings

from ..cable.cable import Cable

SOUND = 5000.0  # sqrt(E / rho) of steel, aluminium and glass [m/s]
AIR = 1.0  # [kg/m^3]
LONG, SLENDER = 100.0, 1e6  # of an element [m]; length over diameter [-]
FREE_FREE = 22.373  # (omega L^2 / sqrt(EI / rho_A)) of the lowest bending vibration


def warn_of_units(cable: Cable) -> None:
    """Warn if no solid round section of a stiff material has these constants, or if elements are huge.

    EI / rho_A = E / rho d^2 / 16 gives the diameter d, from which density and slenderness follow.
    """
    section, length = cable.section, cable.length
    ratio = math.sqrt(section.bending_stiffness / section.mass_per_length)
    diameter = 4.0 * ratio / SOUND
    density = 4.0 * section.mass_per_length / (math.pi * diameter**2)
    longest = float(cable.element_lengths.max())
    if density < AIR:
        wrong = f"a density of {density:.2g} kg/m^3, less than that of air"
    elif longest > LONG and length > SLENDER * diameter:
        wrong = f"elements of {longest:.4g} m"
    else:
        return
    period = 2.0 * math.pi * length**2 / (FREE_FREE * ratio)
    warnings.warn(
        f"length = {length:g} m, massPerLength = {section.mass_per_length:g} kg/m and bendingStiffness = "
        f"{section.bending_stiffness:g} N m^2 can hardly be meant: a round wire of metal would have a "
        f"diameter of {diameter:.2g} m, a slenderness of {length / diameter:.2g}, a lowest bending period of "
        f"{period:.2g} s and {wrong}. Check the units: m, kg and s, for EI N m^2 (1 N mm^2 = 1e-6 N m^2).",
        stacklevel=3,
    )
