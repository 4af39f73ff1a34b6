"""Joints and constraints as rows."""

from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, collected, copies_of
from ...items.attach.clamp_to_body import Clamp
from ...items.attach.shared_node import SameSlope
from ...items.functions_that_look import FunctionsOfSteps
from ...multibody.build import FunctionOfTime
from ...multibody.rows import ACROSS, ALONG, DIFFERENCE, DISTANCE, PARALLEL, ROLLING, ROW
from ...multibody.sliding import SLIDER, Sliders
from ...run.moved_offsets import MovedOffsets, Sampled
from ..joint_item import JointItem
from ..sliding_joints import SlidingJoint
from .offset_functions import OFFSET_FUNCTIONS, read_functions
from .points import Place, PointReader
from .unknown import UnknownItemError, require_no_functions

X, Y, Z = range(3)
_ROW = np.zeros(1, ROW)[0]
_ROW["factor"], _ROW["entry"], _ROW["functions"], _ROW["turning"] = 1.0, -1, -1, -1
_new_row = copies_of(_ROW)
_OFFSETS = {"ConnectorCoordinate": "offset", "ConnectorDistance": "distance"}
_MOVED = (DIFFERENCE, ALONG, ACROSS, DISTANCE)  # kinds of rows that have offsets


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
        row = _new_row()
        row["points"] = [place.point for place in self.places]
        row["kind"] = kind
        for name, value in fields.items():
            row[name] = value
        row["rest"] = row["offset"]
        return row

    def difference(self, i: int) -> Any:
        return self.row(DIFFERENCE, component=i, functions=(self.place(i), -1))

    def along(self, side: int, i: int) -> Any:
        """The distance along axis i of one side."""
        moved = {"functions": (self.place(i), -1), "turning": self.place(3 + 3 * i)}
        return self.row(ALONG, component=side, axes=self.axes[:, :, i], **moved)

    def across(self, i: int, j: int) -> Any:
        """Axis i of the first and axis j of the second side at a right angle."""
        axes = np.array([self.axes[0][:, i], self.axes[1][:, j]])
        return self.row(ACROSS, axes=axes, turning=self.place(3 + 3 * i))

    def place(self, function: int) -> int:
        """Of a function, after those of other joints."""
        return 3 * function if self.is_moved else -1


def read_rows(
    mbs: Any, joints: Sequence[JointItem], reader: PointReader, moved: Set[int]
) -> tuple[Any, Sequence[FunctionOfTime], MovedOffsets, Set[int], Sliders]:
    """Read joints, of which some may be `moved` between steps.

    Returns:
        records (m,) of their rows, functions of time that offsets are, offsets that are set, or whose
        functions are steered, between steps (their values follow those of the functions), numbers of joints
        whose offsets may be, and `Sliders`.

    Raises:
        UnknownItemError: one has no compiled form.
    """
    rows: list[Any] = []
    functions: list[FunctionOfTime] = []
    steered: dict[int, Sampled] = {}  # functions of joints
    of_steps = FunctionsOfSteps(mbs)
    offsets: list[_Offset] = []  # that may be moved
    sliding: list[tuple[Any, Array]] = []
    for joint in joints:
        if isinstance(joint, SlidingJoint):
            own, slider = _sliding(joint, reader)
            rows += own
            sliding.append((slider, joint.lengths))
            continue
        data = mbs.GetObject(joint.number)
        of_joint, given = _rows_of_joint(joint, data, reader), _given_offsets(mbs, joint, data)
        if data.get(OFFSET_FUNCTIONS[0]):
            _shift(of_joint, 3 * len(functions))
            axes = _moved_joint(data, joint.name, reader, has_frames=False).axes[0]
            found, sampled = read_functions(mbs, joint, data, axes, of_steps, joint.number in moved)
            functions += found
            if sampled:
                steered[joint.number] = sampled
        if joint.number in steered or not data.get(OFFSET_FUNCTIONS[0]):
            offsets += _offsets(joint.number, of_joint, given, len(rows))
        rows += of_joint
    set_between = [one for one in offsets if one.joint in moved or one.joint in steered]
    of_moved = _moved_offsets(set_between, len(functions), list(steered.values()))
    movable = {one.joint for one in offsets}
    return collected(ROW, rows), functions, of_moved, movable, _sliders(sliding)


def is_joint(data: dict[str, Any]) -> bool:
    """Whether an object is a joint that has rows here, unless none of its axes is held.   data: of it."""
    return data["objectType"] in _READERS


