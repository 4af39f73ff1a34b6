"""Initial coordinates and velocities of a coupled scene on the manifold of its joints."""

import numpy as np

from ...arrays import Array
from ...coupling.coupled_system import CoupledSystem
from ...errors import SceneError
from ...system import accelerate_and_project
from ..consistent_start import StartCorrection, settle


def consistent_start(
    system: CoupledSystem, time: float, q: Array, v: Array, tolerance: float
) -> StartCorrection:
    """Move q and v (n,) onto the joints, in place; returns how far.

    Raises:
        SceneError: a joint is violated by more than the tolerance.
        RedundantConstraintError: joints that depend on each other.
    """
    if not system.has_joints:
        return StartCorrection()
    given_q, given_v = q.copy(), v.copy()
    external = np.array([time])
    accelerate_and_project(system, external, q, v, 0.0, np.zeros(len(q)), np.zeros(len(q)))
    _require_consistent(system, time, q, v, tolerance)
    settle(system, external, q, v)
    return StartCorrection(
        position=float(np.abs(q - given_q).max()), velocity=float(np.abs(v - given_v).max())
    )


def _require_consistent(system: CoupledSystem, time: float, q: Array, v: Array, tolerance: float) -> None:
    terms, solve = system.join(time, q, v), system.solve
    speed = max(1.0, float(np.abs(v).max(initial=0.0)))
    rates = (solve.times_jacobian(v) + terms.drift) / speed
    for what, violation in (("coordinates", terms.value), ("velocities", rates)):
        row = int(np.argmax(np.abs(violation)))
        if not abs(violation[row]) <= tolerance:
            raise SceneError(
                f"the initial {what} violate {system.surroundings.joints[row]} by {violation[row]:.3g} "
                f"(limit {tolerance:g}): correct the initial values or the markers of the joint, or let a "
                "larger startTolerance project them."
            )
