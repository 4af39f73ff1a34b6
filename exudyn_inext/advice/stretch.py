"""What is lost by calling a cable inextensible."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array


@dataclass(frozen=True)
class Tension:
    """Of one cable in the inextensible motion.   rms, largest: over time, of the largest along it [N].

    length: of the cable [m].
    spans: distances of supports, and how far the cable between them reaches [m].
    """

    rms: float
    largest: float
    length: float
    spans: Sequence[tuple[float, float]] = ()


def sag_by_stretch(strain: float, distance: float, reach: float) -> float:
    """By how much a strain lowers a cable between supports [m], from the sag (3/8 L (L - distance))^(1/2).

    That is the parabola's, L its length; so a taut cable of L = distance sags by (3/8 e)^(1/2) L.
    """
    slack = max(reach - distance, 0.0)
    return math.sqrt(0.375 * reach) * (math.sqrt(slack + strain * reach) - math.sqrt(slack))


def stretch_error(tension: Tension, axial_stiffness: float, values: Array) -> float:
    """Estimate of what stretch moves a point of a cable by [m].

    The largest strain e lengthens the cable by e L, and lowers a taut one between supports by more. A motion
    along a path s, which a longer cable traverses more slowly (frequencies fall by e / 2), lags behind by
    e s / 2, with the root mean square of e.

    Args:
        tension: of the cable.   axial_stiffness: EA [N].   values: (T, m) positions of the point [m].
    """
    path = float(np.linalg.norm(np.diff(values, axis=0), axis=1).sum())
    strain = tension.largest / axial_stiffness
    sags = [sag_by_stretch(strain, *span) for span in tension.spans]
    return max([strain * tension.length, *sags]) + 0.5 * path * tension.rms / axial_stiffness
