"""Sensors of an mbs: what of the state they look at during a run, and which of them show nothing."""

import warnings
from collections.abc import Callable, Collection, Sequence
from functools import cached_property
from typing import Any

import exudyn

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
    _Type.Director1,
    _Type.Director2,
    _Type.Director3,
}
_OF_POINTS = {"Node", "Body", "Marker", "SuperElement"}
_OF_VELOCITIES = {_Type.Velocity, _Type.Coordinates_t, _Type.AngularVelocity}
_SECTION_FORCES = {_Type.ForceLocal, _Type.TorqueLocal}
_LAST_WRITTEN = "lastSolutionWritten", "lastSensorsWritten"  # Exudyn keeps the next times there
_CONSTRAINT_FORCES = {_Type.Force, _Type.ForceLocal}


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
    """

    def __init__(
        self, settings: Any, sensors: Sequence[Any], look: Look, look_of_items: Callable[[], Look]
    ) -> None:
        self._look, self._look_of_items = look, look_of_items
        are_sensed = max(map(_derivatives_of, sensors), default=POSITIONS) == ACCELERATIONS
        self._at_all = {Look.ANYTHING, Look.SENSORS} if are_sensed else {Look.ANYTHING}
        written = settings.solution.file.write, settings.solution.sensors.active and are_sensed
        self._written = [name for name, is_written in zip(_LAST_WRITTEN, written, strict=True) if is_written]

    @cached_property
    def items_look_at_forces(self) -> bool:
        """Whether functions of items may look at accelerations and forces, or change something."""
        return self._look_of_items() in self._at_all

    def include(self, time: float, step: float, solver: Any, asks_items: bool) -> bool:
        """Whether a step of the loop, of that length, may be one that ends at `time` [s].

        asks_items: whether functions of items are called in steps, which may look, too.
        """
        if self._look in self._at_all or (asks_items and self.items_look_at_forces):
            return True
        output = solver.output
        return any(time > getattr(output, name) - 0.5 * step for name in self._written)


def _derivatives_of(sensor: dict[str, Any]) -> int:
    if sensor["sensorType"] not in _OF_POINTS:
        return ACCELERATIONS  # whatever it may look at
    if sensor["outputVariableType"] in _OF_POSITIONS:
        return POSITIONS
    return VELOCITIES if sensor["outputVariableType"] in _OF_VELOCITIES else ACCELERATIONS


def warn_of_empty_sensors(mbs: Any, sensors: Sequence[Any], enforcing: Collection[int]) -> None:
    """Warn of sensors of section forces of companions, and of what keeps the length under native solvers.

    Args:
        mbs: the system.   sensors: data of all of its sensors.
        enforcing: constraints by which cables keep their length under native solvers.
    """
    for number, sensor in enumerate(sensors):
        why = _emptiness(mbs, sensor, enforcing)
        if why:
            warnings.warn(
                f"sensor {number} '{sensor['name']}' measures {sensor['outputVariableType']} of {why}: it is "
                "zero. Use CreateCableForceSensor for tension and bending moment.",
                stacklevel=3,
            )


def _emptiness(mbs: Any, sensor: dict[str, Any], enforcing: Collection[int]) -> str:
    kind, output = sensor["sensorType"], sensor.get("outputVariableType")
    if kind == "Body" and output in _SECTION_FORCES and is_inert_cable(mbs.GetObject(sensor["bodyNumber"])):
        return f"object {int(sensor['bodyNumber'])}, a companion without stiffness (CurvatureLocal works)"
    if kind == "Object" and output in _CONSTRAINT_FORCES and int(sensor["objectNumber"]) in enforcing:
        return (
            f"object {int(sensor['objectNumber'])}, which keeps the length of its cable under native solvers "
            "only"
        )
    return ""
