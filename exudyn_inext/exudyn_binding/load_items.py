"""Loads of an mbs on the nodes of a cable: constant and user-function ones."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array

_POSITION_MARKERS = {"NodePosition", "NodeRigid"}


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """A generalised force on coordinates of one node.

    node: node number.
    coordinates: the nodal coordinate that each component acts on.
    constant: (m,) components [N, Nm].
    history: t -> its components as the user function returns them, or None if the load is constant.
    is_pure: whether the history depends on the time alone, so that it may be asked ahead of time.
    """

    node: int
    coordinates: tuple[int, ...]
    constant: Array
    history: Callable[[float], Any] | None
    is_pure: bool = False


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
        history=_history(mbs, user_function, value),
        is_pure=bool(user_function)
        and getattr(user_function["function"], "dependsOnTimeOnly", False) is True,
    )


def _history(mbs: Any, user_function: Any, value: Any) -> Callable[[float], Any] | None:
    if not user_function:
        return None
    function = user_function["function"]
    return lambda t: function(mbs, t, value)
