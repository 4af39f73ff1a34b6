"""Sliding joints: the position p of a marker slides along cable elements, without friction.

The place s on the cable is no unknown. It is the foot of the perpendicular of p on the cable r(s), and with
the unit normals n there, one in the plane and two in space, the joint has an equation for each of them,

    c = n . (p - r(s)) = 0,    dc = n . (dp - S dq),

as neither the change of s nor that of n adds anything where p = r. Exudyn's ObjectJointSliding2D and
ObjectJointSliding have the place as an unknown of their own, which they find in each step.
"""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, NamedTuple

import exudyn
import numpy as np
from exudyn.exudynCPP import ObjectIndex

from ..arrays import Array
from ..errors import SceneError
from ..items.parameters import set_unnoted
from ..multibody.sliding import BEYOND, FRAME, set_frame, weigh
from ..run.compiled_scene import off_cable
from .joint_item import JACOBIAN, JointItem

FORMULATION = "useClassicalFormulation"
CLOSE = 1e-13  # of the place to the foot, relative to the length of an element
MOST_STEPS = 30  # of Newton's method, besides those from element to element
OFFSET = 1e-6  # of slidingMarkerOffsets from the ends of elements, relative to the length of the shortest
_POSITIONS = {2: slice(0, 2), 3: slice(1, 4)}  # equations that hold positions, among Exudyn's
_SUPPORTED = {
    "constrainRotation": False,
    "constrainRotations": 0,
    "constrainTranslations": 1,
    "axialForce": 0,
}
_REMEDIES = {"constrainRotations": "set it to [0, 0, 0]"}
_POSITION = exudyn.OutputVariableType.Position


class Foot(NamedTuple):
    """Place on a chain, in 2 or 3 dimensions d.

    segment: which element.   x: on it [m].   weights: (4,) S.   slope: (d,) r'.   way: (d,) p - r [m].
    frame: (3, 3) from which that of the slope follows, see `multibody.sliding`.
    """

    segment: int
    x: float
    weights: Array
    slope: Array
    way: Array
    frame: Array

    @property
    def orientation(self) -> Array:
        """(3, 3) rows: the direction of the slope, and the normals."""
        turn = np.eye(3)
        set_frame(len(self.slope), np.array([*self.slope, 0.0])[:3], self.frame, turn)
        return turn.T

    @property
    def normals(self) -> Array:
        """(d - 1, d)"""
        dim = len(self.slope)
        return self.orientation[1:dim, :dim]

    def beyond(self, length: float) -> float:
        """How far it lies beyond the ends of its element [m]; that of others than the end ones never does."""
        return max(-self.x, self.x - length, 0.0)

    @property
    def distances(self) -> Array:
        """(d - 1,) of p along the normals [m]."""
        return self.normals @ self.way


