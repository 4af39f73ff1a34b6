"""Which parts of the state somebody looks at between the start and the end of a run."""

from collections.abc import Sequence
from typing import Any

import exudyn

from ..items.functions_that_look import may_look_at_forces

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


def observed_derivatives(settings: Any, sensors: Sequence[Any], functions: Sequence[Any] = ()) -> int:
    """How many of coordinates, velocities, accelerations are needed at each step, the first ones always.

    Args:
        settings: exudyn.SimulationSettings, whose solution file decides.
        sensors: data of all sensors, which decide, too.
        functions: of the user, called between steps; they may look at any sensor.
    """
    if any(map(may_look_at_forces, functions)):
        return ACCELERATIONS
    needed = POSITIONS
    if settings.solution.file.write:
        export = settings.solution.file.export
        needed = VELOCITIES if export.velocities else needed
        needed = ACCELERATIONS if export.accelerations else needed
    if settings.solution.sensors.active or functions:
        needed = max([needed, *map(_derivatives_of, sensors)])
    return needed


def _derivatives_of(sensor: dict[str, Any]) -> int:
    if sensor["sensorType"] not in _OF_POINTS:
        return ACCELERATIONS  # whatever it may look at
    if sensor["outputVariableType"] in _OF_POSITIONS:
        return POSITIONS
    return VELOCITIES if sensor["outputVariableType"] in _OF_VELOCITIES else ACCELERATIONS
