"""Joints and constraints as rows."""

from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from exudyn.rigidBodyUtilities import RotXYZ2RotationMatrix

from ...arrays import Array, collected
from ...constraints.motion import many_differences, motion_of
from ...items.attach.clamp_to_body import Clamp
from ...items.attach.shared_node import SameSlope
from ...items.functions_of_time import acceleration_of, is_driven, is_of_time_alone, python_function
from ...multibody.build import FunctionOfTime
from ...multibody.rows import ACROSS, ALONG, DIFFERENCE, DISTANCE, PARALLEL, ROLLING, ROW
from ...multibody.sliding import SLIDER, NoSliders, Sliders
from ...run.moved_offsets import MovedOffsets
from ...run.settings import SAY_OF_TIME
from ..joint_item import JointItem
from ..sliding_joints import SlidingJoint
from .points import Place, PointReader
from .unknown import UnknownItemError, require_no_functions

X, Y, Z = range(3)
_OFFSET_FUNCTIONS = ("offsetUserFunction", "offsetUserFunction_t")
_ROW = np.zeros(1, ROW)[0]
_ROW["factor"], _ROW["entry"], _ROW["function"], _ROW["turning"] = 1.0, -1, -1, -1
_OFFSETS = {"ConnectorCoordinate": "offset", "ConnectorDistance": "distance"}
_MOVED = (DIFFERENCE, ALONG, DISTANCE)  # kinds of rows that have offsets


@dataclass(frozen=True, eq=False)
class _Joint:
    """Both markers of a joint, and its axes in the frames of the points.

    places: of the markers.   axes: (2, 3, 3), columns x, y, z of both.
    is_moved: whether offsets, and how the axes of the first one turn, follow the time, see `TurnedFrame`.
    """

    places: tuple[Place, Place]
    axes: Array
    is_moved: bool = False

    def row(self, kind: int, **fields: Any) -> Any:
        row = _ROW.copy()
        row["points"] = [place.point for place in self.places]
        row["kind"] = kind
        for name, value in fields.items():
            row[name] = value
        return row

    def difference(self, i: int) -> Any:
        return self.row(DIFFERENCE, component=i, function=self._place(i))

    def along(self, side: int, i: int) -> Any:
        """The distance along axis i of one side."""
        moved = {"function": self._place(i), "turning": self._place(3 + 3 * i)}
        return self.row(ALONG, component=side, axes=self.axes[:, :, i], **moved)

    def across(self, i: int, j: int) -> Any:
        """Axis i of the first and axis j of the second side at a right angle."""
        axes = np.array([self.axes[0][:, i], self.axes[1][:, j]])
        return self.row(ACROSS, axes=axes, turning=self._place(3 + 3 * i))

    def _place(self, function: int) -> int:
        """Of a function, after those of other joints."""
        return 3 * function if self.is_moved else -1


class TurnedFrame:
    """What the offsets of a GenericJoint are: distances o, and angles a that turn the first marker's axes.

    Exudyn turns them by RotXYZ2RotationMatrix(a), and knows no rates (CObjectJointGeneric.cpp).

    offsets: t [s] -> (6,) o and a.   axes: (3, 3) of the first marker in the frame of its point.
    """

    def __init__(self, offsets: Callable[[float], Any], axes: Array) -> None:
        self._offsets, self._axes = offsets, axes
        self._known: tuple[list[float], Array] = ([], np.zeros((0, 3, 12)))

    def values(self, times: Sequence[float]) -> Array:
        """(T, 3, 12) at these times [s]: o, then x, y, z of each axis, with their derivatives."""
        if list(times) != self._known[0]:
            self._known = list(times), many_differences(self._offsets, times, self._turned)
        return self._known[1]

    def part(self, which: int, times: Sequence[float]) -> Array:
        """(T, 3) of one of the numbers, 0 to 11."""
        return self.values(times)[:, :, which]

    def _turned(self, offsets: Array) -> Array:
        """(..., 6) o and a -> (..., 12) o, and the axes one after the other."""
        rotations = RotXYZ2RotationMatrix(np.moveaxis(offsets[..., 3:], -1, 0))  # (3, 3, ...)
        axes = np.einsum("ij,jk...->...ki", self._axes, rotations).reshape(*offsets.shape[:-1], 9)
        return np.concatenate([offsets[..., :3], axes], axis=-1)


