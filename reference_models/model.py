"""A scene as an assembled Exudyn model, whatever its formulation; and what its sensors stored."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import SensorNode

from exudyn_inext.errors import InputError
from exudyn_inext.exudyn_binding import quiet
from exudyn_inext.exudyn_binding.quiet import silence as silence

from .scenes import Scene
from .trajectory import Array, Trajectory

SENSOR_PERIOD = 0.01
"""Time between two stored sensor values [s]."""


@dataclass(frozen=True, eq=False)
class Model:
    """An assembled model.

    container owns mbs and must outlive it.
    nodes: node numbers along the cable; the last one of a closed cable is the first one again.
    sensors: observed point -> sensor number.   slope_sensors: the same for observed slopes.
    """

    scene: Scene
    container: Any
    mbs: Any
    nodes: tuple[int, ...]
    sensors: dict[str, int]
    slope_sensors: dict[str, int] = field(default_factory=dict)


def require_elements(elements: int) -> None:
    if isinstance(elements, bool) or not isinstance(elements, int) or elements < 1:
        raise InputError(f"elements = {elements!r}: must be an integer >= 1.")


def node_index(fraction: float, elements: int) -> int:
    """Index of the node at that fraction of the arc length; equal elements."""
    index = round(fraction * elements)
    if abs(index - fraction * elements) > 1e-9:
        raise InputError(
            f"arc length fraction {fraction!r} is no node of {elements} equal elements; "
            f"use a number of elements n for which {fraction!r} * n is an integer."
        )
    return index


def add_position_sensors(mbs: Any, scene: Scene, nodes: Sequence[int]) -> dict[str, int]:
    """Observed point -> sensor number; equal elements between the nodes."""
    return _add_sensors(mbs, scene.observe, nodes, exudyn.OutputVariableType.Position)


def add_slope_sensors(mbs: Any, scene: Scene, nodes: Sequence[int]) -> dict[str, int]:
    """Observed slope -> sensor number; equal elements between the nodes. See sensor_slopes."""
    return _add_sensors(mbs, scene.observe_slopes, nodes, exudyn.OutputVariableType.Coordinates)


def _add_sensors(mbs: Any, points: Mapping[str, float], nodes: Sequence[int], output: Any) -> dict[str, int]:
    elements = len(nodes) - 1
    return {
        name: int(
            mbs.AddSensor(
                SensorNode(
                    nodeNumber=nodes[node_index(fraction, elements)],
                    storeInternal=True,
                    outputVariableType=output,
                )
            )
        )
        for name, fraction in points.items()
    }


def quiet_settings(end_time: float, steps: int, period: float = SENSOR_PERIOD) -> Any:
    """exudyn.SimulationSettings: silent, no files, sensors every `period` [s]."""
    return quiet.quiet_settings(end_time, steps, period)


def sensor_trajectory(model: Model, point: str) -> Trajectory:
    """What the sensor of an observed point has stored."""
    stored = np.asarray(model.mbs.GetSensorStoredData(model.sensors[point]))
    return Trajectory(times=stored[:, 0].copy(), positions=stored[:, 1:4].copy())


def sensor_slopes(model: Model, point: str) -> tuple[Array, Array]:
    """What the sensor of an observed slope has stored: times (n,) [s], slopes r_x (n, 3) [-].

    Exudyn stores coordinates without their reference values, positions first, then slopes.
    """
    sensor = model.slope_sensors[point]
    stored = np.asarray(model.mbs.GetSensorStoredData(sensor))
    node = model.mbs.GetSensor(sensor)["nodeNumber"]
    coordinates = stored[:, 1:] + model.mbs.GetNodeParameter(node, "referenceCoordinates")
    dimension = coordinates.shape[1] // 2
    slopes = np.zeros((len(stored), 3))
    slopes[:, :dimension] = coordinates[:, dimension:]
    return stored[:, 0].copy(), slopes
