"""Markers that cannot work on an inextensible cable: mbs.Assemble() refuses them without saying which can."""

from typing import Any

from ...scene.model import CableItem
from ..cable_data import find_cable_item

_ON_OBJECT = {"ObjectODE2Coordinates"}
_ON_NODES = {"NodePosition", "NodeCoordinate", "NodeCoordinates"}
_IN_PLANE = {"NodeRigid"}
REMEDY = (
    "on a cable use MarkerOnCable(mbs, cable, arcLength), or Marker- and SensorBody items on the objects of "
    "CreateCompanionCables(mbs, cable); on its nodes MarkerNodePosition, MarkerNodeCoordinate, "
    "MarkerNodeCoordinates, and in the plane MarkerNodeRigid; for ends on bodies AttachToBody; for weight "
    "the argument gravity of CreateInextensibleCable, in place of MarkerBodyMass"
)


def unsuitable_markers(mbs: Any) -> list[str]:
    """Descriptions of all markers that cannot work on the cables of mbs, which need not be assembled."""
    cables = _cables(mbs)
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


def _cables(mbs: Any) -> dict[int, CableItem]:
    items = {k: find_cable_item(mbs.GetObject(k)) for k in range(mbs.systemData.NumberOfObjects())}
    return {number: item for number, item in items.items() if item is not None}
