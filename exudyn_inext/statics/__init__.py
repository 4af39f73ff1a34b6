"""Static equilibrium of a cable on its constraint manifold, and whether it is stable."""

from .equilibrium import Equilibrium, StaticOptions, find_equilibrium
from .potential import Potential
from .stability import smallest_eigenvalue

__all__ = ["Equilibrium", "Potential", "StaticOptions", "find_equilibrium", "smallest_eigenvalue"]
