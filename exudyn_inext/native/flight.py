"""Whether something acts between a scene and its surroundings, so that it does not fly along by itself."""

from typing import Any

from ..items.cable_data import find_cable_item
from ..items.functions_of_time import step_functions
from ..items.on_ground import markers_of, point_on_ground

_NODES = {
    *("PointGround", "GenericData", "Point", "Point2D", "PointSlope1", "Point2DSlope1"),
    *("RigidBodyEP", "RigidBodyRxyz", "RigidBodyRotVecLG", "RigidBody2D"),
}
_BODIES = {"Ground", "MassPoint", "MassPoint2D", "RigidBody", "RigidBody2D", "ANCFCable", "ANCFCable2D"}
_SPRINGS = {f"Connector{kind}SpringDamper" for kind in ("", "Cartesian", "RigidBody", "Linear", "Torsional")}
_JOINTS = {
    *("ConnectorDistance", "JointGeneric", "JointSpherical", "JointRevoluteZ", "JointPrismaticX"),
    *("JointRevolute2D", "JointPrismatic2D"),
}
_MARKERS = {"BodyPosition", "BodyRigid", "NodePosition", "NodeRigid"}


def may_fly(mbs: Any) -> bool:
    """Whether only gravity, constant loads, and springs and joints among its own parts act on a scene.

    Contact, functions, coordinates without a place in space, and items of other kinds: it may not.
    """
    data = mbs.systemData
    nodes = (mbs.GetNode(k)["nodeType"] for k in range(data.NumberOfNodes()))
    objects = (mbs.GetObject(k) for k in range(data.NumberOfObjects()))
    loads = (mbs.GetLoad(k) for k in range(data.NumberOfLoads()))
    if mbs.NumberOfGeneralContacts() or step_functions(mbs) or not all(_flies(mbs, one) for one in objects):
        return False
    return _NODES.issuperset(nodes) and not any(map(_has_function, loads))


def _flies(mbs: Any, item: dict[str, Any]) -> bool:
    """Whether an object acts, if at all, among moving bodies and nodes alone."""
    kind = item["objectType"]
    if kind in _BODIES or find_cable_item(item):
        return True
    markers = markers_of(mbs, item) if kind in _SPRINGS | _JOINTS and not _has_function(item) else []
    moving = (one["markerType"] in _MARKERS and point_on_ground(mbs, one) is None for one in markers)
    return bool(markers) and all(moving)


def _has_function(item: dict[str, Any]) -> bool:
    """Whether a function of the user does something, besides drawing."""
    return any(value and key[0] != "V" for key, value in item.items() if key.endswith("UserFunction"))
