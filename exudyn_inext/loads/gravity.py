"""Gravity: a uniform force density rho_A g."""

import numpy as np

from ..arrays import Array
from ..chain.cable import Cable
from ..element.external_force import uniform_force
from ..element.forms import forms_of_mesh


def gravity_force(cable: Cable, gravity: Array) -> Array:
    """Generalised force of gravity.

    Args:
        cable: the cable.
        gravity: (dim,) acceleration g [m/s^2].

    Returns:
        (n, 2, dim) [N, Nm].
    """
    density = cable.section.mass_per_length * np.asarray(gravity, dtype=float)
    elements = np.multiply.outer(forms_of_mesh(uniform_force, cable.element_lengths), density)
    force = np.zeros(cable.reference.shape)
    force[:-1] += elements[:, :2]
    force[1:] += elements[:, 2:]
    return force
