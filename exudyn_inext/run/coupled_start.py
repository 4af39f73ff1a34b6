"""Initial coordinates and velocities of a coupled scene on the manifold of its joints."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..errors import SceneError
from ..scene.coupled_system import CoupledSystem
from ..system import accelerate_and_project
from .compiled_scene import CompiledScene
from .consistent_start import PLACES, RATES, StartCorrection, kinetic_energy, settle, warn_of_velocities
from .redundancy import require_mobile_points


def consistent_start(
    system: CoupledSystem, cables: Sequence[Cable], time: float, q: Array, v: Array, tolerance: float
) -> StartCorrection:
    """Move q and v (n,) onto the joints, in the mass metric, in place; returns how far.

    Velocities that violate a joint by more than the tolerance are warned of.

    Args:
        system: the scene; its first parts are the cables, the next one the bodies.   cables: without
            mass scaling.   time: of the start [s].   tolerance: see `ExplicitSettings.startTolerance`.

    Raises:
        SceneError: a joint is violated by more than the tolerance, or its rate is not finite.
        RedundantConstraintError: joints that depend on each other.
    """
    if not system.has_joints:
        return StartCorrection()
    given_q, given_v = q.copy(), v.copy()
    external, (a, projected) = np.array([time]), np.zeros((2, len(q)))
    accelerate_and_project(system, external, q, v, 0.0, a, projected)
    require_mobile_points(system, cables)
    said = _violations(system, time, q, v, tolerance)
    before = _kinetic_energy(system, cables, v) if said else 0.0
    settle(system, external, q, v, projected)
    if said:
        warn_of_velocities(said, before, _kinetic_energy(system, cables, v))
    return _correction(q - given_q, v - given_v)


def compiled_start(
    form: CompiledScene, time: float, q: Array, v: Array, tolerance: float
) -> StartCorrection | None:
    """As `consistent_start`, in compiled code; None where joints are violated, or depend on each other."""
    joints = form.system.items.joints
    if not len(joints.rows):
        return StartCorrection()
    given_q, given_v = q.copy(), v.copy()
    external, (a, projected) = form.loads.at(time), np.zeros((2, len(q)))
    form.accelerate(external, q, v, 0.0, a, projected)
    speed = max(1.0, float(np.abs(v).max()))
    worst = np.abs([joints.value, joints.rate / speed]).max()
    if form.has_dependent_joints or not worst <= tolerance:
        return None
    settle(form.system, external, q, v, projected)
    return _correction(q - given_q, v - given_v)


def _correction(way: Array, change: Array) -> StartCorrection:
    """way, change: (n,) of coordinates and of velocities."""
    return StartCorrection(position=float(np.abs(way).max()), velocity=float(np.abs(change).max()))


def _violations(system: CoupledSystem, time: float, q: Array, v: Array, tolerance: float) -> str:
    """What is to be said of the velocities, or nothing; SceneError for what cannot be projected.

    system: has been evaluated there.
    """
    terms = system.join(time, q, v) if system.in_one else system.terms
    solve = system.solve
    speed = max(1.0, float(np.abs(v).max(initial=0.0)))
    rates = (solve.times_jacobian(v) + terms.drift) / speed
    for what, violation in ((PLACES, terms.value), (RATES, rates)):
        row = int(np.argmax(np.abs(violation)))
        if abs(violation[row]) <= tolerance:
            continue
        said = (
            f"the {what} violate {system.native_items.joints[row]} by {violation[row]:.3g} "
            f"(limit {tolerance:g})"
        )
        if what == RATES and np.isfinite(violation[row]):
            return said
        raise SceneError(
            f"{said}: correct the initial values or the markers of the joint, set back what step functions "
            "have set in an earlier run, or let a larger startTolerance project them."
        )
    return ""


def _kinetic_energy(system: CoupledSystem, cables: Sequence[Cable], v: Array) -> float:
    """Of cables and bodies, the masses of which are those of the last evaluation [J]."""
    parts = [part.dofs for part in system.parts]
    bodies = system.parts[len(cables)]
    of_cables = sum(kinetic_energy(cable, v[dofs]) for cable, dofs in zip(cables, parts, strict=False))
    return of_cables + float(bodies.system.kinetic_energy(v[bodies.dofs]))
