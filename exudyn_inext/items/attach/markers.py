"""Markers and sensors that cannot work on an inextensible cable, and what takes their place.

mbs.Assemble() refuses them without saying which can: where it does, these words are added to its message.
"""

import re
from functools import wraps
from typing import Any

import exudyn

from ...scene.model import CableItem
from ..cable_data import find_cable_item

_ON_OBJECT = {"ObjectODE2Coordinates"}
_ON_NODES = {"NodePosition", "NodeCoordinate", "NodeCoordinates"}
_IN_PLANE = {"NodeRigid"}
_SENSORS = {"Body", "Object"}
REMEDY = (
    "on a cable use AddMarkerOnCable(mbs, cable, arcLength), with SensorMarker for outputs, or Marker- and "
    "SensorBody items on the objects of CreateCompanionCables(mbs, cable); on its nodes MarkerNodePosition, "
    "MarkerNodeCoordinate, MarkerNodeCoordinates, and in the plane MarkerNodeRigid; for ends on bodies "
    "AttachToBody; for weight the argument gravity of CreateInextensibleCable, in place of MarkerBodyMass"
)


def unsuitable_items(mbs: Any) -> list[str]:
    """Descriptions of markers and sensors that cannot work on cables of mbs, which need not be assembled."""
    cables = _cables(mbs)
    return [*_unsuitable_markers(mbs, cables), *_unsuitable_sensors(mbs, cables)] if cables else []


def _unsuitable_markers(mbs: Any, cables: dict[int, CableItem]) -> list[str]:
    dimensions = {node: item.cable.dimension for item in cables.values() for node in item.nodes}
    found = []
    for number in range(mbs.systemData.NumberOfMarkers()):
        marker = mbs.GetMarker(number)
        kind = marker["markerType"]
        name = f"marker {number} '{marker['name']}' (Marker{kind})"
        body = marker.get("bodyNumber", marker.get("objectNumber"))
        if body is not None and int(body) in cables and kind not in _ON_OBJECT:
            found.append(f"{name} on the cable's object {int(body)}")
        dimension = dimensions.get(int(marker.get("nodeNumber", -1)))
        if dimension and kind not in (_ON_NODES | _IN_PLANE if dimension == 2 else _ON_NODES):
            found.append(f"{name} on the cable's {dimension}D node {int(marker['nodeNumber'])}")
    return found


def _unsuitable_sensors(mbs: Any, cables: dict[int, CableItem]) -> list[str]:
    found = []
    for number in range(mbs.systemData.NumberOfSensors()):
        sensor = mbs.GetSensor(number)
        body = int(sensor.get("bodyNumber", sensor.get("objectNumber", -1)))
        if sensor["sensorType"] in _SENSORS and body in cables:
            kind = f"Sensor{sensor['sensorType']}"
            found.append(f"sensor {number} '{sensor['name']}' ({kind}) on the cable's object {body}")
    return found


def _cables(mbs: Any) -> dict[int, CableItem]:
    items = {k: find_cable_item(mbs.GetObject(k)) for k in range(mbs.systemData.NumberOfObjects())}
    return {number: item for number, item in items.items() if item is not None}


def _explained(assemble: Any) -> Any:
    """The method of mbs, which says in its errors what takes the place of what it refuses."""

    @wraps(assemble)
    def call(mbs: Any) -> None:
        try:
            assemble(mbs)
        except exudyn.ModelError as error:
            found = unsuitable_items(mbs)
            if not found:
                raise
            said = re.sub(r" *\[Python file .*\]$", "", str(error))  # which names this one
            raise exudyn.ModelError(f"{said}\n{'; '.join(found)}: {REMEDY}.") from None

    return call


setattr(exudyn.MainSystem, "Assemble", _explained(exudyn.MainSystem.Assemble))  # noqa: B010
