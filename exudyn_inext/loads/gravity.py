"""Gravity: a uniform force density rho_A g, and m g of point masses."""

import numpy as np

from ..arrays import Array
from ..chain.attached import placed
from ..chain.cable import Cable
from ..element.external_force import point_force, uniform_force
from ..element.forms import forms_of_mesh


def gravity_force(cable: Cable, gravity: Array) -> Array:
    """Generalised force of gravity.

    Args:
        cable: the cable.
        gravity: (dim,) acceleration g [m/s^2].

    Returns:
        (n, 2, dim) [N, Nm].
    """
    gravity = np.asarray(gravity, dtype=float)
    density = cable.section.mass_per_length * gravity
    elements = np.multiply.outer(forms_of_mesh(uniform_force, cable.element_lengths), density)
    force = np.zeros(cable.reference.shape)
    force[:-1] += elements[:, :2]
    force[1:] += elements[:, 2:]
    for point in placed(cable.point_masses, cable.element_lengths):
        k, length = point.element, float(cable.element_lengths[point.element])
        force[k : k + 2] += point_force(point.mass * gravity, point.xi, length).reshape(2, 2, -1)
    return force
