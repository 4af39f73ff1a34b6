"""Mesh convergence of the conventional formulation, free of time integration error."""

from ..scenes import Scene
from ..trajectory import Trajectory
from .model import Quadrature, build_for_explicit
from .settings import Explicit
from .solve import solve
from .stability import IMAGINARY_LIMIT, largest_frequency

SAFETY = 0.9
"""Step over the stability limit of the initial configuration."""


def explicit_solution(scene: Scene, elements: int, quadrature: Quadrature = "full") -> Trajectory:
    """Native velocity Verlet just below its stability limit.

    The limit is set by axial waves, which are far quicker than the motion: of the error, only what
    the mesh causes is left (halving the step changes the pendulum's error by less than 0.1 %).
    """
    model = build_for_explicit(scene, elements, quadrature)
    step_size = SAFETY * IMAGINARY_LIMIT["velocityVerlet"] / largest_frequency(model)
    return solve(model, Explicit(step_size))
