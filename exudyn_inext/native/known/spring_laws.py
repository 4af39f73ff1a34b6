"""User functions of springs, called as Exudyn calls them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array
from ...items.arguments import described
from ...items.functions_of_time import python_function, step_functions
from ...items.functions_that_look import FunctionsOfSteps, may_change_anything
from ...run.spring_functions import AskedSpring
from .unknown import UnknownItemError, functions_of

_Arguments = Callable[[dict[str, Any], Array, Array, Array], tuple[Any, ...]]


def _along_distance(data: dict[str, Any], stretch: Array, rate: Array, frames: Array) -> tuple[Any, ...]:
    way, speed = stretch[0] - data["referenceLength"], rate[0] - data["velocityOffset"]
    return float(way), float(speed), data["stiffness"], data["damping"], data["force"]


def _cartesian(data: dict[str, Any], stretch: Array, rate: Array, frames: Array) -> tuple[Any, ...]:
    law = (np.asarray(data[name]).tolist() for name in ("stiffness", "damping", "offset"))
    return (stretch[:3] - data["offset"]).tolist(), rate[:3].tolist(), *law


def _coordinate(data: dict[str, Any], stretch: Array, rate: Array, frames: Array) -> tuple[Any, ...]:
    return float(stretch[0]), float(rate[0]), data["stiffness"], data["damping"], data["offset"]


def _rigid_body(data: dict[str, Any], stretch: Array, rate: Array, frames: Array) -> tuple[Any, ...]:
    motion = (part.tolist() for both in (stretch, rate) for part in (both[:3], both[3:]))
    names = "stiffness", "damping", "rotationMarker0", "rotationMarker1", "offset"
    return *motion, *(np.asarray(data[name]).tolist() for name in names)


def _torsional(data: dict[str, Any], stretch: Array, rate: Array, frames: Array) -> tuple[Any, ...]:
    return float(stretch[5]), float(rate[5]), data["stiffness"], data["damping"], data["offset"]


_FORCE = "springForceUserFunction"
_LAWS: dict[str, tuple[str, list[int], _Arguments]] = {  # name of the function, and axes along which it acts
    "ConnectorSpringDamper": (_FORCE, [0], _along_distance),
    "ConnectorCartesianSpringDamper": (_FORCE, [0, 1, 2], _cartesian),
    "ConnectorCoordinateSpringDamper": (_FORCE, [0], _coordinate),
    "ConnectorRigidBodySpringDamper": ("springForceTorqueUserFunction", list(range(6)), _rigid_body),
    "ConnectorTorsionalSpringDamper": ("springTorqueUserFunction", [5], _torsional),
}


def read_law(
    mbs: Any, number: int, data: dict[str, Any], record: Any, of_steps: FunctionsOfSteps
) -> AskedSpring | None:
    """What a user function of a spring asks for; None: it has none.

    number, data: of its object.   record: that it becomes, which then has no law of its own.
    of_steps: those that look at nothing.

    Raises:
        UnknownItemError: it must be asked by Exudyn.
    """
    key, axes, arguments = _LAWS.get(data["objectType"], ("", [], _coordinate))
    name, given = described(data, number), functions_of(data)
    if not given:
        return None
    if given != {key} or data.get("useIntrinsicFormulation"):
        raise UnknownItemError(f"{name}, which has a user function")
    function = python_function(data[key])
    if may_change_anything(function, mbs) or of_steps.may_set_objects:
        raise UnknownItemError(f"{name}, whose user function may change something, or be changed")
    for parameter in ("stiffness", "damping", "force"):
        record[parameter] = 0.0
    record["asked"][axes], record["splits"] = 1, int(len(axes) > 1)

    def law(t: float, stretch: Array, rate: Array, frames: Array) -> Any:
        return function(mbs, t, number, *arguments(data, stretch, rate, frames))

    looks = bool(step_functions(mbs)) or data[key] not in of_steps
    return AskedSpring(0, axes, name, law, looks)
