"""Loads as records, and their functions of time."""

from typing import Any, NamedTuple

import numpy as np

from ...arrays import copies_of
from ...items.load_items import course_of
from ...multibody.loads import LOAD, NONE
from ...run.load_functions import Asked
from ...run.settings import SAY_OF_TIME
from .points import Place, PointReader
from .unknown import UnknownItemError

_LOAD = np.zeros(1, LOAD)[0]
_LOAD["function"] = NONE
_new_load = copies_of(_LOAD)


class KnownLoad(NamedTuple):
    """record: of a load.   scale: of its components.   function: that it has, or None."""

    record: Any
    scale: float
    function: Asked | None


def read_load(mbs: Any, number: int, reader: PointReader, follows_state: bool = False) -> KnownLoad | None:
    """None for a weight of a cable's own.

    follows_state: whether its user function may depend on the state.

    Raises:
        UnknownItemError: it has no compiled form.
    """
    data = mbs.GetLoad(number)
    if data["loadType"] == "MassProportional" and reader.is_on_cable(int(data["markerNumber"])):
        return None
    name = f"load {number} '{data['name']}' ({data['loadType']})"
    record, scale = _placed(data, name, mbs, reader)
    value = data["load"] if data["loadType"] == "Coordinate" else data["loadVector"]
    user_function = data.get("loadVectorUserFunction") or data.get("loadUserFunction")
    constant, history, is_pure = course_of(mbs, user_function, value, scale)
    record["constant"][: len(constant)] = scale * constant
    if history is None:
        return KnownLoad(record, scale, None)
    if not is_pure:
        name += f", whose user function may depend on the state (if it does not: {SAY_OF_TIME})"
        if not follows_state:
            raise UnknownItemError(name)
    return KnownLoad(record, scale, Asked(history, len(constant), name, is_pure))


def _placed(data: dict[str, Any], name: str, mbs: Any, reader: PointReader) -> tuple[Any, float]:
    """A record without values, and what to multiply these with."""
    record = _new_load()
    kind, scale = data["loadType"], 1.0
    place: Place = reader.marker(int(data["markerNumber"]))
    if kind == "TorqueVector" and not place.has_frame:
        raise UnknownItemError(f"{name} on a marker without a frame")
    if kind == "MassProportional":
        marker = mbs.GetMarker(data["markerNumber"])
        if marker["markerType"] != "BodyMass":
            raise UnknownItemError(name)
        scale = reader.mass(int(marker["bodyNumber"]))
    elif kind not in ("ForceVector", "TorqueVector", "Coordinate"):
        raise UnknownItemError(name)
    if data.get("bodyFixed"):
        if not np.array_equal(place.turn, np.eye(3)):
            raise UnknownItemError(f"{name} in the frame of a marker that is turned")
        record["is_fixed_to_body"] = 1
    record["point"], record["is_torque"] = place.point, int(kind == "TorqueVector")
    return record, scale
