"""Initial coordinates and velocities of a cable on its constraint manifold."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from ..arrays import Array
from ..cable.assembly import CORRECTION
from ..cable.cable import Cable
from ..cable.linked_cable import LinkedCableSystem
from ..cable.many_cables import in_few_chains
from ..cable.sparse_forms import mass_of_cable
from ..called_system import Bound
from ..constraints import constraints_of_cable
from ..constraints.prescribed_motion import AT_REST, MOVING
from ..errors import SceneError
from ..scene.model import CableInScene
from ..statics.saddle_point import factorise, solve
from ..system import accelerate_and_project, correct_position
from .step_control import ROUND_OFF

_REMEDIES = {
    MOVING: "let the motion begin there (CreatePrescribedMotion takes positions, not displacements), ",
    AT_REST: "set an offset back that functions of an earlier run have left, ",
}


def kinetic_energy(cable: Cable, v: Array) -> float:
    """v . M v / 2 [J].   v: (n_dof,)."""
    return 0.5 * float(v @ (mass_of_cable(cable) @ v))


def nearest_velocities(cable: Cable, q: Array, v: Array, time: float) -> Array:
    """(n_dof,) velocities on all constraints of a cable, nearest to v in the mass metric.

    This is what impulses at the constraints do, v' = v + M^-1 C_q^T mu with C_q v' + c_t = 0: whatever
    momentum the constraints leave alone is kept.

    Args:
        q, v: (n_dof,) state; q on the constraints, which must be independent.   time: of it [s].
    """
    at, rates = q.reshape(cable.reference.shape), v.reshape(cable.reference.shape)
    constraints = constraints_of_cable(cable)
    factor = factorise(mass_of_cable(cable), constraints.jacobian(at, time))
    change, _ = solve(factor, np.zeros(v.size), -constraints.rate(at, rates, time))
    return v + change


def warn_of_velocities(found: str, before: float, after: float) -> None:
    """Say what was violated, and what the projection did to the kinetic energy, if that is seen there.

    Drift that an earlier run has left is not.

    Args:
        found: who violates what, and by how much.   before, after: kinetic energy [J].
    """
    if abs(after - before) < UNSEEN * before:
        return
    share = f" ({100.0 * (after - before) / before:+.2f} %)" if before > 0.0 else ""
    warnings.warn(
        f"{found}: they have been projected onto the constraints in the mass metric, as impulses there do, "
        f"which changed the kinetic energy from {before:.6g} J to {after:.6g} J{share}. If that is not "
        "meant, correct the initial values.",
        stacklevel=2,
    )


UNSEEN = 1e-8  # share of the kinetic energy: velocities change by a ten thousandth
PLACES, RATES = "initial coordinates", "initial velocities"
_ITERATIONS = 20


@dataclass(frozen=True)
class Violation:
    """The worst violated constraint of an initial state.

    size: of c [-, m], or of its rate over the speed.   what: what is violated.
    row: of the cable's constraints, which is violated.
    """

    size: float
    what: str = ""
    row: int = 0


NOTHING = Violation(0.0)


@dataclass(frozen=True)
class StartCorrection:
    """How far the projection onto the constraints moved an initial state.

    position, slope: largest change of a coordinate [m, -].   velocity: of a velocity [m/s, 1/s].
    """

    position: float = 0.0
    slope: float = 0.0
    velocity: float = 0.0


def are_kept(
    cables: Sequence[CableInScene], systems: Sequence[Any], states: Sequence[tuple[Array, Array]]
) -> bool:
    """Whether cables at rest, looked at together, fulfil their constraints; False: look at each.

    systems: of the cables.   states: coordinates and velocities (n, 2, dim) of each.
    """
    if any(v.any() for _, v in states) or any(cable.moving for cable in cables):
        return False
    rest = zip(cables, states, strict=True)
    for system, alike in in_few_chains(systems):
        some = [(one.cable.reference, one.cable.fixed, q) for one, (q, _) in islice(rest, len(alike))]
        reference, fixed, q = map(np.concatenate, zip(*some, strict=True))
        if not _is_kept(system, Bound(correct_position, system), reference, fixed, q):
            return False
    return True


def worst_violations(
    scene_cable: CableInScene, system: Any, q: Array, v: Array, time: float
) -> tuple[Violation, Violation]:
    """The worst violations of all constraints by initial q, and by v; both (n, 2, dim).

    system: of the cable.
    """
    speed = max(1.0, float(np.abs(v).max()))
    cable, none = scene_cable.cable, np.zeros(0)
    correct = Bound(correct_position, system)
    is_kept = _is_kept(system, correct, cable.reference, cable.fixed, q)
    rests = not (v.any() or scene_cable.moving)  # then no rate can be wrong
    rests = rests or (is_kept and _is_kept_along(system, correct, cable, q, v, speed))
    if rests and is_kept:
        return _worst(PLACES, none), _worst(RATES, none)
    constraints = constraints_of_cable(cable)
    values = none if is_kept else constraints.value(q, time)
    with np.errstate(invalid="ignore"):  # of what is infinite
        rates = none if rests else constraints.rate(q, v, time) / speed
    return _worst(PLACES, values), _worst(RATES, rates)


def _worst(what: str, violations: Array) -> Violation:
    sizes = np.abs(np.append(violations, 0.0))
    row = int(np.argmax(sizes))  # that of a NaN, if there is one
    return Violation(float(sizes[row]), what, row)


def _is_kept(system: Any, correct: Bound, reference: Array, fixed: np.ndarray, q: Array) -> bool:
    """Whether a chain without links keeps its constraints, by one compiled look; False: look closer."""
    if isinstance(system, LinkedCableSystem) or (q - reference)[fixed].any():
        return False
    places, memory = q.ravel(), np.zeros(q.size)
    is_finite = bool(np.isfinite(places).all())
    return is_finite and correct(places, places, np.inf, 0.0, memory) < ROUND_OFF


def _is_kept_along(system: Any, correct: Bound, cable: Cable, q: Array, v: Array, speed: float) -> bool:
    """The same of the rates of constraints: differences on both sides are exact, as these are quadratic."""
    if cable.stretches or v[cable.fixed].any() or not np.isfinite(v).all():
        return False
    memory, rates = np.zeros(q.size), []
    for way in (v / speed, -v / speed):
        at = (q + way).ravel()
        correct(at, at, np.inf, 0.0, memory)
        records = system.chain.nodes, system.chain.elements
        rates.append(np.concatenate([one["target"][:, CORRECTION] for one in records]))
    return bool(np.abs(rates[0] - rates[1]).max() < ROUND_OFF)


def require_consistent(scene_cable: CableInScene, violation: Violation, tolerance: float) -> None:
    """Raise SceneError, which names the worst constraint and by how much it is violated."""
    if not violation.size <= tolerance:
        said, kind = found(scene_cable, violation, tolerance)
        raise SceneError(
            f"{said}: correct the initial values of its nodes, {_REMEDIES.get(kind, '')}start "
            "from an equilibrium (SolveEquilibrium), or let a larger startTolerance project them."
        )


def found(scene_cable: CableInScene, violation: Violation, tolerance: float) -> tuple[str, str]:
    """What violates which constraint, and by how much; and its kind."""
    constraints = constraints_of_cable(scene_cable.cable)
    kind, where = constraints.describe(violation.row, scene_cable.item.node_names)
    said = (
        f"the {violation.what} of cable '{scene_cable.name}' violate the {kind} "
        f"constraint at the {where} by {violation.size:.3g} (limit {tolerance:g})"
    )
    return said, kind


def settle(system: Any, inputs: Array, q: Array, v: Array, projected: Array | None = None) -> None:
    """Move q and v (n_dof,) onto the constraints of a system, in the mass metric, in place.

    Args:
        system: with the protocols of `system`; its memory is used.   inputs: its external force.
        projected: (n_dof,) v on the constraints, if the system has just been evaluated at q and v.
    """
    memory, correction = np.zeros((2, q.size))
    end_velocity = np.zeros(q.size) if projected is None else projected
    for number in range(_ITERATIONS):
        if number or projected is None:
            accelerate_and_project(system, inputs, q, v, 0.0, memory, end_velocity)
        if not correct_position(system, inputs, q, ROUND_OFF, 0.0, correction) > ROUND_OFF:
            break
        q += correction
    v[:] = end_velocity


def agree(system: Any, inputs: Array, state: Any) -> None:
    """Project the velocities of an integrator's state onto the constraints; see `settle`."""
    memory, velocity = np.zeros(state.q.size), np.zeros(state.q.size)
    accelerate_and_project(system, inputs, state.q, state.v, 0.0, memory, velocity)
    state.v[:] = velocity