class KnownRows(NamedTuple):
    """Joints.   records: (m,), in their order.   functions: of time, that offsets are.

    moved: offsets that are set between steps; their values follow those of the functions.
    movable: numbers of joints whose offsets may be.
    sliders: see `Sliders`.
    """

    records: Any
    functions: Sequence[FunctionOfTime]
    moved: MovedOffsets
    movable: Set[int]
    sliders: Any


def read_rows(mbs: Any, joints: Sequence[JointItem], reader: PointReader, moved: Set[int]) -> KnownRows:
    """Read joints, of which some may be `moved` between steps.

    Raises:
        UnknownItemError: one has no compiled form.
    """
    rows: list[Any] = []
    functions: list[FunctionOfTime] = []
    offsets: list[_Offset] = []  # that may be moved
    sliding: list[tuple[Any, Array]] = []
    for joint in joints:
        if isinstance(joint, SlidingJoint):
            own, slider = _sliding(joint, reader)
            rows += own
            sliding.append((slider, joint.lengths))
            continue
        data = mbs.GetObject(joint.number)
        read = _READERS.get(data["objectType"])
        if read is None:
            raise UnknownItemError(joint.name)
        if data.get("alternativeConstraints"):
            raise UnknownItemError(f"{joint.name} with alternative constraints")
        found = read(data, joint.name, reader)
        of_joint = [found[k] for k in joint.active]
        if np.isfinite(joint.period):
            of_joint[0]["period"] = joint.period
        if data.get("offsetUserFunction") and data["objectType"] == "JointGeneric":
            for row in of_joint:
                row["function"] += 3 * len(functions) * (row["function"] >= 0)
                row["turning"] += 3 * len(functions) * (row["turning"] >= 0)
            frame = _turned_frame(mbs, joint, data, reader)
            functions += [partial(frame.part, k) for k in range(12)]
        elif data.get("offsetUserFunction"):
            of_joint[0]["function"], of_joint[0]["rest"] = 3 * len(functions), 0.0
            functions.append(_offset_function(mbs, joint, data))
        else:
            offsets += _offsets(mbs, joint.number, data["objectType"], of_joint, len(rows))
        rows += of_joint
    of_moved = _moved_offsets([one for one in offsets if one.joint in moved], len(functions))
    movable = {one.joint for one in offsets}
    return KnownRows(collected(ROW, rows), functions, of_moved, movable, _sliders(sliding))


class _Offset(NamedTuple):
    """Of a row of a joint.   record, row: of the row, and its number.   given: as it is set at present."""

    record: Any
    joint: int
    row: int
    given: Callable[[], float]


def _offsets(mbs: Any, number: int, kind: str, records: Sequence[Any], first: int) -> list[_Offset]:
    """Of the rows of a joint that have any.   first: number of its first row."""
    given = partial(mbs.GetObjectParameter, number, _OFFSETS[kind]) if kind in _OFFSETS else float
    rows = enumerate(records, first)
    return [_Offset(record, number, row, given) for row, record in rows if record["kind"] in _MOVED]


def _moved_offsets(found: Sequence[_Offset], functions: int) -> MovedOffsets:
    """Of these; their values follow those of so many functions."""
    for place, one in enumerate(found, functions):
        one.record.function, one.record.rest = 3 * place, one.record.offset
    _, numbers, rows, given = zip(*found, strict=True) if found else [()] * 4
    return MovedOffsets(numbers, rows, given)


def _sliders(found: Sequence[tuple[Any, Array]]) -> Any:
    """Of records, and the lengths of their elements."""
    if not found:
        return NoSliders()
    sizes = [len(lengths) for _, lengths in found]
    records = collected(SLIDER, [slider for slider, _ in found])
    records["lengths"] = np.cumsum(sizes) - sizes
    return Sliders(records, np.concatenate([lengths for _, lengths in found]))


