"""The lowest vibrations about an equilibrium, on its constraints."""

from typing import Any

import numpy as np
import scipy

from ..arrays import Array
from .saddle_point import factorise, solve
from .small_motions import SmallMotions
from .static_system import StaticSystem

FEW = 300  # coordinates, of which all vibrations are found at once
INDEPENDENT = 1e-6  # relative error of violations that are asked for
SHIFT = 1e-3  # below zero, in units of the loads' own eigenvalue: what is free to move has an inverse, too
STEP = 1e-6  # of differences of forces [m, -]


def balance(system: StaticSystem, q: Array) -> tuple[Array, float]:
    """Multipliers (m,) of the constraints at q, and the largest force [N] that they leave unbalanced.

    Raises:
        RuntimeError: constraints depend on each other.
    """
    force, jacobian = system.force(q), system.jacobian(q)
    factor = factorise(system.metric, jacobian, system.order)
    asked = np.random.default_rng(1).standard_normal(jacobian.shape[0])
    moved, _ = solve(factor, np.zeros(force.size), asked)
    if not np.allclose(jacobian @ moved, asked, rtol=0.0, atol=INDEPENDENT):  # round-off hides a zero pivot
        raise RuntimeError("constraints depend on each other")
    _, multipliers = solve(factor, force, np.zeros(jacobian.shape[0]))
    return multipliers, system.size(force - jacobian.T @ multipliers)


def vibrations(about: SmallMotions, number: int) -> tuple[Array, Array]:
    """w^2 of M x'' = -H x - J^T lam, J x = 0, with M for the mass and H for the Hessian of the Lagrangian.

    Args:
        about: the rest.   number: of the vibrations that are asked for; fewer are found if there are fewer.

    Returns:
        (k,) rising [1/s^2], and (k, n) vectors x with x . M x = 1.
    """
    system, hessian, jacobian = about.system, about.hessian, about.jacobian
    size = about.q.size
    number = min(number, size - jacobian.shape[0])
    if size > FEW and 2 * number < size - jacobian.shape[0]:
        return _by_lanczos(system, hessian, jacobian, number)
    basis = scipy.linalg.null_space(jacobian.toarray()) if jacobian.shape[0] else np.eye(size)
    reduced = [basis.T @ (matrix @ basis) for matrix in (hessian, system.mass)]
    values, vectors = scipy.linalg.eigh(*reduced, subset_by_index=[0, number - 1])
    return values, (basis @ vectors).T


def missed_forces(about: SmallMotions, steps: Array) -> Array:
    """(k, n) that resist small steps (k, n), and are not in the symmetric Hessian.

    They are of loads without a potential, and of functions that look at other places than their own.
    """
    found = -(about.hessian @ steps.T).T
    for own, step in zip(found, steps, strict=True):
        largest = float(np.abs(step).max())
        moved = STEP / largest * step
        change = _out_of_balance(about, about.q + moved) - _out_of_balance(about, about.q - moved)
        own += change * largest / (2.0 * STEP)
    return found


def _out_of_balance(about: SmallMotions, q: Array) -> Array:
    """(n,) force that would hold the system at q, beside its constraints."""
    return about.system.jacobian(q).T @ about.multipliers - about.system.force(q)


def shares_of(missed: Array, about: SmallMotions, values: Array) -> Array:
    """What forces that the Hessian misses do in vibrations, over what stiffness and inertia do (k,) [-].

    Both are measured by the work of the forces along what they move, so that the mesh does not matter.

    Args:
        missed: (k, n) forces in vibrations x with x . M x = 1.   about: the rest.
        values: (k,) w^2 of the vibrations [1/s^2].
    """
    shares, system = np.zeros(len(values)), about.system
    for k in np.flatnonzero(missed.any(axis=1)):
        level = abs(values[k]) - 2.0 * min(values[0], 0.0) + SHIFT * system.shift
        factor = factorise(about.hessian + level * system.mass, about.jacobian, system.order)
        moved, _ = solve(factor, missed[k], np.zeros(about.jacobian.shape[0]))
        shares[k] = np.sqrt(abs((missed[k] * moved).sum()) / level)
    return shares


def _by_lanczos(system: StaticSystem, hessian: Any, jacobian: Any, number: int) -> tuple[Array, Array]:
    """See `vibrations`."""
    size, zero, shift = hessian.shape[0], np.zeros(jacobian.shape[0]), -SHIFT * system.shift
    inverse = factorise(hessian - shift * system.mass, jacobian, system.order)
    project = factorise(system.mass, jacobian, system.order)
    start, _ = solve(project, np.random.default_rng(1).standard_normal(size), zero)
    operator = scipy.sparse.linalg.LinearOperator((size, size), lambda x: solve(inverse, x, zero)[0])
    values, vectors = scipy.sparse.linalg.eigsh(
        hessian, number, M=system.mass, sigma=shift, OPinv=operator, v0=start
    )
    order = np.argsort(values)
    return values[order], vectors.T[order]