@dataclass(frozen=True, eq=False)
class SlidingJoint(JointItem):
    """See `JointItem`; it has an equation for each normal.

    equations: places of all of Exudyn's equations.
    slider: marker.   elements: (E,) objects.
    chain: (E, 4 d) places of their coordinates in the system vector.   references: (E, 4 d) of these.
    lengths, offsets: (E,) of elements, and s of their first nodes [m].
    data: (2,) places of segment and s among the data.   is_classical: which of Exudyn's formulations it has.
    last: (2,) segment, and x there [m], that were found last.   frame: see `Foot`.
    """

    equations: np.ndarray
    slider: int
    elements: np.ndarray
    chain: np.ndarray
    references: Array
    lengths: Array
    offsets: Array
    data: np.ndarray
    is_classical: bool
    last: Array = field(default_factory=lambda: np.zeros(2))
    frame: Array = field(default_factory=FRAME.copy)

    @property
    def dimension(self) -> int:
        return self.chain.shape[1] // 4

    def foot(self, mbs: Any) -> Foot:
        """Of the slider's position in mbs, by Newton's method from the last one.

        Beyond its ends the cable goes on straight.
        """
        position = np.asarray(mbs.GetMarkerOutput(self.slider, _POSITION))[: self.dimension]
        all_q = np.asarray(mbs.systemData.GetODE2Coordinates())
        segment, x = int(self.last[0]), float(self.last[1])
        at = SimpleNamespace(weights=np.zeros((4, 4)))
        for _ in range(MOST_STEPS + len(self.chain)):
            nodes = (all_q[self.chain[segment]] + self.references[segment]).reshape(4, -1)
            length = float(self.lengths[segment])
            at.x, at.length = x, length
            weigh(at)
            place, slope, bend = at.weights[:3] @ nodes
            way = position - place
            square = slope @ slope
            step = float(slope @ way) / max(square - bend @ way, 0.5 * square)
            if abs(step) <= CLOSE * length:
                break
            x += step
            if x < 0.0 and segment > 0:
                segment, x = segment - 1, float(self.lengths[segment - 1])
            elif x > length and segment < len(self.chain) - 1:
                segment, x = segment + 1, 0.0
        self.last[:] = segment, x
        return Foot(segment, x, at.weights[0], slope, way, self.frame)

    def near(self, mbs: Any) -> np.ndarray:
        """(k,) coordinates of the slider, and of the element on which it is."""
        of_slider = self.coordinates[: -np.unique(self.chain).size]
        return np.concatenate([of_slider, self.chain[self.foot(mbs).segment]])

    def turn_with(self, mbs: Any) -> None:
        """Let the frame follow from the present one, so that it does not twist about the slope there.

        A twist turns the force of the joint, which has no potential then.
        """
        self.frame[:] = self.foot(mbs).orientation

    def jacobian(self, mbs: Any) -> Array:
        """See `JointItem`; what the slider moves by is that of Exudyn's equations of positions, -dp/dq."""
        foot = self.foot(mbs)
        if not self.is_classical:
            set_unnoted(mbs, self.number, FORMULATION, True)
        moved = np.asarray(mbs.ComputeItem(ObjectIndex(self.number), JACOBIAN))[_POSITIONS[self.dimension]]
        if not self.is_classical:
            set_unnoted(mbs, self.number, FORMULATION, False)
        result = np.zeros((self.dimension - 1, len(self.coordinates)))
        of_slider = moved.shape[1] - self.chain.shape[1]
        result[:, :of_slider] = -foot.normals @ moved[:, :of_slider]
        at = np.searchsorted(self.coordinates[of_slider:], self.chain[foot.segment]) + of_slider
        result[:, at] -= np.kron(foot.weights, foot.normals)
        return result

    def multipliers(self, mbs: Any, nu: Array) -> Array:
        """Of Exudyn's equations: the force on the slider, and no change of s.   nu: (d - 1,)."""
        foot, result = self.foot(mbs), np.zeros(len(self.equations))
        if self.is_classical:
            result[_POSITIONS[self.dimension]] = -nu @ foot.normals
        else:
            result[1] = -nu[0] / float(np.linalg.norm(foot.slope))
        return result

    def beyond(self, mbs: Any) -> float:
        """How far the foot lies beyond the ends of the chain [m]."""
        foot = self.foot(mbs)
        return foot.beyond(float(self.lengths[foot.segment]))

    def take_place(self, data: Array) -> None:
        """Look for the foot from the place that data (D,) say."""
        segment, s = data[self.data]
        segment = int(np.clip(segment, 0, len(self.elements) - 1))
        self.last[:] = segment, s - self.offsets[segment]

    def put_place(self, mbs: Any, data: Array) -> None:
        """Set segment and s at present in data (D,).

        Raises:
            OffCableError: it has left the chain of elements.
        """
        foot = self.foot(mbs)
        length = float(self.lengths[foot.segment])
        beyond = foot.beyond(length)
        if beyond > BEYOND * length:
            raise off_cable(self.name, beyond, foot.x < 0.0)
        data[self.data] = foot.segment, self.offsets[foot.segment] + foot.x


def read_sliding_joint(mbs: Any, number: int, data: dict[str, Any], name: str) -> SlidingJoint:
    """An ObjectJointSliding2D or ObjectJointSliding, at the place that its data say.

    Raises:
        SceneError: it holds rotations, pulls along the cable, lets the slider leave the cable, or its offsets
            are not those of its elements.
    """
    for parameter, wanted in _SUPPORTED.items():
        if parameter in data and np.any(np.asarray(data[parameter]) != wanted):
            raise SceneError(
                f"{name} has {parameter} = {data[parameter]!r}, which explicit steps do not support: "
                f"{_REMEDIES.get(parameter, 'leave it out')}, or create the cable with "
                "enforcement='algebraic' for mbs.SolveDynamic."
            )
    elements = [int(mbs.GetMarker(marker)["bodyNumber"]) for marker in data["slidingMarkerNumbers"]]
    cables = [mbs.GetObject(element) for element in elements]
    lengths, offsets = np.array([cable["length"] for cable in cables]), np.array(data["slidingMarkerOffsets"])
    begins = offsets[0] + np.cumsum([0.0, *lengths[:-1]])
    if not np.abs(offsets - begins).max() <= OFFSET * lengths.min():
        raise SceneError(
            f"{name} has slidingMarkerOffsets = {offsets.tolist()}, but its elements, of lengths "
            f"{lengths.tolist()}, begin at {begins.tolist()} m: let them follow each other."
        )
    system = mbs.systemData
    nodes = [[int(node) for node in cable["nodeNumbers"]] for cable in cables]
    chain = np.array([[c for node in pair for c in system.GetNodeLTGODE2(node)] for pair in nodes], dtype=int)
    references = [[c for node in pair for c in mbs.GetNode(node)["referenceCoordinates"]] for pair in nodes]
    of_slider = system.GetObjectLTGODE2(number)[: -chain.shape[1]]
    at = np.array(system.GetObjectLTGData(number), dtype=int)
    equations = np.array(system.GetObjectLTGAE(number), dtype=int)
    normals = chain.shape[1] // 4 - 1
    joint = SlidingJoint(
        number=number,
        rows=equations[:normals],
        active=np.arange(normals),
        coordinates=np.concatenate([np.array(of_slider, dtype=int), np.unique(chain)]),
        name=name,
        follows_time=False,
        is_linear=False,
        scale=float(lengths.min()),
        equations=equations,
        slider=int(data["markerNumbers"][0]),
        elements=np.array(elements),
        chain=chain,
        references=np.array(references),
        lengths=lengths,
        offsets=offsets,
        data=at,
        is_classical=bool(data.get(FORMULATION, True)),
    )
    joint.take_place(np.asarray(system.GetDataCoordinates()))
    return joint
