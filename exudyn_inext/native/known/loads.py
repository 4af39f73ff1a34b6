"""Loads as records, and their functions of time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array, collected
from ...errors import SceneError
from ...items.load_items import history_of, is_of_time_alone
from ...multibody.loads import LOAD
from .points import Place, PointReader
from .unknown import Unknown


@dataclass(frozen=True, eq=False)
class LoadFunction:
    """A load that is a function of time.   name: of it.   at: t [s] -> its components.   scale: of them."""

    name: str
    at: Callable[[float], Any]
    scale: float
    number: int

    def values(self, t: float) -> Array:
        """(3,) at t [s]; SceneError if they are no finite numbers."""
        given = np.atleast_1d(np.asarray(self.at(t), dtype=float))
        if given.shape != (self.number,) or not np.isfinite(given).all():
            raise SceneError(
                f"the user function of {self.name} returned {given.tolist()} at t = {t:g} s: must return "
                f"{self.number} finite number(s)."
            )
        result = np.zeros(3)
        result[: self.number] = self.scale * given
        return result


def read_loads(mbs: Any, reader: PointReader) -> tuple[Any, Sequence[LoadFunction]]:
    """All loads but weights of cables; Unknown if one has no compiled form."""
    records, functions = [], []
    for number in range(mbs.systemData.NumberOfLoads()):
        data = mbs.GetLoad(number)
        if data["loadType"] == "MassProportional" and reader.is_on_cable(int(data["markerNumber"])):
            continue  # a weight of the cable's own
        name = f"load {number} '{data['name']}' ({data['loadType']})"
        record, scale = _read(data, name, mbs, reader)
        value = data["load"] if data["loadType"] == "Coordinate" else data["loadVector"]
        user_function = data.get("loadVectorUserFunction") or data.get("loadUserFunction")
        components = scale * np.atleast_1d(np.asarray(value, dtype=float))
        record.function = -1
        record.constant[: len(components)] = components
        if user_function:
            if not is_of_time_alone(user_function):
                raise Unknown(
                    f"{name} has a user function that may depend on the state; if it does not, set its "
                    "attribute dependsOnTimeOnly = True"
                )
            at = history_of(mbs, user_function, value)
            assert at is not None
            record.function = 3 * len(functions)
            functions.append(LoadFunction(name, at, scale, len(components)))
        records.append(record)
    return collected(LOAD, records), functions


def _read(data: dict[str, Any], name: str, mbs: Any, reader: PointReader) -> tuple[Any, float]:
    record = np.zeros(1, LOAD)[0]
    kind, scale = data["loadType"], 1.0
    marker = mbs.GetMarker(data["markerNumber"])
    place: Place = reader.marker(int(data["markerNumber"]))
    if kind == "TorqueVector" and not place.has_frame:
        raise Unknown(f"{name} on a marker without a frame")
    if kind == "MassProportional":
        if marker["markerType"] != "BodyMass":
            raise Unknown(name)
        scale = reader.mass(int(marker["bodyNumber"]))
    elif kind not in ("ForceVector", "TorqueVector", "Coordinate"):
        raise Unknown(name)
    if data.get("bodyFixed"):
        if not np.array_equal(place.turn, np.eye(3)):
            raise Unknown(f"{name} in the frame of a marker that is turned")
        record.is_fixed_to_body = 1
    record.point, record.is_torque = place.point, int(kind == "TorqueVector")
    return record, scale