def project(
    scene_cable: CableInScene,
    system: Any,
    inputs: Array,
    state: Any,
    time: float,
    far: Violation | None,
    tolerance: float,
) -> StartCorrection:
    """Move q and v (n_dof,) of a state onto the constraints of a cable, in the mass metric, in place.

    Args:
        scene_cable: the cable.   system: its equations, whose memory is used.
        inputs: (n_external,) at the start.   state: of the integrator.   time: of the start [s].
        far: violation by the velocities that deserves a warning, or None.   tolerance: that it exceeds.
    """
    cable, q, v = scene_cable.cable, state.q, state.v
    given_q, given_v = q.copy(), v.copy()
    if far is not None:
        v[:] = nearest_velocities(cable, q, v, time)
        energies = kinetic_energy(cable, given_v), kinetic_energy(cable, v)
        warn_of_velocities(found(scene_cable, far, tolerance)[0], *energies)
    held = np.repeat(cable.fixed[:, :, None], cable.dimension, axis=2).ravel()
    q[held] = cable.reference.ravel()[held]
    v[held] = 0.0
    settle(system, inputs, q, v)
    moved = np.abs(q - given_q).reshape(cable.reference.shape)
    return StartCorrection(
        float(moved[:, 0].max()), float(moved[:, 1].max()), float(np.abs(v - given_v).max())
    )
