"""Where a point of a body is before a run, and how directions fixed to the body follow its coordinates."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np

from ...arrays import Array
from ...errors import InputError
from ..arguments import object_number

_Rotation = Callable[[Array], tuple[Array, Array]]  # of nodal coordinates: A (3, 3), dA/dq (n, 3, 3)


@dataclass(frozen=True, eq=False)
class BodyFrame:
    """A body in its initial configuration.

    number: of the object.   name: for messages.   origin: (3,) of its frame [m].
    node: number of its node, or None (ground, bodies of several nodes).
    coordinates: (n,) of the node.
    rotation: of these coordinates, A (3, 3) from the body's to the global frame, and dA/dq (n, 3, 3); None
        for bodies without orientation.
    """

    number: int
    name: str
    origin: Array
    node: int | None
    coordinates: Array
    rotation: _Rotation | None

    @property
    def is_ground(self) -> bool:
        return self.node is None and self.rotation is not None

    def orientation(self) -> Array:
        """(3, 3) A of the initial configuration.

        Raises:
            InputError: the body has none.
        """
        if self.rotation is None:
            raise InputError(
                f"{self.name} has no orientation that a cable could be clamped to: use kind='hinge', or a "
                "rigid body with nodeType RotationEulerParameters or RotationRxyz, or ground."
            )
        return self.rotation(self.coordinates)[0]

    def point(self, mbs: Any, local_position: Array) -> Array:
        """(3,) initial position of a point of the body [m]."""
        if self.rotation is not None:
            return self.origin + self.orientation() @ local_position
        kinds = exudyn.OutputVariableType.Position, exudyn.ConfigurationType.Reference
        return np.array(mbs.GetObjectOutputBody(self.number, kinds[0], local_position.tolist(), kinds[1]))


def rotation_in_plane(q: Array) -> tuple[Array, Array]:
    """Of (x, y, phi)."""
    rate = np.zeros((3, 3, 3))
    rotation, rate[2] = _about_axis(2, float(q[2]))
    return rotation, rate


def rotation_of_angles(q: Array) -> tuple[Array, Array]:
    """Of (x, y, z, a, b, c): A = R_x(a) R_y(b) R_z(c)."""
    factors = [_about_axis(axis, float(q[3 + axis])) for axis in range(3)]
    rate = np.zeros((6, 3, 3))
    for which in range(3):
        x, y, z = (factor[int(axis == which)] for axis, factor in enumerate(factors))
        rate[3 + which] = x @ y @ z
    return factors[0][0] @ factors[1][0] @ factors[2][0], rate


def rotation_of_quaternion(q: Array) -> tuple[Array, Array]:
    """Of (x, y, z, p0, p1, p2, p3), p normalised first, so that A stays a rotation."""
    norm = float(np.linalg.norm(q[3:7]))
    unit = q[3:7] / norm
    rate = np.zeros((7, 3, 3))
    along = np.eye(4) - np.outer(unit, unit)
    by_unit = np.stack([2.0 * _quadratic(unit, direction) for direction in np.eye(4)])
    rate[3:] = np.einsum("ab,bij->aij", along, by_unit) / norm
    return _quadratic(unit, unit), rate


def _quadratic(p: Array, s: Array) -> Array:
    """Symmetric bilinear form whose value at (p, p) is the rotation matrix of the unit quaternion p."""
    cross = np.array([[0.0, -p[3], p[2]], [p[3], 0.0, -p[1]], [-p[2], p[1], 0.0]])
    other = np.array([[0.0, -s[3], s[2]], [s[3], 0.0, -s[1]], [-s[2], s[1], 0.0]])
    outer = np.outer(p[1:], s[1:]) + np.outer(s[1:], p[1:])
    scale = p[0] * s[0] - np.dot(p[1:], s[1:])
    result: Array = scale * np.eye(3) + outer + p[0] * other + s[0] * cross
    return result


def _about_axis(axis: int, angle: float) -> tuple[Array, Array]:
    """Rotation about a coordinate axis, and its derivative."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation, rate = np.eye(3), np.zeros((3, 3))
    for matrix, cos, sin in ((rotation, np.cos(angle), np.sin(angle)), (rate, -np.sin(angle), np.cos(angle))):
        matrix[first, first] = matrix[second, second] = cos
        matrix[second, first], matrix[first, second] = sin, -sin
    return rotation, rate


_ROTATIONS: dict[str, _Rotation] = {
    "RigidBody2D": rotation_in_plane,
    "RigidBodyRxyz": rotation_of_angles,
    "RigidBodyEP": rotation_of_quaternion,
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
        fixed = np.array(data["referenceRotation"], dtype=float).reshape(3, 3)
        origin = np.array(data["referencePosition"], dtype=float)
        return BodyFrame(number, name, origin, None, np.zeros(0), lambda q: (fixed, np.zeros((0, 3, 3))))
    _require_body(mbs, number, name)
    if "nodeNumber" not in data:
        return BodyFrame(number, name, np.zeros(3), None, np.zeros(0), None)
    return _on_node(mbs, number, name, int(data["nodeNumber"]))


def _on_node(mbs: Any, number: int, name: str, node_number: int) -> BodyFrame:
    node = mbs.GetNode(node_number)
    coordinates = np.add(node["referenceCoordinates"], node["initialCoordinates"])
    rotation = _ROTATIONS.get(node["nodeType"])
    origin = np.zeros(3)
    places = 2 if node["nodeType"] == "RigidBody2D" else 3
    origin[:places] = coordinates[:places] if rotation else 0.0
    return BodyFrame(number, name, origin, node_number, coordinates, rotation)


def _require_body(mbs: Any, number: int, name: str) -> None:
    kinds = exudyn.OutputVariableType.Position, exudyn.ConfigurationType.Reference
    try:
        mbs.GetObjectOutputBody(number, kinds[0], [0.0, 0.0, 0.0], kinds[1])
    except Exception:
        raise InputError(
            f"{name} has no points that a cable could be attached to: give the number of a body (rigid body, "
            "mass point, native beam) or of a ground object."
        ) from None
