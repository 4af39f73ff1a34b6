"""Reference trajectories, see PROVENANCE.md, in the axes of the scene that they belong to."""

from importlib.resources import files

import numpy as np

from exudyn_inext.errors import InputError

from ..scenes import Scene
from ..trajectory import Array, Trajectory


def reference_trajectory(scene: Scene) -> Trajectory:
    """The independent trajectory of the scene's main point, good to scene.reference.uncertainty."""
    if scene.reference is None:
        raise InputError(f"scene '{scene.name}' has no reference; add one to its module.")
    with files(__package__).joinpath(scene.reference.file).open(encoding="utf-8") as table:
        header = table.readline().strip().split(",")
        values = np.loadtxt(table, delimiter=",", ndmin=2)
    columns = dict(zip(header, values.T, strict=True))
    positions = np.column_stack([_column(columns, axis) for axis in scene.reference.axes])
    return Trajectory(times=columns["t"], positions=positions)


def _column(columns: dict[str, Array], axis: str) -> Array:
    if axis == "0":
        return np.zeros_like(columns["t"])
    sign = -1.0 if axis.startswith("-") else 1.0
    return sign * columns[axis.removeprefix("-")]
