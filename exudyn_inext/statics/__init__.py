"""Static equilibrium of cables and scenes on their constraint manifold, and whether it is stable."""

from .equilibrium import GROWS, Equilibrium, find_equilibrium
from .joined_potential import JoinedPotential
from .potential import Potential, support_forces
from .stability import smallest_eigenvalue
from .stretching import potential_of, potentials_of

__all__ = [
    "GROWS",
    "Equilibrium",
    "JoinedPotential",
    "Potential",
    "find_equilibrium",
    "potential_of",
    "potentials_of",
    "smallest_eigenvalue",
    "support_forces",
]
