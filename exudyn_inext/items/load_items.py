"""Loads of an mbs on the nodes of a cable: constant and user-function ones."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..loads.nodal import LoadFunction, NodalLoad
from .functions_of_time import is_of_time_alone, python_function
from .mass_points import node_of_mass_point

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}


def read_load(mbs: Any, number: int, data: dict[str, Any]) -> NodalLoad | None:
    """Load `number` of mbs, or None if it is of a kind that is not supported.   data: of it."""
    marker = mbs.GetMarker(data["markerNumber"])
    kinds = (data["loadType"], marker["markerType"])
    if kinds[0] == "ForceVector" and kinds[1] in _POSITION_MARKERS and not data["bodyFixed"]:
        coordinates: tuple[int, ...] = (0, 1, 2)
        value, user_function = data["loadVector"], data["loadVectorUserFunction"]
    elif kinds == ("MassProportional", "BodyMass"):
        return _weight_of_mass_point(mbs, number, data, mbs.GetObject(marker["bodyNumber"]))
    elif kinds == ("Coordinate", "NodeCoordinate"):
        coordinates = (int(marker["coordinate"]),)
        value, user_function = data["load"], data["loadUserFunction"]
    else:
        return None
    course = course_of(mbs, user_function, value)
    return NodalLoad(int(marker["nodeNumber"]), coordinates, *course, number)


def _weight_of_mass_point(
    mbs: Any, number: int, data: dict[str, Any], body: dict[str, Any]
) -> NodalLoad | None:
    """A force on the node of a mass point, or None if the body is something else.

    number, data: of a LoadMassProportional.
    """
    node = node_of_mass_point(body)
    if node < 0:
        return None
    mass = float(body["mass"])
    gravity, history, is_pure = course_of(mbs, data["loadVectorUserFunction"], data["loadVector"], mass)
    return NodalLoad(node, (0, 1, 2), mass * gravity, history, is_pure, number, mass)


def course_of(
    mbs: Any, user_function: Any, value: Any, scale: float = 1.0
) -> tuple[Array, LoadFunction | None, bool]:
    """`constant`, `history` and `is_pure` of a `NodalLoad`, from what Exudyn gives of a load.

    scale: of what its function returns, not of its constant.
    """
    constant = np.atleast_1d(np.asarray(value, dtype=float))
    if not user_function:
        return constant, None, False
    history = LoadFunction(python_function(user_function), mbs, value, scale)
    return constant, history, is_of_time_alone(mbs, user_function)
