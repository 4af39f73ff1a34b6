"""Where a point of a body is before a run, and how directions fixed to the body follow its coordinates."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
from exudyn.rigidBodyUtilities import (
    EulerParameters2GLocal,
    EulerParameters2RotationMatrix,
    RotationMatrixZ,
    RotXYZ2GLocal,
    RotXYZ2RotationMatrix,
)

from ...arrays import Array
from ...errors import InputError
from ..arguments import object_number

Pose = tuple[Array, Array, Array]
"""Origin (3,) [m], rotation A (3, 3) from the body's to the global frame, and G (3, n): the angular velocity
in the body's frame is G q_t."""


@dataclass(frozen=True, eq=False)
class BodyFrame:
    """A body in its initial configuration.

    number: of the object.   name: for messages.
    node: number of its node, or None (ground, bodies of several nodes).
    coordinates: (n,) of the node.
    pose: of these coordinates; None for bodies without orientation.
    """

    number: int
    name: str
    node: int | None
    coordinates: Array
    pose: Callable[[Array], Pose] | None

    @property
    def is_ground(self) -> bool:
        return self.node is None and self.pose is not None

    def orientation(self) -> Array:
        """(3, 3) A of the initial configuration.

        Raises:
            InputError: the body has none.
        """
        if self.pose is None:
            raise InputError(
                f"{self.name} has no orientation that a cable could be clamped to: use kind='hinge', or a "
                "rigid body with nodeType RotationEulerParameters or RotationRxyz, or ground."
            )
        return self.pose(self.coordinates)[1]

    def point(self, mbs: Any, local_position: Array) -> Array:
        """(3,) initial position of a point of the body [m]."""
        if self.pose is None:
            return _reference_point(mbs, self.number, local_position)
        origin, rotation, _ = self.pose(self.coordinates)
        return origin + rotation @ local_position


def pose_in_plane(q: Array) -> Pose:
    """Of (x, y, phi)."""
    return np.array([q[0], q[1], 0.0]), RotationMatrixZ(q[2]), np.diag([0.0, 0.0, 1.0])


def pose_of_angles(q: Array) -> Pose:
    """Of (x, y, z, a, b, c): A = R_x(a) R_y(b) R_z(c)."""
    return q[:3], RotXYZ2RotationMatrix(q[3:]), np.hstack([np.zeros((3, 3)), RotXYZ2GLocal(q[3:])])


def pose_of_quaternion(q: Array) -> Pose:
    """Of (x, y, z, p0, p1, p2, p3), p normalised first, so that A stays a rotation; G p = 0."""
    norm = float(np.linalg.norm(q[3:]))
    p = q[3:] / norm
    return (
        q[:3],
        EulerParameters2RotationMatrix(p),
        np.hstack([np.zeros((3, 3)), EulerParameters2GLocal(p) / norm]),
    )


_POSES: dict[str, Callable[[Array], Pose]] = {
    "RigidBody2D": pose_in_plane,
    "RigidBodyRxyz": pose_of_angles,
    "RigidBodyEP": pose_of_quaternion,
}


def body_frame(mbs: Any, body_number: Any) -> BodyFrame:
    """A body of mbs, assembled or not.

    Raises:
        InputError: there is no body of that number.
    """
    count = mbs.systemData.NumberOfObjects()
    number = object_number(body_number)
    if not 0 <= number < count:
        raise InputError(
            f"bodyNumber = {body_number!r}: mbs has objects 0 to {count - 1}; give the number of a body or "
            "of a ground object."
        )
    data = mbs.GetObject(number)
    name = f"body {number} '{data['name']}' ({data['objectType']})"
    if data["objectType"] == "Ground":
        rotation = np.array(data["referenceRotation"], dtype=float).reshape(3, 3)
        pose = np.array(data["referencePosition"], dtype=float), rotation, np.zeros((3, 0))
        return BodyFrame(number, name, None, np.zeros(0), lambda q: pose)
    try:
        _reference_point(mbs, number, np.zeros(3))
    except Exception:
        raise InputError(
            f"{name} has no points that a cable could be attached to: give the number of a body (rigid body, "
            "mass point, native beam) or of a ground object."
        ) from None
    if "nodeNumber" not in data:
        return BodyFrame(number, name, None, np.zeros(0), None)
    node = mbs.GetNode(data["nodeNumber"])
    coordinates = np.add(node["referenceCoordinates"], node["initialCoordinates"])
    return BodyFrame(number, name, int(data["nodeNumber"]), coordinates, _POSES.get(node["nodeType"]))


def _reference_point(mbs: Any, number: int, local_position: Array) -> Array:
    kinds = exudyn.OutputVariableType.Position, exudyn.ConfigurationType.Reference
    return np.array(mbs.GetObjectOutputBody(number, kinds[0], local_position.tolist(), kinds[1]))
