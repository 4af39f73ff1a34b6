"""Every ObjectKinematicTree: its links, and what acts on its joints and links, as records."""

from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...items.arguments import described
from ...multibody.connectors import CARTESIAN, CONNECTOR
from ...multibody.loads import LOAD, NONE
from ...multibody.trees import LINK
from .points import PointReader
from .unknown import UnknownItemError, require_no_functions

_KINDS = [getattr(exudyn.JointType, kind + axis) for kind in ("Revolute", "Prismatic") for axis in "XYZ"]
_ON_JOINTS = (
    "jointPControlVector",
    "jointDControlVector",
    "jointForceVector",
    "jointPositionOffsetVector",
    "jointVelocityOffsetVector",
)
ON_LINKS = {"linkForces", "linkTorques"}  # what Exudyn makes of them is not J^T f
ACTING = {*_ON_JOINTS, "gravity"}  # parameters that may change


def read_links(mbs: Any, trees: dict[int, int], bodies: Any) -> Any:
    """(L,) records of the ground and the links of all trees; none if there are no trees.

    Args:
        mbs: assembled.   trees: numbers of their records, by those of the objects.   bodies: records.
    """
    links = np.zeros(1 if trees else 0, LINK)
    links["orientation"], links["body"] = np.eye(3), -1
    for number, record in trees.items():
        links = np.append(links, _links(mbs.GetObject(number), record, len(links), bodies[record]))
    return links


def _links(data: dict[str, Any], record: int, first: int, body: Any) -> Any:
    """Those of one tree.   record: number of the body's.   first: number of the first of these records."""
    size = len(data["linkMasses"])
    links = np.zeros(size, LINK)
    parents = np.array(data["linkParents"], dtype=int)
    links["body"], links["first"], links["width"] = record, body["first"], size
    links["own"], links["parent"] = np.arange(size), np.where(parents >= 0, first + parents, 0)
    links["slides"], links["axis"] = np.divmod([_KINDS.index(kind) for kind in data["jointTypes"]], 3)
    links["reference"], links["mass"] = body["reference"][:size], data["linkMasses"]
    links["turn"], links["inertia"] = (
        _stacked(data["jointTransformations"]),
        _stacked(data["linkInertiasCOM"]),
    )
    links["centre"], links["offset"] = _stacked(data["linkCOMs"]), _stacked(data["jointOffsets"])
    links["offset"] -= np.where(parents[:, np.newaxis] < 0, -data["baseOffset"], links["centre"][parents])
    return links


class ActingOnTree:
    """What acts on a tree: springs with dampers between its joints and the ground, and loads.

    Args:
        mbs: assembled.   number: of the object.   body: record of it.   reader: of points.

    springs: (L,) records.   loads: (2 L,) records, those on joints first, then weights.

    Raises:
        UnknownItemError: a user function takes part, or forces on links.
    """

    def __init__(self, mbs: Any, number: int, body: Any, reader: PointReader) -> None:
        self._mbs, self._number = mbs, number
        data = mbs.GetObject(number)
        name, size = described(data, number), len(data["linkMasses"])
        require_no_functions(data, name)
        if any(_stacked(data[forces]).any() for forces in ON_LINKS):
            raise UnknownItemError(f"{name} with forces or torques on links")
        self._reference, self._masses = body["reference"][:size].copy(), np.asarray(data["linkMasses"])
        self._given = {name: data[name] for name in ACTING}
        joints = [reader.coordinate(int(data["nodeNumber"]), k).point for k in range(size)]
        centres = [reader.centre_of_link(number, k).point for k in range(size)]
        ground = reader.fixed(np.zeros(3), has_frame=False).point
        self.springs, self.loads = np.zeros(size, CONNECTOR), np.zeros(2 * size, LOAD)
        self.springs["directions"][:, :6] = np.eye(6)
        self.springs["kind"], self.springs["place"], self.springs["factors"] = CARTESIAN, -1, 1.0
        self.springs["points"][:, 0], self.springs["points"][:, 1] = ground, joints
        self.loads["function"], self.loads["point"] = NONE, [*joints, *centres]
        self._set(self.springs, self.loads)

    def read_again(self, parameter: str, springs: Any, loads: Any) -> None:
        """Give these records a parameter, one of ACTING, as it is now."""
        self._given[parameter] = self._mbs.GetObjectParameter(self._number, parameter)
        self._set(springs, loads)

    def _set(self, springs: Any, loads: Any) -> None:
        given, size = self._given, len(springs)
        stiffness, damping, force, place, speed = (
            given[name] if len(given[name]) else np.zeros(size) for name in _ON_JOINTS
        )
        springs["stiffness"][:, 0, 0], springs["damping"][:, 0, 0] = stiffness, damping
        constant = loads["constant"]
        constant[:size, 0] = force + stiffness * (place - self._reference) + damping * speed
        constant[size:] = self._masses[:, np.newaxis] * given["gravity"]


def _stacked(parts: Any) -> Array:
    """A list of Exudyn's, which cannot be looped over, as an array."""
    return np.array([parts[k] for k in range(len(parts))], dtype=float)
