"""GeneralContact that never acts: spheres that rest, apart from each other, and nothing else."""

from collections.abc import Set
from itertools import combinations
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array


def any_acts(mbs: Any, moved: Set[int]) -> bool:
    """Whether one of its general contacts may act in a run.

    mbs: assembled.   moved: constraints that are, between steps.
    """
    contacts = (mbs.GetGeneralContact(k) for k in range(mbs.NumberOfGeneralContacts()))
    return any(_may_act(mbs, contact, moved) for contact in contacts)


def _may_act(mbs: Any, contact: Any, moved: Set[int]) -> bool:
    if not contact.isActive:
        return False
    contents = contact.GetPythonObject()
    if contents["numberOfANCFCable2D"] or contents["numberOfTrigsRigidBodyBased"]:
        return True
    number = contents["numberOfSpheresMarkerBased"]
    if number < 2 or not contact.sphereSphereContact:
        return False
    spheres = [contact.GetSphereMarkerBased(k, addData=True) for k in range(number)]
    if not all(_rests(mbs, int(sphere["markerIndex"]), moved) for sphere in spheres):
        return True
    places = [_place(mbs, int(sphere["markerIndex"])) for sphere in spheres]
    gaps = (
        float(np.linalg.norm(places[i] - places[j])) - spheres[i]["radius"] - spheres[j]["radius"]
        for i, j in combinations(range(number), 2)
    )
    return min(gaps) <= 0.0


def _place(mbs: Any, marker: int) -> Array:
    """(3,) of a marker, at present [m]."""
    return np.array(mbs.GetMarkerOutput(marker, exudyn.OutputVariableType.Position))


def _rests(mbs: Any, marker: int, moved: Set[int]) -> bool:
    """Whether constraints with the ground hold the place of a planar node, which a marker has."""
    data = mbs.GetMarker(marker)
    if data["markerType"] not in ("NodeRigid", "NodePosition"):
        return False
    node = int(data["nodeNumber"])
    if mbs.GetNode(node)["nodeType"] not in ("RigidBody2D", "Point2D"):
        return False
    numbers = set(range(mbs.systemData.NumberOfObjects())) - moved
    return {0, 1} <= {_held_coordinate(mbs, number, node) for number in numbers}


def _held_coordinate(mbs: Any, number: int, node: int) -> int | None:
    """Which coordinate of a node an object holds, if it is a constraint that does so."""
    data = mbs.GetObject(number)
    if data["objectType"] != "ConnectorCoordinate" or not data["activeConnector"] or data["velocityLevel"]:
        return None
    if isinstance(data["offsetUserFunction"], dict):
        return None
    ground, other = (mbs.GetMarker(one) for one in data["markerNumbers"])
    are_coordinates = ground["markerType"] == other["markerType"] == "NodeCoordinate"
    if not are_coordinates or "Ground" not in str(mbs.GetNode(ground["nodeNumber"])["nodeType"]):
        return None
    is_held = int(other["nodeNumber"]) == node and data["factor1"] != 0.0
    return int(other["coordinate"]) if is_held else None
