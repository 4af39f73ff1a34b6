"""Sensors of an mbs: what of the state they look at during a run, and which of them show nothing."""

import math
import warnings
from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from functools import cached_property
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..items.attach.inert import is_inert_cable
from ..items.functions_that_look import Look

POSITIONS, VELOCITIES, ACCELERATIONS = 1, 2, 3

_Type = exudyn.OutputVariableType
_OF_POSITIONS = {
    _Type.Position,
    _Type.Displacement,
    _Type.Coordinates,
    _Type.CoordinatesTotal,
    _Type.Rotation,
    _Type.RotationMatrix,
    _Type.Director1,
    _Type.Director2,
    _Type.Director3,
}
_OF_POINTS = {"Node", "Body", "Marker", "SuperElement"}
_OF_VELOCITIES = {
    _Type.Velocity,
    _Type.VelocityLocal,
    _Type.Coordinates_t,
    _Type.AngularVelocity,
    _Type.AngularVelocityLocal,
}
_FORCE_SENSOR = "CreateCableForceSensor for tension and bending moment"
_ENERGY_SENSOR = "CreateCableEnergySensor for both energies of the cable"
WITHOUT_COMPANIONS = {  # outputs that are zero there, and what measures them
    _Type.ForceLocal: _FORCE_SENSOR,
    _Type.TorqueLocal: _FORCE_SENSOR,
    _Type.KineticEnergy: _ENERGY_SENSOR,
    _Type.PotentialEnergy: _ENERGY_SENSOR,
}
_LAST_WRITTEN = "lastSolutionWritten", "lastSensorsWritten"  # Exudyn keeps the next times there
_CONSTRAINT_FORCES = {_Type.Force, _Type.ForceLocal}
_ROUND_OFF = 1e-10  # by which Exudyn writes too early [s]


def observed_derivatives(settings: Any, sensors: Sequence[Any], look: Look = Look.NOTHING) -> int:
    """How many of coordinates, velocities, accelerations are needed at each step, the first ones always.

    Args:
        settings: exudyn.SimulationSettings, whose solution file decides.
        sensors: data of all sensors, which decide, too.
        look: of functions of the user that are called between steps.
    """
    if look == Look.ANYTHING:
        return ACCELERATIONS
    needed = POSITIONS
    if settings.solution.file.write:
        export = settings.solution.file.export
        needed = VELOCITIES if export.velocities else needed
        needed = ACCELERATIONS if export.accelerations else needed
    if settings.solution.sensors.active or look >= Look.SENSORS:
        needed = max([needed, *map(_derivatives_of, sensors)])
    return needed


class OutputTimes:
    """When somebody looks at accelerations and forces, who does not look at each step: files and sensors.

    Args:
        settings, sensors, look: see `observed_derivatives`.
        look_of_items: gives what functions look at that items call, if it is asked for.
        solver: of Exudyn, that writes.
    """

    def __init__(
        self,
        settings: Any,
        sensors: Sequence[Any],
        look: Look,
        look_of_items: Callable[[], Look],
        solver: Any,
    ) -> None:
        self._look, self._look_of_items, self._solver = look, look_of_items, solver
        are_sensed = max(map(_derivatives_of, sensors), default=POSITIONS) == ACCELERATIONS
        self._at_all = {Look.ANYTHING, Look.SENSORS} if are_sensed else {Look.ANYTHING}
        solution = settings.solution
        to_file = solution.file.write, solution.file.writePeriod
        by_sensors = solution.sensors.active and are_sensed, solution.sensors.writePeriod
        periods = zip(_LAST_WRITTEN, (to_file, by_sensors), strict=True)
        self._written = {name: period for name, (is_written, period) in periods if is_written}

    @cached_property
    def items_look_at_forces(self) -> bool:
        """Whether functions of items may look at accelerations and forces, or change something."""
        return self._look_of_items() in self._at_all

    def due(self, asks_items: bool, answers: bool) -> float:
        """When that is again [s]: in the step that ends next to it.

        Args:
            asks_items: whether functions of items are called in steps, which may look, too.
            answers: whether sensors show them whenever they are asked for between steps.
        """
        sees_each_step = self._look == Look.ANYTHING or (self._look in self._at_all and not answers)
        if sees_each_step or (asks_items and self.items_look_at_forces):
            return -math.inf
        return min((getattr(self._solver.output, name) for name in self._written), default=math.inf)

    def among(self, times: Array) -> Array:
        """(k,) whether files are written, or may be, after the next steps, which end at these times [s].

        As Exudyn decides on it, see WriteSolutionToFile in its CSolverBase.cpp.
        """
        result = np.zeros(len(times), bool)
        for name, period in self._written.items():
            due = getattr(self._solver.output, name)
            for k, time in enumerate(times.tolist()):
                result[k] |= time > due - 2.0 * _ROUND_OFF
                if time > due - 0.5 * _ROUND_OFF:
                    due = max(due + period, time)
        return result


