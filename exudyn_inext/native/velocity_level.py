"""CoordinateConstraints at velocity level: in a run, they hold the integral of their velocity.

Exudyn has factor1 q1_t - q0_t = v(t), with v from offsetUserFunction_t or else the offset, and does not ask
offsetUserFunction (CObjectConnectorCoordinate.cpp). Explicit steps, which enforce places, take
factor1 q1 - q0 = c + int v dt, with c from the state in which the constraint begins to act. An offset that is
set at a step is reached at its end, at a steady acceleration. Angles, which markers give between -pi and pi,
count modulo the period of the left side.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import exudyn
import numpy as np

from ..arrays import Array
from ..constraints.motion import many_differences
from ..errors import SceneError
from ..items.arguments import described
from ..items.functions_of_time import is_of_time_alone, python_function
from ..items.parameters import Parameter, set_unnoted
from ..run.settings import SAY_OF_TIME
from ..run.steered import parabola

CELL = 1e-3  # over which a velocity is integrated by one formula [s]
_POINTS, _WEIGHTS = (x.tolist() for x in np.polynomial.legendre.leggauss(4))
_FUNCTIONS = ("offsetUserFunction", "offsetUserFunction_t")
_MAY_CHANGE = ("offset", "activeConnector")
_TEETH = 1000  # most of a wheel that is geared to another one


class Travel:
    """Integral of a velocity since `begin` [s].   velocity: t [s] -> [m/s]."""

    def __init__(self, velocity: Callable[[float], float], begin: float) -> None:
        self._velocity, self._begin = velocity, begin
        self._until = [0.0]  # the beginning of each cell

    def __call__(self, t: float) -> float:
        """[m] at t [s]."""
        cell = max(0, int((t - self._begin) / CELL))
        for k in range(len(self._until) - 1, cell):
            self._until.append(self._until[k] + self._within(k, CELL))
        return self._until[cell] + self._within(cell, t - self._begin - cell * CELL)

    def _within(self, cell: int, duration: float) -> float:
        start, half = self._begin + cell * CELL, 0.5 * duration
        values = (self._velocity(start + half * (1.0 + x)) for x in _POINTS)
        return half * sum(w * value for w, value in zip(_WEIGHTS, values, strict=True))


def _at_rest(t: float) -> float:
    return 0.0


class Drive:
    """A constraint at velocity level.

    number: of the object.   rate: its offsetUserFunction_t, or None.
    begin: when it began to act as it does [s].   place, speed: of the coordinates then [m, m/s].
    acceleration: through this step of the loop, if it has no `rate` [m/s^2].
    acts: whether it is active.   period: of the coordinates, or infinite.
    """

    def __init__(self, mbs: Any, number: int, data: dict[str, Any]) -> None:
        self._mbs, self.number = mbs, number
        self.given = {name: data[name] and data[name]["function"] for name in _FUNCTIONS}
        rate = data["offsetUserFunction_t"]
        self.rate = rate and python_function(rate)
        self.period = _period(mbs, number, data)
        self.begin, self.place, self.speed, self.acceleration = 0.0, 0.0, 0.0, 0.0
        self._offset, self.acts = 0.0, False
        self._travel: Callable[[float], float] = _at_rest
        self._powers = np.zeros((3, 3, 1))  # of the time since it began, see `sample`

    def start(self, begin: float, end: float | None = None) -> None:
        """Act from `begin` [s] on, from the place in the present state of mbs.

        end: of the step, at which a velocity that was set is reached [s]; None: at once.
        """
        speed = None if end is None or self.rate or not self.acts else self.velocity(begin)
        self.place, self._travel = 0.0, _at_rest
        equation = exudyn.OutputVariableType.ConstraintEquation
        place = float(np.ravel(self._mbs.GetObjectOutput(self.number, equation))[0])
        offset = float(self._mbs.GetObjectParameter(self.number, "offset"))
        if speed is None or end is None:
            self.restore(begin, place, offset, 0.0)
        else:
            self.restore(begin, place, speed, (offset - speed) / (end - begin))

    def restore(self, begin: float, place: float, speed: float, acceleration: float) -> None:
        """Act from `begin` [s] on, from that place and speed."""
        self._offset, self.acts = float(self._mbs.GetObjectParameter(self.number, "offset")), True
        self.begin, self.place, self.speed, self.acceleration = begin, place, speed, acceleration
        self._travel = Travel(self.velocity, begin) if self.rate else self._steady_travel
        p, v, a = place, speed, acceleration
        self._powers = np.array([[[p], [v], [a]], [[v], [a], [0.0]], [[0.5 * a], [0.0], [0.0]]])

    def _steady_travel(self, t: float) -> float:
        return (self.speed + 0.5 * self.acceleration * (t - self.begin)) * (t - self.begin)

    def velocity(self, t: float) -> float:
        """[m/s] at t [s]."""
        if self.rate:
            return float(self.rate(self._mbs, t, self.number, self._offset))
        return self.speed + self.acceleration * (t - self.begin)

    def sample(self, times: Sequence[float]) -> Array:
        """(T, 3, 1) the place and its two derivatives at these times [s]."""
        if self.rate:
            values = many_differences(self.velocity, times)[:, [0, 0, 1]]
            values[:, 0, 0] = [self.place + self._travel(t) for t in times]
            return values
        return parabola(self._powers, [t - self.begin for t in times])

    def functions(self) -> dict[str, Any]:
        """Exudyn's user functions of the place and its rate."""

        def place(mbs: Any, t: float, itemNumber: int, lOffset: float) -> float:
            return self.place + self._travel(t)

        def velocity(mbs: Any, t: float, itemNumber: int, lOffset: float) -> float:
            return self.velocity(t)

        place.of_time_alone = velocity.of_time_alone = True  # type: ignore[attr-defined]
        place.drive, place.period = self, self.period  # type: ignore[attr-defined]
        velocity.given = self.given["offsetUserFunction_t"]  # type: ignore[attr-defined]  # counts in restart files
        return dict(zip(_FUNCTIONS, (place, velocity), strict=True))


