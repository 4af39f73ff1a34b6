"""A concentrated force at any arc length of the cable."""

import numpy as np

from ..arrays import Array
from ..cable.attached import place_on_elements
from ..cable.cable import Cable
from ..element.external_force import point_force
from ..errors import InputError

ROUND_OFF = 1e-12  # of the sum of the element lengths


def point_load(cable: Cable, force: Array, arc_length: float) -> Array:
    """Generalised force of a concentrated force, Eq. (17).

    Args:
        cable: the cable.
        force: (dim,) [N].
        arc_length: where it acts, 0 to the cable's length [m].

    Returns:
        (n, 2, dim) [N, Nm].

    Raises:
        InputError: the arc length is not on the cable.
    """
    if not 0.0 <= arc_length <= cable.length * (1.0 + ROUND_OFF):
        raise InputError(
            f"arc length = {arc_length!r} m is not on the cable: it runs from 0 to {cable.length} m."
        )
    k, xi = place_on_elements(arc_length, cable.element_lengths)
    result = np.zeros(cable.reference.shape)
    element = point_force(np.asarray(force, dtype=float), xi, float(cable.element_lengths[k]))
    result[k], result[k + 1] = element[:2], element[2:]
    return result
