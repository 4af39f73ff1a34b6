"""Sensors that show zero where the user expects a force: named before a run, not found after it."""

import warnings
from collections.abc import Collection, Sequence
from typing import Any

import exudyn

from ..items.attach.inert import is_inert_cable

_Type = exudyn.OutputVariableType
_SECTION_FORCES = {_Type.ForceLocal, _Type.TorqueLocal}
_CONSTRAINT_FORCES = {_Type.Force, _Type.ForceLocal}


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
