"""Loads of an mbs on the nodes of a cable: constant and user-function ones."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..loads.nodal import NodalLoad
from .functions_of_time import is_of_time_alone

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}


def read_load(mbs: Any, number: int) -> NodalLoad | None:
    """Load `number` of mbs, or None if it is of a kind that is not supported."""
    data = mbs.GetLoad(number)
    marker = mbs.GetMarker(data["markerNumber"])
    kinds = (data["loadType"], marker["markerType"])
    if kinds[0] == "ForceVector" and kinds[1] in _POSITION_MARKERS and not data["bodyFixed"]:
        coordinates: tuple[int, ...] = (0, 1, 2)
        value, user_function = data["loadVector"], data["loadVectorUserFunction"]
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


def history_of(mbs: Any, user_function: Any, value: Any) -> Callable[[float], Any] | None:
    """t -> what the user function of a load returns; None without one.   value: of the load."""
    if not user_function:
        return None
    function = user_function["function"]
    return lambda t: function(mbs, t, value)
