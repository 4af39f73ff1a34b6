"""What point masses and drag add to the section force along an element, from the balance of momentum.

n_x = rho_A r_tt - f becomes n_x = ... - f_drag between point masses, and at one n jumps by m (r_tt - g).
"""

from typing import Any

import numpy as np

from ..arrays import Array
from ..compiled import plain
from ..element.drag import drag_density
from ..element.shape_functions import first_derivatives, quadrature, shape_functions
from .attached import place_on_elements
from .cable import Cable

POINTS, WEIGHTS = quadrature(1.0)


def attached_variation(cable: Cable, state: Any, gravity: Array, k: np.ndarray, xi: Array) -> Array:
    """n at xi of element k, less its mean weighted with 6 xi (1 - xi), from point masses and drag.

    Args:
        cable: the cable.   state: its q, v, a (n, 2, dim).   gravity: (N, dim) g of each element [m/s^2].
        k: (m,) elements.   xi: (m,) within them, 0 to 1 [-].

    Returns:
        (m, dim) [N].
    """
    variation = np.zeros((len(k), cable.dimension))
    for point in cable.point_masses:
        element, place = place_on_elements(point.arc_length, cable.element_lengths)
        shape = shape_functions(place, float(cable.element_lengths[element]))
        acceleration = shape @ _of_element(state.a, element)
        jump: Array = point.mass * acceleration - point.heavy * gravity[element]
        mean = 1.0 - place**2 * (3.0 - 2.0 * place)
        here = k == element
        variation[here] += np.multiply.outer((xi[here] > place) - mean, jump)
    if cable.drag is not None:
        weights = WEIGHTS * 6.0 * POINTS * (1.0 - POINTS)
        for row, (element, x) in enumerate(zip(k.tolist(), xi, strict=True)):
            mean_drag = weights @ np.stack([_drag_until(cable, state, element, at) for at in POINTS])
            variation[row] -= _drag_until(cable, state, element, x) - mean_drag
    return variation


def _of_element(x: Array, k: int) -> Array:
    """(4, dim) nodal values of element k."""
    return x[k : k + 2].reshape(4, -1)


def _drag_until(cable: Cable, state: Any, k: int, end: float) -> Array:
    """(dim,) drag on element k from its left node to the abscissa `end` [N]."""
    length, axes = float(cable.element_lengths[k]), tuple(range(cable.dimension))
    density = plain(drag_density)
    law, total = cable.drag.law(), np.zeros(cable.dimension)  # type: ignore[union-attr]
    for point, weight in zip(POINTS * end, WEIGHTS * end * length, strict=True):
        slope = first_derivatives(point, length) @ _of_element(state.q, k)
        force = shape_functions(point, length) @ _of_element(state.v, k)
        density(axes, law, slope, force)
        total += weight * force
    return total


def drag_rate(cable: Cable, gravity: Array, v: Array) -> float:
    """Largest d [1/s] of v' = -d v that drag gives at the speeds to be expected.

    These are the present ones, v (n, 2, dim), and that of free fall under gravity (dim,) or (N, dim) [m/s^2].
    """
    drag, density = cable.drag, cable.section.mass_per_length
    if drag is None:
        return 0.0
    strongest = np.linalg.norm(gravity, axis=-1).max()
    fall = np.sqrt(density * strongest / drag.normal) if drag.normal > 0.0 else 0.0
    speed = max(fall, np.linalg.norm(v[:, 0] - np.array(drag.flow), axis=1).max())
    return float(2.0 * max(drag.normal, drag.tangential) * speed / density)
