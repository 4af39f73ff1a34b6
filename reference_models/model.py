"""A scene as an assembled Exudyn model, whatever its formulation; and what its sensors stored."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import SensorNode

from exudyn_inext.errors import InputError
from exudyn_inext.exudyn_binding import console
from exudyn_inext.exudyn_binding.console import silence as silence

from .scenes import Scene
from .trajectory import Trajectory

SENSOR_PERIOD = 0.01
"""Time between two stored sensor values [s]."""


@dataclass(frozen=True, eq=False)
class Model:
    """An assembled model.

    container owns mbs and must outlive it.
    nodes: node numbers along the cable; the last one of a closed cable is the first one again.
    sensors: observed point -> sensor number.
    """

    scene: Scene
    container: Any
    mbs: Any
    nodes: tuple[int, ...]
    sensors: dict[str, int]


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
    elements = len(nodes) - 1
    return {
        name: int(
            mbs.AddSensor(
                SensorNode(
                    nodeNumber=nodes[node_index(fraction, elements)],
                    storeInternal=True,
                    outputVariableType=exudyn.OutputVariableType.Position,
                )
            )
        )
        for name, fraction in scene.observe.items()
    }


def quiet_settings(end_time: float, steps: int, period: float = SENSOR_PERIOD) -> Any:
    """exudyn.SimulationSettings: silent, no files, sensors every `period` [s]."""
    return console.quiet_settings(end_time, steps, period)


def sensor_trajectory(model: Model, point: str) -> Trajectory:
    """What the sensor of an observed point has stored."""
    stored = np.asarray(model.mbs.GetSensorStoredData(model.sensors[point]))
    return Trajectory(times=stored[:, 0].copy(), positions=stored[:, 1:4].copy())
