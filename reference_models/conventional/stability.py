"""The largest stable step of a native explicit integrator, found by bisection on short runs.

Divergence criterion: NaN, or a nodal stretch | |r_x| - 1 | above STRETCH_LIMIT when the run ends.
The loads of a cable stretch it by about weight / EA (pendulum: 7e-6; 3e-5 at most in any stable
run); coarse meshes with full quadrature, which lock, by more (ring, 20 elements: 2.6e-4, 16: 4e-4).
Waiting for NaN alone would be wrong for RK44: above its limit the highest axial mode grows
only until its own nonlinearity holds it, at stretches of 6e-4 and more; the run then ends with
finite numbers and a tip that is a metre off.

Why short runs suffice: above the limit, h w_max = 2 (1 + e), velocity Verlet amplifies the axial
mode by about exp(2 sqrt(2 e)) a step, so that round-off (1e-16) reaches order one after some
18 / sqrt(2 e) steps. The 8000 steps of a short run reveal e > 3e-6. Configurations that only occur
later can have a higher frequency; so the full run confirms the step, or it is lowered.
"""

from collections.abc import Callable

import exudyn
import numpy as np

from exudyn_inext.errors import DivergenceError

from ..model import Model
from ..scenes import Scene
from ..trajectory import Array
from .model import Quadrature, build_for_explicit
from .settings import Explicit, ExplicitIntegrator
from .solve import solve

IMAGINARY_LIMIT: dict[ExplicitIntegrator, float] = {
    "velocityVerlet": 2.0,
    "rungeKutta44": 2.0 * np.sqrt(2.0),
}
"""h w at which the scheme becomes unstable for an undamped oscillator."""

SHORT_RUN_STEPS = 8000
STRETCH_LIMIT = 5e-4
"""Largest credible stretch of a nearly inextensible cable [-]."""

_RESOLUTION = 2e-3
_BACK_OFF = 0.995


def largest_frequency(model: Model) -> float:
    """w_max [rad/s] of the model in its initial state, from a dense eigenvalue solve."""
    squares, _ = model.mbs.ComputeODE2Eigenvalues()
    return float(np.sqrt(np.max(squares)))


def largest_stable_step(
    scene: Scene, elements: int, integrator: ExplicitIntegrator, quadrature: Quadrature = "full"
) -> float:
    """Largest step [s] with which the whole scene runs without divergence, to about 0.5 %."""
    model = build_for_explicit(scene, elements, quadrature)
    estimate = IMAGINARY_LIMIT[integrator] / largest_frequency(model)

    def stable(step_size: float, end_time: float) -> bool:
        fresh = build_for_explicit(scene, elements, quadrature)
        return is_stable(fresh, Explicit(step_size, integrator), end_time)

    def stable_briefly(step_size: float) -> bool:
        return stable(step_size, min(scene.end_time, SHORT_RUN_STEPS * step_size))

    step_size = _bisect(stable_briefly, estimate)
    while not stable(step_size, scene.end_time):
        step_size *= _BACK_OFF
    return step_size


def _bisect(stable: Callable[[float], bool], estimate: float) -> float:
    """Largest stable value near the estimate, to _RESOLUTION of it."""
    low, high = 0.9 * estimate, 1.1 * estimate
    while not stable(low):
        low, high = 0.8 * low, low
    while stable(high):
        low, high = high, 1.25 * high
    while high - low > _RESOLUTION * estimate:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def is_stable(model: Model, solver: Explicit, end_time: float) -> bool:
    """Whether a run to end_time [s] stays within what an inextensible cable can do."""
    try:
        trajectory = solve(model, solver, end_time)
    except DivergenceError:
        return False
    return trajectory.is_finite and _largest_stretch(model) <= STRETCH_LIMIT


def _largest_stretch(model: Model) -> float:
    """Largest | |r_x| - 1 | [-] of all nodes in the current state; NaN after an overflow."""
    dimension = 2 if model.scene.is_planar else 3
    coordinates = np.array([_current_coordinates(model, node) for node in model.nodes])
    return float(np.max(np.abs(np.linalg.norm(coordinates[:, dimension:], axis=1) - 1.0)))


def _current_coordinates(model: Model, node: int) -> Array:
    """Position and slope of a node; Exudyn stores displacements from the reference."""
    displacements = model.mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates)
    return np.asarray(displacements + model.mbs.GetNodeParameter(node, "referenceCoordinates"))
