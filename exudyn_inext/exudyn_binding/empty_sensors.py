"""Sensors that show zero where the user expects a force: named before a run, not found after it."""

import warnings
from collections.abc import Collection, Sequence
from typing import Any

import exudyn

from ..items.attach.inert import is_inert_cable

_Type = exudyn.OutputVariableType
_SECTION_FORCES = {_Type.ForceLocal, _Type.TorqueLocal}
_CONSTRAINT_FORCES = {_Type.Force, _Type.ForceLocal}


def warn_of_empty_sensors(mbs: Any, sensors: Sequence[Any], own_constraints: Collection[int]) -> None:
    """Warn of sensors of section forces of companions, and of forces in supports and links of cables.

    Args:
        mbs: the system.   sensors: data of all of its sensors.
        own_constraints: objects that belong to the solve of a cable.
    """
    for number, sensor in enumerate(sensors):
        why = _emptiness(mbs, sensor, own_constraints)
        if why:
            warnings.warn(
                f"sensor {number} '{sensor['name']}' measures {sensor['outputVariableType']} of {why}: it is "
                "zero. Use CreateCableForceSensor for tension and bending moment.",
                stacklevel=3,
            )


def _emptiness(mbs: Any, sensor: dict[str, Any], own_constraints: Collection[int]) -> str:
    kind, output = sensor["sensorType"], sensor.get("outputVariableType")
    if kind == "Body" and output in _SECTION_FORCES and is_inert_cable(mbs.GetObject(sensor["bodyNumber"])):
        return f"object {int(sensor['bodyNumber'])}, a companion without stiffness (CurvatureLocal works)"
    if kind == "Object" and output in _CONSTRAINT_FORCES and int(sensor["objectNumber"]) in own_constraints:
        return (
            f"object {int(sensor['objectNumber'])}, a support or link that belongs to the solve of its "
            "cable, which does not hand its force to Exudyn"
        )
    return ""