def _rows_of_joint(joint: JointItem, data: dict[str, Any], reader: PointReader) -> list[Any]:
    read = _READERS.get(data["objectType"])
    if read is None:
        raise UnknownItemError(joint.name)
    if data.get("alternativeConstraints"):
        raise UnknownItemError(f"{joint.name} with alternative constraints")
    found = read(data, joint.name, reader)
    of_joint = [found[k] for k in joint.active]
    if np.isfinite(joint.period):
        of_joint[0]["period"] = joint.period
    return of_joint


def _shift(records: Sequence[Any], number: int) -> None:
    """Let rows refer to functions that so many values of others precede."""
    for row in records:
        row["functions"][0] += number * (row["functions"][0] >= 0)
        row["turning"] += number * (row["turning"] >= 0)


class _Offset(NamedTuple):
    """Of a row of a joint.   record, row: of the row, and its number.   given: as it is set at present."""

    record: Any
    joint: int
    row: int
    given: Callable[[], float]


def _offsets(
    number: int, records: Sequence[Any], given: Sequence[Callable[[], float]], first: int
) -> Iterator[_Offset]:
    """Of the rows of a joint, of which the first has that number.   given: see `_given_offsets`."""
    for row, (record, own) in enumerate(zip(records, given, strict=True), first):
        if record["kind"] in _MOVED:
            yield _Offset(record, number, row, own)


def _given_offsets(mbs: Any, joint: JointItem, data: dict[str, Any]) -> list[Callable[[], float]]:
    """What gives the offsets of the rows of a joint, without its function [m]."""
    kind, get = data["objectType"], partial(mbs.GetObjectParameter, joint.number)
    if kind == "ConnectorCoordinateVector" and not data["constraintUserFunction"]:
        return [lambda k=k: float(get("offset")[k]) for k in joint.active.tolist()]  # type: ignore[misc]
    is_set = kind in _OFFSETS and not data.get(OFFSET_FUNCTIONS[0])
    return [partial(get, _OFFSETS[kind]) if is_set else float] * len(joint.active)


def _moved_offsets(found: Sequence[_Offset], functions: int, steered: Sequence[Sampled]) -> MovedOffsets:
    """Of these; their values follow those of so many functions.   steered: some of these."""
    for place, one in enumerate(found, functions):
        one.record.functions[1] = 3 * place
    _, numbers, rows, given = zip(*found, strict=True) if found else [()] * 4
    return MovedOffsets(numbers, rows, given, steered)


def _sliders(found: Sequence[tuple[Any, Array]]) -> Sliders:
    """Of records, and the lengths of their elements."""
    sizes = [len(lengths) for _, lengths in found]
    records = collected(SLIDER, [slider for slider, _ in found])
    records["lengths"] = np.cumsum(sizes) - sizes
    return Sliders(records, np.concatenate([np.zeros(0), *[lengths for _, lengths in found]]))


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


def _moved_joint(data: dict[str, Any], name: str, reader: PointReader, has_frames: bool = True) -> _Joint:
    """One whose offsets may follow user functions."""
    joint = _joint({**data, **dict.fromkeys(OFFSET_FUNCTIONS, 0)}, name, reader, has_frames)
    return replace(joint, is_moved=bool(data[OFFSET_FUNCTIONS[0]]))


def _same_place(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    """Of spherical joints, and of planar revolute ones."""
    joint = _joint(data, name, reader, has_frames=False)
    return [joint.difference(i) for i in range(2 if data["objectType"].endswith("2D") else 3)]


def _revolute_z(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader)
    return [*(joint.difference(i) for i in range(3)), joint.across(Z, X), joint.across(Z, Y)]


def _prismatic_x(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _joint(data, name, reader)
    rows = [joint.along(0, Y), joint.along(0, Z)]
    return [*rows, joint.across(Z, Y), joint.across(Z, X), joint.across(X, Y)]


def _generic(data: dict[str, Any], name: str, reader: PointReader) -> list[Any]:
    joint = _moved_joint(data, name, reader)
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
    joint = _moved_joint(data, name, reader, has_frames=False)
    offset = 0.0 if joint.is_moved else data["offset"]
    return [joint.row(DIFFERENCE, factor=data["factor1"], offset=offset, functions=(joint.place(0), -1))]


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
    "JointSpherical": _same_place,
    "JointRevoluteZ": _revolute_z,
    "JointPrismaticX": _prismatic_x,
    "JointGeneric": _generic,
    "JointRevolute2D": _same_place,
    "JointPrismatic2D": _prismatic_2d,
    "JointRollingDisc": _rolling_disc,
    "ConnectorDistance": _distance,
    "ConnectorCoordinate": _coordinate,
    "ConnectorCoordinateVector": _of_vector,
}