def _period(mbs: Any, number: int, data: dict[str, Any]) -> float:
    """Of factor1 q1 - q0, of which either may be an angle; SceneError if both are and no period is found."""
    kinds = [mbs.GetMarker(marker)["markerType"] for marker in data["markerNumbers"]]
    first, other = (kind == "NodeRotationCoordinate" for kind in kinds)
    factor = float(data["factor1"])
    if not first:
        return 2.0 * np.pi * abs(factor) if other and factor else np.inf
    if not other:
        return 2.0 * np.pi
    ratio = Fraction(factor).limit_denominator(_TEETH)
    if abs(float(ratio) - factor) > 1e-12 * abs(factor):
        raise SceneError(
            f"{described(data, number)} gears two angles by factor1 = {factor:g}, which explicit steps "
            f"can follow only if it is a ratio of whole numbers up to {_TEETH}, as of teeth: take one."
        )
    return 2.0 * np.pi / ratio.denominator


class Drives:
    """All constraints at velocity level of an mbs, by their numbers."""

    def __init__(self, mbs: Any, drives: Mapping[int, Drive]) -> None:
        self._mbs, self._drives = mbs, drives

    def __contains__(self, number: int) -> bool:
        return number in self._drives

    def start(self, begin: float) -> None:
        """All that are active act from `begin` [s] on, from the present state of mbs."""
        for number, drive in self._drives.items():
            if self._mbs.GetObjectParameter(number, "activeConnector"):
                drive.start(begin)

    @property
    def moves(self) -> bool:
        """Whether a velocity changes through this step."""
        return any(drive.acceleration for drive in self._drives.values())

    def follow(self, changed: Collection[Parameter], time: float, end: float) -> None:
        """What has changed acts from `time` [s] on, at which mbs is; velocities are reached at `end` [s].

        Raises:
            SceneError: something else than the offset, or whether it is active, has changed.
        """
        if not self._drives:
            return
        keys = [key for key in changed if key.kind == "Object" and key.number in self._drives]
        for key in keys:
            if key.name not in _MAY_CHANGE:
                raise SceneError(
                    f"{key}, of a constraint at velocity level, was changed during the run, which it cannot "
                    "follow: change its offset, or whether it is active."
                )
        asked = {key.number for key in keys}
        for number, drive in self._drives.items():
            if number not in asked and not drive.acceleration:
                continue
            if self._mbs.GetObjectParameter(number, "activeConnector"):
                drive.start(time, end if number in asked and time > drive.begin else None)
            else:
                drive.acts, drive.acceleration = False, 0.0

    def memory(self) -> list[Any]:
        """Since when and from where they act, as plain data."""
        known = (
            (d.number, d.begin, d.place, d.speed, d.acceleration) for d in self._drives.values() if d.acts
        )
        return [list(one) for one in known]

    def restore(self, memory: Sequence[Any]) -> None:
        """As it was when `memory` was asked; the parameters of mbs are those of then."""
        for number, *state in memory:
            self._drives[number].restore(*state)


@contextmanager
def at_position_level(mbs: Any, time: float) -> Iterator[Drives]:
    """Meanwhile, constraints at velocity level hold places, from the present state of mbs at `time` [s] on.

    Raises:
        SceneError: a velocity may depend on the state.
    """
    drives = _read_drives(mbs)
    for number, drive in drives.items():
        for name, function in drive.functions().items():
            set_unnoted(mbs, number, name, function)
        set_unnoted(mbs, number, "velocityLevel", False)
    found = Drives(mbs, drives)
    try:
        found.start(time)
        yield found
    finally:
        for number, drive in drives.items():
            for name, function in drive.given.items():
                set_unnoted(mbs, number, name, function)
            set_unnoted(mbs, number, "velocityLevel", True)


def _read_drives(mbs: Any) -> dict[int, Drive]:
    drives = {}
    for number in range(mbs.systemData.NumberOfObjects()):
        data = mbs.GetObject(number)
        if data["objectType"] != "ConnectorCoordinate" or not data["velocityLevel"]:
            continue
        rate = data["offsetUserFunction_t"]
        if rate and not is_of_time_alone(mbs, rate):
            raise SceneError(
                f"{described(data, number)} constrains a velocity by a user function that may depend on the "
                f"state: if it depends on the time alone, {SAY_OF_TIME}; otherwise "
                "set its offset in a pre-step user function."
            )
        drives[number] = Drive(mbs, number, data)
    return drives
