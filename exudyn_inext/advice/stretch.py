"""What is lost by calling a cable inextensible."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array


@dataclass(frozen=True)
class Tension:
    """Of one cable in the inextensible motion.   rms, largest: over time, of the largest along it [N].

    length: of the cable [m].   mass_per_length: rho_A [kg/m].
    """

    rms: float
    largest: float
    length: float
    mass_per_length: float


def stretch_error(tensions: Sequence[Tension], axial_stiffness: float, values: Array) -> float:
    """Estimate of what stretch moves the observed point by [m].

    A strain e lengthens the cable by e L; a motion along a path s, which a longer cable traverses more slowly
    (frequencies fall by e / 2), lags behind by e s / 2. Of several cables the one that gives most counts.

    Args:
        tensions: of the cables.   axial_stiffness: EA [N].   values: (T, m) positions [m].
    """
    path = float(np.linalg.norm(np.diff(values, axis=0), axis=1).sum())
    return max(one.rms / axial_stiffness * (one.length + 0.5 * path) for one in tensions)


def axial_period(tension: Tension, axial_stiffness: float) -> float:
    """Of the first axial vibration of a cable that is held at one end, 4 L sqrt(rho_A / EA) [s]."""
    return float(4.0 * tension.length * np.sqrt(tension.mass_per_length / axial_stiffness))
