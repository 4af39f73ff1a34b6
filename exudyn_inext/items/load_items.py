"""Loads of an mbs on the nodes of a cable: constant and user-function ones."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..loads.nodal import NodalLoad
from .functions_of_time import is_of_time_alone
from .mass_points import mass_of_point, node_of_mass_point

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}


def read_load(mbs: Any, number: int) -> NodalLoad | None:
    """Load `number` of mbs, or None if it is of a kind that is not supported."""
    data = mbs.GetLoad(number)
    marker = mbs.GetMarker(data["markerNumber"])
    kinds = (data["loadType"], marker["markerType"])
    if kinds[0] == "ForceVector" and kinds[1] in _POSITION_MARKERS and not data["bodyFixed"]:
        coordinates: tuple[int, ...] = (0, 1, 2)
        value, user_function = data["loadVector"], data["loadVectorUserFunction"]
    elif kinds == ("MassProportional", "BodyMass"):
        return _weight_of_mass_point(mbs, data, mbs.GetObject(marker["bodyNumber"]))
    elif kinds == ("Coordinate", "NodeCoordinate"):
        coordinates = (int(marker["coordinate"]),)
        value, user_function = data["load"], data["loadUserFunction"]
    else:
        return None
    return NodalLoad(
        node=int(marker["nodeNumber"]),
        coordinates=coordinates,
        constant=np.atleast_1d(np.asarray(value, dtype=float)),
        history=history_of(mbs, user_function, value),
        is_pure=is_of_time_alone(mbs, user_function),
        number=number,
    )


def _weight_of_mass_point(mbs: Any, data: dict[str, Any], body: dict[str, Any]) -> NodalLoad | None:
    """A force on the node of a mass point, or None if the body is something else.

    It has no number: whoever sets its vector sets no force.   data: of a LoadMassProportional.
    """
    node = node_of_mass_point(body)
    if node < 0:
        return None
    mass, user_function = mass_of_point(body), data["loadVectorUserFunction"]
    acceleration = history_of(mbs, user_function, data["loadVector"])
    return NodalLoad(
        node=node,
        coordinates=(0, 1, 2),
        constant=mass * np.asarray(data["loadVector"], dtype=float),
        history=acceleration and (lambda t: mass * np.asarray(acceleration(t), dtype=float)),
        is_pure=is_of_time_alone(mbs, user_function),
    )


def history_of(mbs: Any, user_function: Any, value: Any) -> Callable[[float], Any] | None:
    """t -> what the user function of a load returns; None without one.   value: of the load."""
    if not user_function:
        return None
    function = user_function["function"]
    return lambda t: function(mbs, t, value)
