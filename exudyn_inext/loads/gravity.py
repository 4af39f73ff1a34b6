"""Gravity: a uniform force density rho_A g."""

import numpy as np

from ..arrays import Array
from ..chain.cable import Cable
from .distributed import distributed_load


def gravity_force(cable: Cable, gravity: Array) -> Array:
    """Generalised force of gravity.

    Args:
        cable: the cable.
        gravity: (dim,) acceleration g [m/s^2].

    Returns:
        (n, 2, dim) [N, Nm].
    """
    density = cable.section.mass_per_length * np.asarray(gravity, dtype=float)
    return distributed_load(cable, lambda x: np.broadcast_to(density, (len(x), len(density))))
