"""Links of an ObjectKinematicTree as records, and what acts on its joints as springs and linear forces."""

from collections.abc import Sequence
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...items.arguments import described
from ...multibody.connectors import CARTESIAN, CONNECTOR
from ...multibody.linear_forces import LINEAR_FORCE
from ...multibody.links import LINK
from .points import PointReader
from .unknown import UnknownItemError, require_no_functions

_KINDS = [getattr(exudyn.JointType, kind + axis) for kind in ("Revolute", "Prismatic") for axis in "XYZ"]
_CONTROL = ("jointPControlVector", "jointDControlVector")
_OFFSETS = ("jointForceVector", "jointPositionOffsetVector", "jointVelocityOffsetVector")
OF_JOINTS = {*_CONTROL, *_OFFSETS}
_ON_LINKS = ("linkForces", "linkTorques")  # Exudyn's forces on joints of them are not J^T f


def read_links(data: dict[str, Any], record: int, first: int, body: Any) -> Any:
    """(L,) records of the links of a tree, without their weights.

    Args:
        data: of the object.   record: number of the body's.
        first: number of the first of these records.   body: record of the tree.
    """
    size = len(data["linkMasses"])
    links = np.zeros(size, LINK)
    parents = np.array(data["linkParents"], dtype=int)
    links["body"], links["first"], links["width"] = record, body["first"], size
    links["own"], links["parent"] = np.arange(size), np.where(parents >= 0, first + parents, 0)
    links["slides"], links["axis"] = np.divmod([_KINDS.index(kind) for kind in data["jointTypes"]], 3)
    links["reference"] = body["reference"][:size]
    links["mass"] = data["linkMasses"]
    links["turn"] = _stacked(data["jointTransformations"], (size, 3, 3))
    links["inertia"] = _stacked(data["linkInertiasCOM"], (size, 3, 3))
    links["centre"] = _stacked(data["linkCOMs"], (size, 3))
    links["offset"] = _stacked(data["jointOffsets"], (size, 3))
    links["offset"] -= np.where(parents[:, np.newaxis] < 0, -data["baseOffset"], links["centre"][parents])
    return links


def weights(data: dict[str, Any]) -> Array:
    """(L, 3) of the links of a tree [N]."""
    return np.outer(data["linkMasses"], data["gravity"])


def read_control(mbs: Any, number: int, reader: PointReader) -> list[Any]:
    """Springs with dampers between the joints of a tree and the ground, see `set_control`.

    Raises:
        UnknownItemError: a user function takes part, or forces on links.
    """
    data = mbs.GetObject(number)
    name = described(data, number)
    require_no_functions(data, name)
    if any(_stacked(data[forces], ()).any() for forces in _ON_LINKS):
        raise UnknownItemError(f"{name} with forces or torques on links")
    ground, springs = reader.fixed(np.zeros(3), has_frame=False).point, []
    for k in range(len(data["linkMasses"])):
        spring = np.zeros(1, CONNECTOR)[0]
        spring["kind"], spring["place"], spring["factors"] = CARTESIAN, -1, 1.0
        spring["points"] = ground, reader.coordinate(int(data["nodeNumber"]), k).point
        springs.append(spring)
    return springs


def set_control(data: dict[str, Any], springs: Sequence[Any], body: Any) -> Any:
    """Give springs of joints their stiffness and damping.   body: record of the tree.

    Returns:
        (L,) linear forces: those at the joints, and what offsets of the control add.
    """
    size = len(springs)
    stiffness, damping, force, place, speed = (
        data[name] if len(data[name]) else np.zeros(size) for name in (*_CONTROL, *_OFFSETS)
    )
    for spring, k, d in zip(springs, stiffness, damping, strict=True):
        spring["stiffness"][0, 0], spring["damping"][0, 0] = k, d
    entries = np.zeros(size, LINEAR_FORCE)
    entries["row"] = entries["column"] = body["first"] + np.arange(size)
    entries["constant"] = force + stiffness * (place - body["reference"][:size]) + damping * speed
    return entries


def _stacked(parts: Any, shape: tuple[int, ...]) -> Array:
    """A list of Exudyn's, which cannot be looped over, as an array; zero if it is empty."""
    return np.array([parts[k] for k in range(len(parts))] or np.zeros(shape), dtype=float)
