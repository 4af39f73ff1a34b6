"""Gravity: a force density rho_A g, uniform on each element, and m g of point masses."""

import numpy as np

from ..arrays import Array
from ..cable.attached import place_on_elements
from ..cable.cable import Cable
from ..element.external_force import point_force, uniform_force
from ..element.forms import forms_of_mesh


def gravity_force(cable: Cable, gravity: Array) -> Array:
    """Generalised force of gravity.

    Args:
        cable: the cable.
        gravity: (dim,) acceleration g, or (N, dim), one of each element [m/s^2].

    Returns:
        (n, 2, dim) [N, Nm].
    """
    gravity = np.broadcast_to(np.asarray(gravity, dtype=float), (cable.number_of_elements, cable.dimension))
    density = cable.section.mass_per_length * gravity
    elements = forms_of_mesh(uniform_force, cable.element_lengths)[:, :, None] * density[:, None]
    force = np.zeros(cable.reference.shape)
    force[:-1] += elements[:, :2]
    force[1:] += elements[:, 2:]
    for point in cable.point_masses:
        k, xi = place_on_elements(point.arc_length, cable.element_lengths)
        own = point_force(point.heavy * gravity[k], xi, float(cable.element_lengths[k]))
        force[k : k + 2] += own.reshape(2, 2, -1)
    return force
