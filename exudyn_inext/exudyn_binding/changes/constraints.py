"""Constraints of cables that are switched on, moved or changed during a run."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import exudyn
import numpy as np

from ...arrays import Array
from ...scene.links import MovingCoordinate, Rod, motion_along
from ...scene.model import HeldCoordinate
from ..scene import ConstraintReader
from .stepped_motion import Way

FULFILLED = 1e-9  # violation [m, -] that needs no motion to be removed
_Output = exudyn.OutputVariableType


class _Moved(NamedTuple):
    """What became of a constraint that was changed.   target: what it asks for -> point (dim,) [m]."""

    way: Way
    target: Callable[[Any], Array]


class SteppedReader(ConstraintReader):
    """Reads the constraints during a run: those that have changed are fulfilled at the end of the step.

    A coordinate, or the fixed end of a rod, moves to its new place. A rod that gets another length, and
    whatever else is violated, becomes a joint between cable and ground, which Exudyn evaluates: see
    `NativeSurroundings.approach`.

    nodes: of all inextensible cables; constraints elsewhere are joints anyway.
    """

    def __init__(self, mbs: Any) -> None:
        self.nodes: frozenset[int] = frozenset()
        self._mbs = mbs
        self._moved: dict[int, _Moved] = {}
        self._joints: set[int] = set()
        self._last: dict[int, Any] = {}  # what each active constraint asked for
        self._with_functions: dict[int, tuple[Any, MovingCoordinate]] = {}
        self._step: tuple[float, float] | None = None
        self._restored: set[int] = set()  # had been moved before a restart file was written

    @property
    def moves(self) -> bool:
        """Whether something has moved through the last step."""
        return any(moved.way.moves for moved in self._moved.values())

    def begin_step(self, time: float, end: float) -> None:
        """Until something else is read, all rests; what is read now is fulfilled at `end` [s]."""
        self._step = time, end
        for moved in self._moved.values():
            moved.way.stop()

    def memory(self) -> dict[str, Any]:
        """Which constraints have been changed, as plain data."""
        return {"moved": sorted(self._moved), "joints": sorted(self._joints)}

    def restore(self, memory: Mapping[str, Any]) -> None:
        """Before the first reading of a run that continues: the `memory` of the run before."""
        self._restored, self._joints = set(memory["moved"]), set(memory["joints"])

    def held(self, mbs: Any, number: int, data: dict[str, Any]) -> HeldCoordinate | None:
        if data["objectType"] == "ConnectorCoordinate":
            self._follow_coordinate(number, data)
        return None if number in self._moved or number in self._joints else super().held(mbs, number, data)

    def moving(self, mbs: Any, number: int, data: dict[str, Any]) -> MovingCoordinate | None:
        if number in self._joints:
            return None
        if number in self._moved:
            moving = super().moving(mbs, number, _with_offset(data))
            return moving and replace(moving, motion=self._moved[number].way.motion)
        moving = super().moving(mbs, number, data)
        return self._the_same(number, moving, data) if moving and data["offsetUserFunction"] else moving

    def rod(self, mbs: Any, number: int, data: dict[str, Any]) -> Rod | None:
        rod = super().rod(mbs, number, data)
        if rod is None and data["objectType"] == "ConnectorDistance":
            self._forget(number)
        if rod is None:
            return None
        self._follow_rod(number, rod)
        if number in self._joints:
            return None
        return replace(rod, motion=self._moved[number].way.motion) if number in self._moved else rod

    def _forget(self, number: int) -> None:
        self._last.pop(number, None)
        self._moved.pop(number, None)

    def _the_same(self, number: int, moving: MovingCoordinate, data: dict[str, Any]) -> MovingCoordinate:
        """A coordinate with user functions, whose motion remains the same object as long as they do."""
        functions = [data[name] and data[name]["function"] for name in _OFFSET_FUNCTIONS]
        asked, last = (*functions, data["offset"]), self._with_functions.get(number)
        if last is not None and last[0] == asked:
            return last[1]
        dim = self._reference(moving.node).size // 2
        if moving.motion.at(0.0).shape[1] != dim:
            moving = replace(moving, motion=motion_along(moving.motion, moving.axis, dim))
        self._with_functions[number] = asked, moving
        return moving

    def _follow_coordinate(self, number: int, data: dict[str, Any]) -> None:
        if not data["activeConnector"] or data["offsetUserFunction"]:
            self._forget(number)
            return
        offset = float(data["offset"])
        if self._step is None and number in self._restored:
            moving = super().moving(self._mbs, number, _with_offset(data))
            assert moving is not None
            self._moved[number] = self._moved_to(moving.node, moving.axis, offset)
        if self._is_news(number, offset):
            self._move_coordinate(number, data, offset)

    def _is_news(self, number: int, asked: Any) -> bool:
        """Whether a constraint asks for something that it did not ask for when it was read last."""
        last = self._last.get(number)
        self._last[number] = asked
        return self._step is not None and last != asked and number not in self._joints

    def _move_coordinate(self, number: int, data: dict[str, Any], offset: float) -> None:
        moving = super().moving(self._mbs, number, _with_offset(data))
        if number not in self._moved:
            held = super().held(self._mbs, number, data | {"offset": 0.0})
            if held is None or held.node not in self.nodes:
                return
            if moving is None:  # a slope, or in an unusual form
                place = self._displacement(held.node)[held.coordinate]
                if abs(place - offset) > FULFILLED:
                    self._joints.add(number)
                return
            present = self._displacement(moving.node)[moving.axis]
            self._moved[number] = self._moved_to(moving.node, moving.axis, present)
        self._aim(number, offset)

    def _moved_to(self, node: int, axis: int, offset: float) -> _Moved:
        """A coordinate that is at an offset [m] from its reference value."""
        reference = self._reference(node)
        along = np.eye(reference.size // 2)[axis]

        def target(offset: float) -> Array:
            return (reference[axis] + offset) * along

        return _Moved(Way(target(offset)), target)

    def _follow_rod(self, number: int, rod: Rod) -> None:
        point = None if rod.point is None else tuple(rod.point.tolist())
        last = self._last.get(number)
        if self._step is None and number in self._restored:
            self._moved[number] = self._end_at(rod.nodes[0], point)
        if not self._is_news(number, (rod.nodes, rod.length, point)):
            return
        if last is not None and last[:2] == (rod.nodes, rod.length):
            if number not in self._moved:
                self._moved[number] = self._end_at(rod.nodes[0], last[2])
            self._aim(number, point)
        elif self._violation(rod) > FULFILLED:
            self._moved.pop(number, None)
            self._joints.add(number)

    def _end_at(self, node: int, point: Any) -> _Moved:
        """The fixed end (3,) of a rod to a node."""
        dim = self._reference(node).size // 2

        def target(end: Any) -> Array:
            return np.array(end[:dim])

        return _Moved(Way(target(point)), target)

    def _aim(self, number: int, asked: Any) -> None:
        assert self._step is not None
        way, target = self._moved[number]
        way.aim(target(asked), *self._step)

    def _violation(self, rod: Rod) -> float:
        """Of the distance, at present [m]."""
        ends = [self._mbs.GetNodeOutput(node, _Output.Position) for node in rod.nodes]
        other = rod.point if rod.point is not None else ends[1]
        return abs(float(np.linalg.norm(ends[0] - other)) - rod.length)

    def _reference(self, node: int) -> Array:
        return np.array(self._mbs.GetNodeParameter(node, "referenceCoordinates"))

    def _displacement(self, node: int) -> Array:
        return np.array(self._mbs.GetNodeOutput(node, _Output.Coordinates))


_OFFSET_FUNCTIONS = ("offsetUserFunction", "offsetUserFunction_t")


def _with_offset(data: dict[str, Any]) -> dict[str, Any]:
    """The same constraint, recognised as one that moves."""
    return data | {"offset": 1.0}
