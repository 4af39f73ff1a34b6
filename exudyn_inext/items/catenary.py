"""The curve in which a cable without bending stiffness hangs between two points.

With s the arc length, H / w = a the horizontal tension over the weight per length, and sigma the slope,

    sigma = sigma_0 + s / a,    x = a [asinh sigma],    y = a [sqrt(1 + sigma^2)],    each from sigma_0 on;

ends at a distance h and a height v ask for sinh(u) / u = sqrt(L^2 - v^2) / h, u = h / 2a, and
asinh sigma_0 = artanh(v / L) - u: H. M. Irvine, Cable Structures, MIT Press 1981, section 1.2.
"""

import warnings

import numpy as np
import scipy

from ..arrays import Array
from ..cable.cable import Cable, CurvatureMeasure, Section
from ..errors import InputError
from ..statics import potential_of
from ..statics.feasible import feasible

NEARLY_STRAIGHT = 1e-12  # length over distance, less one
STEEPEST = 1e-6  # horizontal distance over the length of a cable that is not straight
FAR = 0.25  # of an element: distance of a node from the curve, where elements follow its bend within 0.1
ROUND_OFF = 1e-13  # of lengths of elements over that of the cable


def hanging_curve(span: Array, length: float, up: Array, at: Array) -> tuple[Array, Array]:
    """Positions (n, 3) from the start on [m] and tangents (n, 3) at arc lengths `at` (n,) [m].

    Args:
        span: (3,) from start to end [m].   length: of the cable [m].   up: (3,) unit vector, against gravity.

    Raises:
        InputError: a cable that is too short, or hangs between points one above the other.
    """
    distance, height = float(np.linalg.norm(span)), float(span @ up)
    if length < distance:
        raise InputError(
            f"length = {length:g} m is less than {distance:g} m, the distance of positionStart and "
            "positionEnd: give a longer cable, or CableShape.Line and InextensibleCable with axialStiffness "
            f"and referenceAxialStrain = {length / distance - 1.0:.3g}."
        )
    if length <= (1.0 + NEARLY_STRAIGHT) * distance:
        return at[:, np.newaxis] / length * span, np.tile(span / distance, (len(at), 1))
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
    return positions, tangents


def of_constant_length(q: Array, length: float) -> Array:
    """Near nodes of an inextensible cable of equal elements; the first and the last point stay.

    Args:
        q: (n, 2, 3) positions [m] and unit tangents of a curve.   length: of the cable [m].

    Raises:
        InputError: the elements are too long for the bends of the curve.
    """
    number = len(q) - 1
    size = length / number
    fixed = np.zeros((number + 1, 2), dtype=bool)
    fixed[[0, -1], 0] = True
    dimension = 3 if q[:, :, 2].any() else 2
    curve = q[:, :, :dimension] * [[1.0 / size], [1.0]]  # in lengths of an element
    cable = Cable(
        reference=curve,
        element_lengths=np.ones(number),
        section=Section(1.0, 1.0),
        measure=CurvatureMeasure.SECOND_DERIVATIVE,
        length_constraints=number,
        fixed=fixed,
        straight_lengths=True,
    )
    tolerance = ROUND_OFF * number
    unloaded = potential_of([cable], np.zeros(curve.size), 0.0)
    nearest, left = feasible(unloaded, curve, tolerance=tolerance)
    if left > tolerance:
        raise InputError(
            f"numberOfElements = {number}: elements of {size:g} m are too long for the bend at "
            "the lowest point of the cable; use more elements, or move the ends apart."
        )
    _warn_if_far(size * float(np.linalg.norm((nearest - curve)[:, 0], axis=1).max()), number, length)
    nodes = q.copy()
    nodes[1:-1, 0, :dimension], nodes[:, 1, :dimension] = size * nearest[1:-1, 0], nearest[:, 1]
    return nodes


def _warn_if_far(off: float, number: int, length: float) -> None:
    """off: largest distance of a node from the curve [m]."""
    if off > FAR * length / number:
        warnings.warn(
            f"numberOfElements = {number}: elements of {length / number:.3g} m do not follow the bend at the "
            f"lowest point of the cable, so that nodes lie up to {off:.2g} m off the catenary, and the cable "
            "does not rest: call SolveEquilibrium before a run, use more elements, or move the ends apart.",
            stacklevel=4,
        )


def _half_span(ratio: float) -> float:
    """u of sinh(u) / u = ratio > 1."""
    highest = 2.0 * np.log(2.0 * ratio) + 2.0  # sinh(u) / u is larger there

    def excess(u: float) -> float:
        return float(u + np.log(-np.expm1(-2.0 * u) / (2.0 * u)) - np.log(ratio))

    return float(scipy.optimize.brentq(excess, 1e-9, highest, xtol=1e-15, rtol=1e-14))