def sensors_of_forces(sensors: Sequence[Any], supports: Collection[int]) -> dict[int, bool]:
    """Numbers of those that look at accelerations or forces, or may; whether at forces of supports.

    sensors: data of all of them.   supports: numbers of supports and links of cables.
    """
    numbers = (k for k, one in enumerate(sensors) if _derivatives_of(one) == ACCELERATIONS)
    return {k: _may_look_at(sensors[k], supports) for k in numbers}


def _may_look_at(sensor: dict[str, Any], supports: Collection[int]) -> bool:
    """Whether a sensor may look at multipliers of these constraints."""
    if sensor["sensorType"] == "Object":
        return int(sensor["objectNumber"]) in supports
    is_of_cable = hasattr(sensor.get("sensorUserFunction", {}).get("function"), "keeper")
    return not (is_of_cable or sensor["sensorType"] in _OF_POINTS)


def _derivatives_of(sensor: dict[str, Any]) -> int:
    if sensor["sensorType"] not in _OF_POINTS:
        return ACCELERATIONS  # whatever it may look at
    if sensor["outputVariableType"] in _OF_POSITIONS:
        return POSITIONS
    return VELOCITIES if sensor["outputVariableType"] in _OF_VELOCITIES else ACCELERATIONS


def warn_of_empty_sensors(mbs: Any, sensors: Sequence[Any], enforcing: Collection[int]) -> None:
    """Warn of sensors of forces and energies that companions, and what keeps lengths natively, lack.

    One warning for each output, of its first sensor.

    Args:
        mbs: the system.   sensors: data of all of its sensors.
        enforcing: constraints by which cables keep their length under native solvers.
    """
    empty = defaultdict(list)
    for number, sensor in enumerate(sensors):
        if why := _emptiness(mbs, sensor, enforcing):
            output = sensor["outputVariableType"]
            empty[output].append(f"sensor {number} '{sensor['name']}' measures {output} of {why}: it is zero")
    for output, (first, *others) in empty.items():
        more = f", as are {len(others)} other sensors" if others else ""
        instead = WITHOUT_COMPANIONS.get(output, _FORCE_SENSOR)
        warnings.warn(f"{first}{more}. Use {instead}.", stacklevel=3)


def _emptiness(mbs: Any, sensor: dict[str, Any], enforcing: Collection[int]) -> str:
    kind, output = sensor["sensorType"], sensor.get("outputVariableType")
    if (
        kind == "Body"
        and output in WITHOUT_COMPANIONS
        and is_inert_cable(mbs.GetObject(sensor["bodyNumber"]))
    ):
        return f"object {int(sensor['bodyNumber'])}, a companion without mass and stiffness"
    if kind == "Object" and output in _CONSTRAINT_FORCES and int(sensor["objectNumber"]) in enforcing:
        return (
            f"object {int(sensor['objectNumber'])}, which keeps the length of its cable under native solvers "
            "only"
        )
    return ""