def _sliding(joint: SlidingJoint, reader: PointReader) -> tuple[list[Any], Any]:
    """The rows, and the record of the point that slides along one cable."""
    dim = joint.dimension
    chain = [reader.nodes_of_element(int(element), dim) for element in joint.elements]
    first, width = chain[0][0], 2 * dim
    if chain != [(first + width * k, first + width * (k + 1)) for k in range(len(chain))]:
        raise UnknownItemError(f"{joint.name} along elements that do not follow each other on one cable")
    slider, follows = np.zeros(1, SLIDER)[0], reader.marker(joint.slider)
    point = reader.on_chain(first, len(chain), dim)
    slider["point"], slider["follows"], slider["first"] = point.point, follows.point, first
    slider["elements"], slider["segment"], slider["x"] = len(chain), *joint.last
    slider["length"], slider["dimension"] = joint.lengths[int(joint.last[0])], dim
    both = _Joint((point, follows), np.array([np.eye(3), np.zeros((3, 3))]))
    return [both.along(0, normal) for normal in range(1, dim)], slider


def _offset_function(mbs: Any, joint: JointItem, data: dict[str, Any]) -> FunctionOfTime:
    value, rate = (_of_time(mbs, joint, data[key], float(data["offset"])) for key in _OFFSET_FUNCTIONS)
    assert value is not None
    offset = data[_OFFSET_FUNCTIONS[0]]
    motion = motion_of(value, rate, acceleration_of(offset), is_driven=is_driven(offset))
    return lambda times: motion.sample(times)[:, :, 0]


def _turned_frame(mbs: Any, joint: JointItem, data: dict[str, Any], reader: PointReader) -> TurnedFrame:
    offsets = _of_time(mbs, joint, data["offsetUserFunction"], data["offsetUserFunctionParameters"])
    assert offsets is not None
    return TurnedFrame(offsets, _joint(_without_functions(data), joint.name, reader).axes[0])


def _of_time(mbs: Any, joint: JointItem, given: Any, parameters: Any) -> Callable[[float], Any] | None:
    """A user function as one of t [s], or None; UnknownItemError if it may depend on the state."""
    if not given:
        return None
    if not is_of_time_alone(mbs, given):
        raise UnknownItemError(
            f"{joint.name}, whose user function may depend on the state (if not: {SAY_OF_TIME})"
        )
    return partial(_called, python_function(given), mbs, joint.number, parameters)


def _called(function: Any, mbs: Any, number: int, parameters: Any, t: float) -> Any:
    return function(mbs, t, number, parameters)


def _without_functions(data: dict[str, Any]) -> dict[str, Any]:
    return {**data, **dict.fromkeys(_OFFSET_FUNCTIONS, 0)}


def _joint(data: dict[str, Any], name: str, reader: PointReader, has_frames: bool = True) -> _Joint:
    require_no_functions(data, name)
    places = tuple(reader.marker(number) for number in data["markerNumbers"])
    if has_frames and not all(place.has_frame for place in places):
        raise UnknownItemError(f"{name} between markers without frames")
    axes = np.array([place.turn for place in places])
    for k, own in enumerate(axes):
        if f"rotationMarker{k}" in data:
            own[:] = own @ data[f"rotationMarker{k}"]
    return _Joint(places, axes)  # type: ignore[arg-type]


def _spherical(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader, has_frames=False)
    return [joint.difference(i) for i in range(3)]


def _revolute_z(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader)
    return [*(joint.difference(i) for i in range(3)), joint.across(Z, X), joint.across(Z, Y)]


def _prismatic_x(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader)
    rows = [joint.along(0, Y), joint.along(0, Z)]
    return [*rows, joint.across(Z, Y), joint.across(Z, X), joint.across(X, Y)]


