"""A force density along the cable."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..cable.cable import Cable
from ..element.external_force import distributed_force


def distributed_load(cable: Cable, load: Callable[[Array], Array]) -> Array:
    """Generalised force of a force density f(x) along the cable, Eq. (17).

    Args:
        cable: the cable.
        load: arc lengths (g,) [m] to force densities (g, dim) [N/m].

    Returns:
        (n, 2, dim) [N, Nm].
    """
    force = np.zeros(cable.reference.shape)
    starts = np.append(0.0, np.cumsum(cable.element_lengths))[:-1]
    for k, (start, length) in enumerate(zip(starts, cable.element_lengths, strict=True)):
        element = distributed_force(load, start, length)
        force[k] += element[:2]
        force[k + 1] += element[2:]
    return force
