"""A system about a rest: what resists small motions on its constraints."""

from typing import NamedTuple

from ..arrays import Array, SparseArray
from .static_system import StaticSystem


class SmallMotions(NamedTuple):
    """Of a system about its rest at q: hessian (n, n) of the Lagrangian, symmetric; jacobian (m, n).

    skew: (n, n) the rest of the Hessian, of loads without a potential.
    """

    system: StaticSystem
    q: Array
    multipliers: Array
    hessian: SparseArray
    jacobian: SparseArray
    skew: SparseArray


def small_motions(system: StaticSystem, q: Array, multipliers: Array) -> SmallMotions:
    """system: at rest at q, with these multipliers."""
    hessian = system.hessian(q, multipliers)
    symmetric = 0.5 * (hessian + hessian.T)  # of torques it is not
    return SmallMotions(system, q, multipliers, symmetric, system.jacobian(q), hessian - symmetric)