def _generic(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = replace(_joint(_without_functions(data), name, reader), is_moved=bool(data["offsetUserFunction"]))
    locked = np.asarray(data["constrainedAxes"], dtype=bool)
    holds_all = locked[:3].all()
    rows = [joint.difference(i) if holds_all else joint.along(0, i) for i in range(3)]
    axes = np.flatnonzero(locked[3:]).tolist()
    free = [i for i in range(3) if i not in axes]
    turns: list[Any] = [joint.across(X, X)] * 3  # those that are free are not taken
    if len(axes) == 3:
        turns = [joint.across(Z, Y), joint.across(Z, X), joint.across(X, Y)]
    elif len(axes) == 2:
        for axis in axes:
            turns[axis] = joint.across(free[0], axis)
    elif len(axes) == 1:
        turns[axes[0]] = joint.across(free[0], free[1])
    return rows + turns


def _revolute_2d(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader, has_frames=False)
    return [joint.difference(i) for i in range(2)]


def _prismatic_2d(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader)
    along, normal = np.asarray(data["axisMarker0"]), np.asarray(data["normalMarker1"])
    axes = np.array([joint.axes[0] @ along, joint.axes[1] @ normal])
    return [joint.row(ALONG, component=1, axes=axes), joint.row(ACROSS, axes=axes)]


def _distance(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader, has_frames=False)
    return [joint.row(DISTANCE, offset=data["distance"])]


def _rolling_disc(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader)
    axes = np.array([joint.axes[0] @ data["planeNormal"], joint.axes[1] @ data["discAxis"]])
    return [joint.row(ROLLING, component=k, axes=axes, offset=data["discRadius"]) for k in range(3)]


def _coordinate(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(_without_functions(data), name, reader, has_frames=False)
    factor = data.get("factor1", data.get("factorValue1", 1.0))
    return [joint.row(DIFFERENCE, factor=factor, offset=data["offset"])]


def _of_vector(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    """Of coordinates; or of a slope that follows a body, see `clamp_to_body`, or another slope."""
    function = data["constraintUserFunction"]
    if not function:
        return _coordinates(data, name, reader)
    meaning = getattr(function["function"], "meaning", None)
    if isinstance(meaning, Clamp):
        return _clamp(meaning, reader)
    if isinstance(meaning, SameSlope):
        return _same_slope(meaning, reader)
    raise UnknownItemError(name)


def _coordinates(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    """Sums of the coordinates of nodes."""
    require_no_functions(data, name)
    nodes = [reader.node_of_coordinates(number) for number in data["markerNumbers"]]
    if any(np.any(data[f"quadraticTermMarker{k}"]) for k in range(2)):
        raise UnknownItemError(f"{name} with quadratic terms")
    rows = []
    for k, offset in enumerate(data["offset"]):
        weights = [data[f"scalingMarker{side}"][k : k + 1].ravel() for side in range(2)]
        one, other = map(reader.combination, nodes, weights)
        rows.append(_Joint((one, other), np.zeros((2, 3, 3))).row(DIFFERENCE, offset=offset))
    return rows


def _same_slope(same: SameSlope, reader: PointReader) -> list[Any]:
    slopes = reader.slope(same.node), reader.slope(same.own)
    joint = _Joint(slopes, np.zeros((2, 3, 3)))
    return [joint.row(PARALLEL, axes=np.array([across, same.direction])) for across in same.across]


def _clamp(clamp: Clamp, reader: PointReader) -> list[Any]:
    body, slope = reader.on_node(clamp.body_node, has_frame=True), reader.slope(clamp.node)
    joint = _Joint((body, slope), np.zeros((2, 3, 3)))
    rows = []
    for across in clamp.across:
        axes = np.array([across, np.zeros(3)])
        rows.append(joint.row(ALONG, component=0, factor=0.0, axes=axes))
    return rows


_READERS: dict[str, Callable[..., list[Any]]] = {
    "JointSpherical": _spherical,
    "JointRevoluteZ": _revolute_z,
    "JointPrismaticX": _prismatic_x,
    "JointGeneric": _generic,
    "JointRevolute2D": _revolute_2d,
    "JointPrismatic2D": _prismatic_2d,
    "JointRollingDisc": _rolling_disc,
    "ConnectorDistance": _distance,
    "ConnectorCoordinate": _coordinate,
    "ConnectorCoordinateVector": _of_vector,
}
