"""Initial velocities that violate constraints: moved onto them in the mass metric, with a word about it.

This is what impulses at the constraints do, v' = v + M^-1 C_q^T mu with C_q v' + c_t = 0: whatever momentum
the constraints leave alone is kept.
"""

import warnings

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..cable.sparse_forms import mass_of_cable
from ..constraints import constraints_of_cable
from ..statics.saddle_point import factorise, solve


def kinetic_energy(cable: Cable, v: Array) -> float:
    """v . M v / 2 [J].   v: (n_dof,)."""
    return 0.5 * float(v @ (mass_of_cable(cable) @ v))


def nearest_velocities(cable: Cable, q: Array, v: Array, time: float) -> Array:
    """(n_dof,) velocities on all constraints of a cable, nearest to v in the mass metric.

    Args:
        q, v: (n_dof,) state; q on the constraints, which must be independent.   time: of it [s].
    """
    at, rates = q.reshape(cable.reference.shape), v.reshape(cable.reference.shape)
    constraints = constraints_of_cable(cable)
    factor = factorise(mass_of_cable(cable), constraints.jacobian(at, time))
    change, _ = solve(factor, np.zeros(v.size), -constraints.rate(at, rates, time))
    nearest: Array = v + change
    return nearest


def warn_of_velocities(found: str, before: float, after: float) -> None:
    """Say what was violated, and what the projection did to the kinetic energy.

    Args:
        found: who violates what, and by how much.   before, after: kinetic energy [J].
    """
    share = f" ({100.0 * (after - before) / before:+.2f} %)" if before > 0.0 else ""
    warnings.warn(
        f"{found}: they have been projected onto the constraints in the mass metric, as impulses there do, "
        f"which changed the kinetic energy from {before:.6g} J to {after:.6g} J{share}. If that is not "
        "meant, correct the initial values.",
        stacklevel=2,
    )
