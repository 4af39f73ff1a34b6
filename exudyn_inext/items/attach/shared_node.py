"""An end of a cable on a node of another one: its place, and, as of elements that share a node, its slope.

The cable has a node of its own there, which joints hold to the other one: Exudyn's SphericalJoint, and one
equation for the slopes in the plane, two in space, since both have unit length already.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from exudyn.itemInterface import MarkerNodePosition, SphericalJoint

from ...arrays import Array
from ...checks import require_flag
from ...errors import InputError
from ...multibody.same_slope import same_slopes, slope_difference
from ..arguments import node_number
from ..cable_data import cable_of_node
from .clamp_to_body import add_slope_constraint

TOLERANCE = 1e-6  # of places, relative to the length of the cable, of slopes [-], of velocities, relative


class SameSlope(NamedTuple):
    """What a constraint with these user functions does, see `multibody.same_slope`.

    node, own: numbers of the nodes of both slopes.   direction: (3,) d.   across: (k, 3) b_k.
    """

    node: int
    own: int
    direction: Array
    across: Array


@dataclass(frozen=True, eq=False)
class SharedNode:
    """A node of a cable, at which a new one begins or ends.

    end: 'Start' or 'End'.   number: of the node.   q, v: (2, dim) its initial coordinates and velocities.
    has_slope: whether its slope is shared, too.
    """

    end: str
    number: int
    q: Array
    v: Array
    has_slope: bool

    @property
    def name(self) -> str:
        return f"nodeNumber{self.end} = {self.number}"

    @property
    def dimension(self) -> int:
        return int(self.q.shape[1])

    def require_meeting(self, q: Array, v: Array, length: float) -> None:
        """Raise InputError unless the end of the cable is where the node is, and moves as it does.

        q, v: (2, dim) of that end.   length: of the cable [m].
        """
        if self.dimension != q.shape[1]:
            raise InputError(
                f"{self.name} is a node in {self.dimension}D, the new cable has dimension = {q.shape[1]}: "
                "give both cables the same dimension=..."
            )
        hinge = f"or share its position only, by shareSlope{self.end}=False"
        along = f"let the cable leave along that slope, by shape=CableShape(...), {hinge}"
        same = "give the same one by shape=CableShape(..., velocities=..., slopeVelocities=...)"
        self._compare("position", "m", self.q[0], q[0], length, "move that end, or choose another node")
        self._compare("velocity", "m/s", self.v[0], v[0], _size(self.v[0]), same)
        if self.has_slope:
            self._compare("slope", "-", self.q[1], q[1], 1.0, along)
            self._compare("slope velocity", "1/s", self.v[1], v[1], _size(self.v[1]), f"{same}, {hinge}")

    def _compare(self, what: str, unit: str, its: Array, own: Array, size: float, remedy: str) -> None:
        apart, limit = float(np.linalg.norm(own - its)), TOLERANCE * size
        if not apart <= limit:
            raise InputError(
                f"{self.name}: the {what} of that node is {its.tolist()}, of the cable's {self.end.lower()} "
                f"{own.tolist()} [{unit}], {apart:.3g} apart (limit {limit:.3g}): {remedy}."
            )

    def join(self, mbs: Any, own: int, slope: Array) -> list[int]:
        """Numbers of new constraints that hold a cable's own node to this one.   slope: (dim,) of both."""
        markers = [int(mbs.AddMarker(MarkerNodePosition(nodeNumber=node))) for node in (self.number, own)]
        axes = [1, 1, self.dimension - 2]
        name = f"position of nodes {self.number} and {own}"
        joint = SphericalJoint(name=name, markerNumbers=markers, constrainedAxes=axes)
        joints = [int(mbs.AddObject(joint))]
        return [*joints, _add_same_slope(mbs, self.number, own, slope)] if self.has_slope else joints


def _size(velocity: Array) -> float:
    return max(1.0, float(np.linalg.norm(velocity)))


def find_shared_node(mbs: Any, end: str, given: Any, share_slope: Any) -> SharedNode | None:
    """The node of that number, or None if none is given.

    Args:
        end: 'Start' or 'End' of the new cable.   given: node number.   share_slope: True or False.

    Raises:
        InputError: not a number of a node, or not a node of an inextensible cable.
    """
    has_slope = require_flag(f"shareSlope{end}", share_slope)
    if given is None:
        return None
    number, count = node_number(given), mbs.systemData.NumberOfNodes()
    if not 0 <= number < count:
        raise InputError(
            f"nodeNumber{end} = {given!r}: must be the number of a node, and mbs has {count} nodes; "
            "give one of cable['nodes'] of another cable."
        )
    node = mbs.GetNode(number)
    if cable_of_node(mbs, number) is None:
        raise InputError(
            f"nodeNumber{end} = {number}: '{node['name']}' ({node['nodeType']}) belongs to no inextensible "
            "cable; give one of cable['nodes'], or leave it out and join the cable by AttachToBody, or by a "
            "SphericalJoint between markers of both nodes (in the plane with constrainedAxes=[1, 1, 0])."
        )
    return shared_node(mbs, end, number, has_slope)


def shared_node(mbs: Any, end: str, number: int, has_slope: bool) -> SharedNode:
    """A node that a cable has, or will have.   Arguments: see `SharedNode`."""
    node = mbs.GetNode(number)
    q = np.add(node["referenceCoordinates"], node["initialCoordinates"]).reshape(2, -1)
    return SharedNode(end, number, q, np.reshape(node["initialVelocities"], q.shape), has_slope)


def _add_same_slope(mbs: Any, node: int, own: int, slope: Array) -> int:
    """Constraint that keeps the slopes of two nodes the same.   slope: (dim,) of both at the start."""
    dim, (direction, across) = len(slope), same_slopes(slope)

    def derivatives(q: Array) -> tuple[Array, Array]:
        slopes, gradients = np.zeros((2, 3)), np.zeros((len(across), 2, 3))
        slopes[:, :dim] = np.reshape(q, (2, 2, dim))[:, 1]
        one, other = slopes
        value = [
            slope_difference(b, direction, one, other, g) for b, g in zip(across, gradients, strict=True)
        ]
        jacobian = np.zeros((len(across), 2, 2, dim))
        jacobian[:, :, 1] = gradients[:, :, :dim]
        return np.array(value), jacobian.reshape(len(across), -1)

    meaning, name = SameSlope(node, own, direction, across), f"slope of nodes {node} and {own}"
    return add_slope_constraint(mbs, (node, own), derivatives, meaning, name)[1]
