"""What the errors of a study are measured against."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exudyn_inext.errors import InputError
from reference_models.data import reference_trajectory
from reference_models.scenes import Scene
from reference_models.trajectory import Trajectory

from .error import distance


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


ReferenceOf = Callable[[Scene], ReferenceSolution]
