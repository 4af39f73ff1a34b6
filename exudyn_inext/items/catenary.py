"""The curve in which a cable without bending stiffness hangs between two points.

With s the arc length, H / w = a the horizontal tension over the weight per length, and sigma the slope,

    sigma = sigma_0 + s / a,    x = a [asinh sigma],    y = a [sqrt(1 + sigma^2)],    each from sigma_0 on;

ends at a distance h and a height v ask for sinh(u) / u = sqrt(L^2 - v^2) / h, u = h / 2a, and
asinh sigma_0 = artanh(v / L) - u: H. M. Irvine, Cable Structures, MIT Press 1981, section 1.2.
"""

import numpy as np
from scipy.optimize import brentq

from ..arrays import Array
from ..errors import InputError

NEARLY_STRAIGHT = 1e-12  # length over distance, less one
STEEPEST = 1e-6  # horizontal distance over the length of a cable that is not straight


def hanging_curve(start: Array, end: Array, length: float, up: Array, at: Array) -> tuple[Array, Array]:
    """Positions (n, 3) [m] and tangents (n, 3) at arc lengths `at` (n,) [m].

    Args:
        start, end: (3,) [m].   length: of the cable [m].   up: (3,) unit vector against the gravity.

    Raises:
        InputError: a cable that is too short, or hangs between points one above the other.
    """
    span = end - start
    distance, height = float(np.linalg.norm(span)), float(span @ up)
    if length < distance:
        raise InputError(
            f"length = {length:g} m is less than {distance:g} m, the distance of positionStart and "
            "positionEnd: give a longer cable, or one with axial stiffness, ObjectANCFCable."
        )
    if length <= (1.0 + NEARLY_STRAIGHT) * distance:
        return start + at[:, np.newaxis] / length * span, np.tile(span / distance, (len(at), 1))
    along = span - height * up
    h = float(np.linalg.norm(along))
    if h < STEEPEST * length:
        raise InputError(
            f"positionStart and positionEnd lie one above the other (horizontal distance {h:g} m, at least "
            f"{STEEPEST * length:.3g} m): the cable would fold, and has no tangent at its lowest point; move "
            "one end."
        )
    u = _half_span(np.sqrt(length**2 - height**2) / h)
    a = 0.5 * h / u
    first = np.sinh(np.arctanh(height / length) - u)
    slope = first + at / a
    x = a * (np.arcsinh(slope) - np.arcsinh(first))
    y = a * (np.hypot(1.0, slope) - np.hypot(1.0, first))
    steep, flat = slope / np.hypot(1.0, slope), 1.0 / np.hypot(1.0, slope)
    positions, tangents = (
        np.outer(one, along / h) + np.outer(other, up) for one, other in ((x, y), (flat, steep))
    )
    return start + positions, tangents


def _half_span(ratio: float) -> float:
    """u of sinh(u) / u = ratio > 1."""
    highest = 2.0 * np.log(2.0 * ratio) + 2.0  # sinh(u) / u is larger there

    def excess(u: float) -> float:
        return float(u + np.log(-np.expm1(-2.0 * u) / (2.0 * u)) - np.log(ratio))

    return float(brentq(excess, 1e-9, highest, xtol=1e-15, rtol=1e-14))
