"""Constraints of cables that are switched on, moved or changed during a run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import exudyn
import numpy as np

from ...arrays import Array
from ...cable.link import Motion
from ...items.functions_of_time import drive_of
from ...items.link_items import read_moving_coordinate
from ...items.parameters import Parameter, markers_placed_by
from ...native.velocity_level import Drives
from ...run.steered import Steered
from ...scene.links import MovingCoordinate, Rod, in_space
from ...scene.model import HeldCoordinate
from ..scene import Constraint, read_constraint

FULFILLED = 1e-9  # violation [m, -] that needs no motion to be removed
_Output = exudyn.OutputVariableType
_OFFSET_FUNCTIONS = ("offsetUserFunction", "offsetUserFunction_t")


class _Way(Steered):
    """Of a point that is told where to be at the end of each step.

    motion: of the point.
    """

    def __init__(self, point: Array) -> None:
        """point: (dim,) where it is [m]."""
        super().__init__(len(point))
        self._point = point
        at_times = self._places
        self.motion = Motion(lambda t: at_times([t])[0], is_pure=False, is_smooth=False, at_times=at_times)

    def lead(self, point: Array, time: float, end: float) -> None:
        """Be at `point` (dim,) [m] at the time `end` [s] of the step from `time` [s]."""
        self.aim(point - self._point, time, end)
        self._point = point

    def _places(self, times: Sequence[float]) -> Array:
        """(T, 3, dim) p, p_t, p_tt at these times [s], within the step or later."""
        values = -self.left_at(times)
        values[:, 0] += self._point
        return values


class _Known(NamedTuple):
    """A constraint as it was read last: the same object, as long as it asks for the same.

    asked: what it asks for.   constraint: of a cable; None: it has become a joint.
    way: along which it moves; None: it is as it was built.   markers: that it connects.
    place: (dim,) of a coordinate with an offset [m].
    """

    asked: Any
    constraint: Constraint | None
    way: _Way | None
    markers: Sequence[int] = ()
    place: Callable[[float], Array] | None = None


_Changed = tuple[Constraint | None, _Way | None, Callable[[float], Array] | None]


class SteppedReader:
    """Reads the constraints during a run: those that have changed are fulfilled at the end of the step.

    A coordinate, or the fixed end of a rod, moves to its new place. A rod that gets another length, and
    whatever else is violated, becomes a joint between cable and ground, which Exudyn evaluates: see
    `NativeItems.approach`.

    nodes: of all inextensible cables; constraints elsewhere are joints anyway.
    drives: constraints at velocity level.
    """

    def __init__(self, mbs: Any, drives: Drives) -> None:
        """mbs: the system.   drives: its constraints at velocity level."""
        self.nodes: frozenset[int] = frozenset()
        self._mbs, self.drives = mbs, drives
        self._markers_placed_by = cache(partial(markers_placed_by, mbs))
        self._known: dict[int, _Known] = {}
        self._step: tuple[float, float] | None = None
        self._restored: dict[int, list[float]] = {}  # memory of the ways of those that had been moved before

    @property
    def moves(self) -> bool:
        """Whether something has moved through the last step."""
        return self.drives.moves or any(known.way.moves for known in self._known.values() if known.way)

    def begin_step(self, time: float, end: float) -> None:
        """Until something else is read, all rests; what is read now is fulfilled at `end` [s]."""
        self._step = time, end
        for known in self._known.values():
            if known.way:
                known.way.rest()

    def aims(self, key: Parameter, value: Any) -> bool:
        """Whether a support, or ends of rods, of cables alone were moved again, whose ways now lead there."""
        if (key.kind, key.name) == ("Object", "offset"):
            if key.number in self.drives:
                return True
            known = self._known.get(key.number)
            if known is None or known.way is None or known.place is None or self._step is None:
                return False
            known.way.lead(known.place(value), *self._step)
            self._known[key.number] = known._replace(asked=(*known.asked[:-1], float(value)))
            return True
        placed = set(self._markers_placed_by(key) or ())
        ends = [number for number, known in self._known.items() if not placed.isdisjoint(known.markers)]
        if not ends or not all(self._known[number].way for number in ends):
            return False
        for number in ends:
            self(self._mbs, number, self._mbs.GetObject(number))
        return all(number in self._known and self._known[number].way for number in ends)

    def memory(self) -> dict[str, Any]:
        """Which constraints have been changed, as plain data."""
        known = sorted(self._known.items())
        return {
            "moved": [[number, it.way.memory.tolist()] for number, it in known if it.way],
            "joints": [number for number, it in known if it.constraint is None],
            "drives": self.drives.memory(),
        }

    def restore(self, memory: Mapping[str, Any]) -> None:
        """Before the first reading of a run that continues: the `memory` of the run before."""
        self._restored = dict(memory["moved"])
        self._known = {number: _Known(None, None, None) for number in memory["joints"]}
        self.drives.restore(memory["drives"])

    def __call__(self, mbs: Any, number: int, data: dict[str, Any]) -> Constraint | None:
        """See `read_constraint`."""
        last = self._known.get(number)
        if last is not None and last.constraint is None:
            return None
        found = read_constraint(mbs, number, data)
        if found is None:
            self._known.pop(number, None)
            return None
        asked = _asked(found, data)
        if last is None or last.asked != asked:
            constraint, way, place = self._changed(number, data, found, last)
            if way and self._step is None:
                way.memory[:] = self._restored[number]
            markers = tuple(map(int, data["markerNumbers"]))
            last = self._known[number] = _Known(asked, constraint, way, markers, place)
        return last.constraint

    def _changed(self, number: int, data: dict[str, Any], found: Constraint, last: _Known | None) -> _Changed:
        """What becomes of a constraint that asks for something else than when it was read last."""
        if isinstance(found, MovingCoordinate) and data["offsetUserFunction"]:
            return in_space(found, self._reference(found.node).size // 2), None, None
        if self._step is None:
            if number not in self._restored:
                return found, None, None
            last = _Known(_asked(found, data), found, None)
        if isinstance(found, Rod):
            return self._changed_rod(found, last)
        return self._changed_coordinate(number, data, found, last)

    def _changed_rod(self, rod: Rod, last: _Known | None) -> _Changed:
        """Its end moves, if nothing else has changed."""
        if rod.point is None or last is None or last.asked[:2] != (rod.nodes, rod.length):
            return rod if self._violation(rod) <= FULFILLED else None, None, None
        dim = self._reference(rod.nodes[0]).size // 2
        way = self._aimed(last, np.array(last.asked[2][:dim]), rod.point[:dim])
        return replace(rod, motion=way.motion), way, None

    def _changed_coordinate(
        self, number: int, data: dict[str, Any], found: HeldCoordinate | MovingCoordinate, last: _Known | None
    ) -> _Changed:
        """It moves there from where it is."""
        if self._step is not None and found.node not in self.nodes:
            return found, None, None
        movable = read_moving_coordinate(self._mbs, number, data | {"offset": 1.0})
        if movable is None:  # a slope, or in an unusual form
            assert isinstance(found, HeldCoordinate)
            violation = abs(self._displacement(found.node)[found.coordinate])
            return found if violation <= FULFILLED else None, None, None
        reference, axis = self._reference(movable.node), movable.axis
        along, offset = np.eye(reference.size // 2)[axis], float(data["offset"])
        present = offset if self._step is None else self._displacement(movable.node)[axis]

        def place(offset: float) -> Array:
            return (reference[axis] + offset) * along

        way = self._aimed(last, place(present), place(offset))
        return replace(movable, motion=way.motion), way, place

    def _aimed(self, last: _Known | None, start: Array, target: Array) -> _Way:
        """The way of a point so far, or from `start`, on to its target (dim,) [m]."""
        way = (last and last.way) or _Way(start)
        if self._step is not None:
            way.lead(target, *self._step)
        return way

    def _violation(self, rod: Rod) -> float:
        """Of the distance, at present [m]."""
        ends: Sequence[Any] = [self._mbs.GetNodeOutput(node, _Output.Position) for node in rod.nodes]
        other = rod.point if rod.point is not None else ends[1]
        return abs(float(np.linalg.norm(ends[0] - other)) - rod.length)

    def _reference(self, node: int) -> Array:
        return np.array(self._mbs.GetNodeParameter(node, "referenceCoordinates"))

    def _displacement(self, node: int) -> Array:
        return np.array(self._mbs.GetNodeOutput(node, _Output.Coordinates))


def _asked(found: Constraint, data: dict[str, Any]) -> tuple[Any, ...]:
    """What a constraint asks for: equal, if it is the same."""
    if isinstance(found, Rod):
        return found.nodes, found.length, None if found.point is None else tuple(found.point.tolist())
    functions = [data[name] and data[name]["function"] for name in _OFFSET_FUNCTIONS]
    return *functions, 0.0 if drive_of(data["offsetUserFunction"]) else float(data["offset"])
