"""Distance of a trajectory to the reference, and how good that measure is."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from exudyn_inext.errors import InputError
from reference_models.trajectory import Array, Trajectory


@dataclass(frozen=True)
class Distance:
    """maximum and root mean square over the samples [m]."""

    maximum: float
    rms: float


def distance(first: Array, second: Array) -> Distance:
    """Distance between (n, 3) positions [m], sample by sample."""
    lengths = np.linalg.norm(first - second, axis=1)
    return Distance(float(lengths.max()), float(np.sqrt(np.mean(lengths**2))))


def distance_to_reference(trajectory: Trajectory, reference: Trajectory) -> Distance:
    """Distance to the reference at the trajectory's own times; between samples a cubic spline."""
    tolerance = 1e-6
    end = reference.times[-1]
    if trajectory.times[-1] > end + tolerance:
        raise InputError(
            f"the trajectory ends at {trajectory.times[-1]:g} s, the reference at {end:g} s: shorten the run."
        )
    spline = CubicSpline(reference.times, reference.positions)
    return distance(trajectory.positions, spline(trajectory.times))


def interpolation_error(reference: Trajectory) -> Distance:
    """Error of the spline with every second sample left out, measured at those samples.

    This is the error at twice the sampling period, hence an upper bound in practice: a smooth
    motion would have a sixteenth of it at the full sampling.
    """
    spline = CubicSpline(reference.times[::2], reference.positions[::2])
    return distance(reference.positions[1:-1:2], spline(reference.times[1:-1:2]))
