"""What the errors of a study are measured against, and how far a trajectory is from it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from exudyn_inext import InputError
from reference_models.data import reference_trajectory
from reference_models.scenes import Scene
from reference_models.trajectory import Array, Trajectory


@dataclass(frozen=True)
class Distance:
    """maximum and root mean square over the samples [m]."""

    maximum: float
    rms: float


@dataclass(frozen=True, eq=False)
class ReferenceSolution:
    """A trajectory of the scene's main point.

    source: what computed it.   uncertainty: how far the truth may be from it [m].
    file: inside reference_models/data, or None if it is computed in the study.
    """

    trajectory: Trajectory
    source: str
    uncertainty: float
    file: str | None = None


ReferenceOf = Callable[[Scene], ReferenceSolution]


def distance(first: Array, second: Array) -> Distance:
    """Distance between (n, 3) positions [m], sample by sample."""
    lengths = np.linalg.norm(first - second, axis=1)
    return Distance(float(lengths.max()), float(np.sqrt(np.mean(lengths**2))))


def positions_at(reference: Trajectory, times: Array) -> Array:
    """(n, 3) positions of the reference at other times; between samples a cubic spline."""
    positions: Array = CubicSpline(reference.times, reference.positions)(times)
    return positions


def distance_to_reference(trajectory: Trajectory, reference: Trajectory) -> Distance:
    """Distance to the reference at the trajectory's own times."""
    end = reference.times[-1]
    if trajectory.times[-1] > end + 1e-6:
        raise InputError(
            f"the trajectory ends at {trajectory.times[-1]:g} s, the reference at {end:g} s: shorten the run."
        )
    return distance(trajectory.positions, positions_at(reference, trajectory.times))


def interpolation_error(reference: Trajectory) -> Distance:
    """Error of the spline with every second sample left out, measured at those samples.

    This is the error at twice the sampling period, hence an upper bound in practice: a smooth
    motion would have a sixteenth of it at the full sampling.
    """
    halved = Trajectory(reference.times[::2], reference.positions[::2])
    return distance(reference.positions[1:-1:2], positions_at(halved, reference.times[1:-1:2]))


def from_data(scene: Scene) -> ReferenceSolution:
    """The independent trajectory that belongs to the scene."""
    trajectory = reference_trajectory(scene)
    source = scene.reference
    if source is None:
        raise InputError(f"scene '{scene.name}' has no reference; give the study one that is computed.")
    return ReferenceSolution(trajectory, source.source, source.uncertainty, source.file)


def self_convergence(finest: Trajectory, *coarser: Trajectory, source: str) -> ReferenceSolution:
    """The finest solution; what separates it from each coarser one is taken for its uncertainty.

    Args:
        finest: refined in space and time.
        coarser: each with a mesh or a step twice as coarse, at the same times.
        source: what was computed.
    """
    errors = [distance(finest.positions, other.positions).maximum for other in coarser]
    return ReferenceSolution(finest, source, float(np.sum(errors)))
