"""User functions that give offsets of joints."""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from exudyn.rigidBodyUtilities import RotXYZ2RotationMatrix

from ...arrays import Array
from ...constraints.motion import many_differences, motion_of
from ...items.functions_of_time import drive_of, is_of_time_alone, python_function
from ...items.functions_that_look import FunctionsOfSteps
from ...multibody.build import FunctionOfTime
from ...run.moved_offsets import Sampled
from ...run.settings import SAY_OF_TIME
from ..joint_item import JointItem
from .unknown import UnknownItemError

OFFSET_FUNCTIONS = ("offsetUserFunction", "offsetUserFunction_t")
_PARAMETERS = {"ConnectorCoordinate": "offset", "JointGeneric": "offsetUserFunctionParameters"}
_NUMBERS = {"ConnectorCoordinate": 2, "JointGeneric": 1}  # of these functions that are asked


class TurnedFrame:
    """What the offsets of a GenericJoint are: distances o, and angles a that turn the first marker's axes.

    Exudyn turns them by RotXYZ2RotationMatrix(a), and knows no rates (CObjectJointGeneric.cpp).

    offsets: t [s] -> (6,) o and a.   axes: (3, 3) of the first marker in the frame of its point.
    """

    def __init__(self, offsets: Callable[[float], Any], axes: Array) -> None:
        self._offsets, self._axes = offsets, axes
        self._turned_once = lru_cache(1)(lambda *angles: self._turned_axes(np.array([angles])))

    def sample(self, times: Sequence[float]) -> Array:
        """(T, 3, 12) at these times [s]: o, then x, y, z of each axis, with their derivatives."""
        return many_differences(self._offsets, times, self._turned)

    def _turned(self, offsets: Array) -> Array:
        """(..., 6) o and a -> (..., 12) o, and the axes one after the other."""
        angles = offsets[..., 3:].reshape(-1, 3)
        found = np.empty((*offsets.shape[:-1], 12))
        found[..., :3] = offsets[..., :3]
        is_steady = (angles == angles[0]).all()  # as where distances alone are given
        turned = self._turned_once(*angles[0].tolist()) if is_steady else self._turned_axes(angles)
        found.reshape(-1, 12)[:, 3:] = turned
        return found

    def _turned_axes(self, angles: Array) -> Array:
        """(k, 9) at these angles (k, 3)."""
        rotations = RotXYZ2RotationMatrix(angles.T)  # (3, 3, k)
        return np.einsum("ij,jkn->nki", self._axes, rotations).reshape(-1, 9)


class _OfTime:
    """The user function of an offset, or its rate, as one of t [s], with the present parameters."""

    def __init__(self, mbs: Any, joint: JointItem, data: dict[str, Any], key: str) -> None:
        self._function, self._mbs, self._number = python_function(data[key]), mbs, joint.number
        self._parameters = data[_PARAMETERS[data["objectType"]]]
        self._given = partial(mbs.GetObjectParameter, joint.number, _PARAMETERS[data["objectType"]])

    def renew(self) -> None:
        """The parameters may have been set."""
        self._parameters = self._given()

    def __call__(self, t: float) -> Any:
        return self._function(self._mbs, t, self._number, self._parameters)


def read_functions(
    mbs: Any, joint: JointItem, data: dict[str, Any], axes: Array, of_steps: FunctionsOfSteps, is_set: bool
) -> tuple[list[FunctionOfTime], Sampled | None]:
    """What the offsets of a joint follow; together, if step functions steer them.

    Args:
        axes: (3, 3) of its first marker in the frame of its point.
        of_steps: functions that step functions may steer.
        is_set: whether step functions set parameters of its offset function.

    Raises:
        UnknownItemError: it may depend on the state.
    """
    is_steered = _is_steered(mbs, joint, data, of_steps, is_set)
    offset = _OfTime(mbs, joint, data, OFFSET_FUNCTIONS[0])
    if data["objectType"] == "JointGeneric":
        sampled, number = Sampled(joint.name, TurnedFrame(offset, axes).sample, offset.renew), 12
    elif is_steered:
        sampled, number = Sampled(joint.name, motion_of(offset, is_pure=False).sample, offset.renew), 1
    else:
        return [_sampled_offset(mbs, joint, data, offset)], None
    parts: list[FunctionOfTime] = [partial(sampled.part, k) for k in range(number)]
    return parts, sampled if is_steered else None


def _is_steered(
    mbs: Any, joint: JointItem, data: dict[str, Any], of_steps: FunctionsOfSteps, is_set: bool
) -> bool:
    """Whether step functions change what an offset function gives; arguments: see `read_functions`."""
    offset = data[OFFSET_FUNCTIONS[0]]
    given = [data[key] for key in OFFSET_FUNCTIONS[: _NUMBERS[data["objectType"]]] if data[key]]
    if all(is_of_time_alone(mbs, one) for one in given):
        return is_set and not drive_of(offset)
    if not is_of_time_alone(mbs, offset) and offset not in of_steps:
        raise UnknownItemError(
            f"{joint.name}, whose user function may depend on the state (if not: {SAY_OF_TIME})"
        )
    return True


def _sampled_offset(mbs: Any, joint: JointItem, data: dict[str, Any], offset: _OfTime) -> FunctionOfTime:
    """Of a CoordinateConstraint, with the rate that is given; one that is steered has another one."""
    given, of_rate = (data[key] for key in OFFSET_FUNCTIONS)
    if drive := drive_of(given):
        return lambda times: drive.sample(times)[:, :, 0]
    rate = _OfTime(mbs, joint, data, OFFSET_FUNCTIONS[1]) if of_rate else None
    motion = motion_of(offset, rate)
    return lambda times: motion.sample(times)[:, :, 0]
