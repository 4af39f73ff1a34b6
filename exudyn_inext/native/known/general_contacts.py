"""GeneralContact as records: planar cables with circles, and spheres that never meet."""

from collections.abc import Callable, Sequence, Set
from itertools import combinations
from typing import Any

import exudyn
import numpy as np

from ...arrays import collected
from ...element.shape_functions import shape_functions
from ...items.functions_that_look import Look, look_of_step_functions
from ...items.on_ground import point_on_ground
from ...multibody.general_contacts import ELEMENT, PAIR, GeneralContacts, general_contacts
from .belts import Touching, elements_of
from .points import PointReader
from .unknown import UnknownItemError


def read_general_contacts(
    mbs: Any, reader: PointReader, moved: Set[int], evaluate: Callable[[], None]
) -> GeneralContacts | None:
    """What may act in a run; None: nothing does.

    Args:
        mbs: assembled.   reader: of markers.   moved: constraints that are, between steps.
        evaluate: see `belts.elements_of`.

    Raises:
        UnknownItemError: it has no compiled form.
    """
    if mbs.NumberOfGeneralContacts() > 1:  # GetGeneralContact returns the last one, whichever is asked for
        raise UnknownItemError("more than one GeneralContact: Exudyn shows the last one only")
    contact = mbs.GetGeneralContact(0) if mbs.NumberOfGeneralContacts() else None
    if contact is None or not contact.isActive:
        return None
    sizes = contact.GetPythonObject()
    if sizes["numberOfTrigsRigidBodyBased"]:
        raise UnknownItemError("GeneralContact with triangles")
    if spheres_may_meet(mbs, contact, moved):
        raise UnknownItemError("GeneralContact, whose spheres may meet")
    if not (sizes["numberOfANCFCable2D"] and sizes["numberOfSpheresMarkerBased"]):
        return None
    for name in ("ancfCableUseExactMethod", "keepContactWhilePenetrating"):
        if getattr(contact, name, False):
            raise UnknownItemError(f"GeneralContact with {name} = True")
    if look_of_step_functions(mbs) == Look.ANYTHING:  # or call anything of the contact
        raise UnknownItemError("GeneralContact, which a pre- or post-step user function may change")
    return _records(mbs, contact, elements_of(mbs, contact, evaluate), reader)


def _records(mbs: Any, contact: Any, cables: Sequence[Touching], reader: PointReader) -> GeneralContacts:
    """Of these elements, each with all spheres."""
    known, segments = contact.GetPythonObject(), int(contact.ancfCableNumberOfContactSegments)
    friction, zone = known["frictionPairings"], float(contact.frictionProportionalZone)
    number = known["numberOfSpheresMarkerBased"]
    spheres = [contact.GetSphereMarkerBased(k, addData=True) for k in range(number)]
    pairs, elements, weights = [], collected(ELEMENT, [np.zeros(1, ELEMENT)[0]] * len(cables)), []
    for k, (one, record) in enumerate(zip(cables, elements, strict=True)):
        record.nodes[:] = reader.nodes_of_element(one.number)
        record.segments, record.first = segments, k * (segments + 1)
        record.pairs[:] = k * number, (k + 1) * number
        record.length = length = float(mbs.GetObject(one.number)["length"])
        weights.append(shape_functions(np.linspace(0.0, 1.0, segments + 1), length).T)
        for sphere in spheres:
            pair = _pair(one, sphere, friction[one.material, sphere["frictionMaterialIndex"]], zone, reader)
            pair.nodes[:] = record.nodes
            pairs.append(pair)
    return general_contacts(collected(PAIR, pairs), elements, np.concatenate(weights))


def _pair(one: Touching, sphere: dict[str, Any], friction: float, zone: float, reader: PointReader) -> Any:
    """An element and a sphere, but for the element's nodes."""
    place, record = reader.marker(int(sphere["markerIndex"])), np.zeros(1, PAIR)[0]
    if friction and not place.has_frame:
        raise UnknownItemError("GeneralContact with friction on a marker without a frame")
    stiffness = float(sphere["contactStiffness"])
    record.circle, record.radius = place.point, sphere["radius"]
    record.reach = record.radius + one.height
    record.stiffness = one.stiffness * stiffness / (one.stiffness + stiffness)
    record.damping = one.damping + sphere["contactDamping"]
    record.zone, record.viscosity = zone, friction / zone if friction else 0.0
    return record


def spheres_may_meet(mbs: Any, contact: Any, moved: Set[int]) -> bool:
    """Whether two spheres of a contact may touch in a run.

    Coordinates that constraints with the ground hold, of both, keep them apart, or nothing does.

    mbs: assembled.   moved: constraints that are, between steps.
    """
    number = contact.GetPythonObject()["numberOfSpheresMarkerBased"]
    if number < 2 or not contact.sphereSphereContact:
        return False
    spheres = [contact.GetSphereMarkerBased(k, addData=True) for k in range(number)]
    markers = [int(sphere["markerIndex"]) for sphere in spheres]
    kind = exudyn.OutputVariableType.Position
    places = [np.array(mbs.GetMarkerOutput(marker, kind)) for marker in markers]
    numbers = set(range(mbs.systemData.NumberOfObjects())) - moved
    objects = (mbs.GetObject(number) for number in numbers)
    connectors = [data for data in objects if data.get("activeConnector")]
    held = [_held_coordinates(mbs, marker, connectors) for marker in markers]
    for i, j in combinations(range(number), 2):
        both = sorted(held[i] & held[j])
        distance = float(np.linalg.norm((places[i] - places[j])[both]))
        if distance <= spheres[i]["radius"] + spheres[j]["radius"]:
            return True
    return False


def _held_coordinates(mbs: Any, marker: int, connectors: Sequence[dict[str, Any]]) -> set[int]:
    """Which ones of the place of a planar node, that a marker has, constraints with the ground hold."""
    data = mbs.GetMarker(marker)
    if data["markerType"] not in ("NodeRigid", "NodePosition"):
        return set()
    node = int(data["nodeNumber"])
    if mbs.GetNode(node)["nodeType"] not in ("RigidBody2D", "Point2D"):
        return set()
    return set().union(*(_held_by(mbs, data, node) for data in connectors))


def _held_by(mbs: Any, data: dict[str, Any], node: int) -> set[int]:
    """Which coordinates of a node a connector holds, if it is a constraint that does so."""
    if data["objectType"] == "JointRevolute2D":
        ground, other = (mbs.GetMarker(one) for one in data["markerNumbers"])
        is_held = point_on_ground(mbs, ground) is not None and int(other.get("nodeNumber", -1)) == node
        return {0, 1} if is_held else set()
    if data["objectType"] != "ConnectorCoordinate" or data["velocityLevel"]:
        return set()
    ground, other = (mbs.GetMarker(one) for one in data["markerNumbers"])
    are_coordinates = ground["markerType"] == other["markerType"] == "NodeCoordinate"
    is_driven = isinstance(data["offsetUserFunction"], dict)
    if is_driven or not are_coordinates or point_on_ground(mbs, ground) is None:
        return set()
    is_held = int(other["nodeNumber"]) == node and data["factor1"] != 0.0
    return {int(other["coordinate"])} if is_held else set()
