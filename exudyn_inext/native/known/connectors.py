"""Spring-dampers as records."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...items.arguments import described
from ...items.functions_that_look import FunctionsOfSteps
from ...multibody.connectors import (
    CARTESIAN,
    CONNECTOR,
    INTRINSIC,
    RUBBING,
    SIX,
    SPRING,
    set_directions,
)
from ...run.spring_functions import AskedSpring
from .points import Place, PointReader
from .spring_laws import read_law
from .unknown import UnknownItemError, require_no_functions

VALUES = {"stiffness", "damping", "offset", "referenceLength", "velocityOffset", "force", "torque"}


class KnownConnector(NamedTuple):
    """record: of a connector.   data: that it was read from.   places: of its markers.

    law: its user function, or None.
    """

    record: Any
    data: dict[str, Any]
    places: list[Place]
    law: AskedSpring | None = None

    def set(self, parameter: str, value: Any, record: Any) -> None:
        """One of the VALUES changes, and the record with it, unless it is switched off."""
        self.data[parameter] = value
        if self.data["activeConnector"] and not self.law:
            _READERS[self.data["objectType"]](self.data, "", self.places, record)


def read_connector(
    mbs: Any, number: int, reader: PointReader, of_steps: FunctionsOfSteps | None
) -> KnownConnector:
    """An object; without stiffness and all else if it is switched off.

    of_steps: functions that look at nothing; None: no user function may be called for the end of each step.

    Raises:
        UnknownItemError: it has no compiled form.
    """
    data = mbs.GetObject(number)
    name = described(data, number)
    if data["objectType"] not in _READERS:
        raise UnknownItemError(name)
    if not (of_steps and data["activeConnector"]):
        require_no_functions(data, name)
    record = np.zeros(1, CONNECTOR)[0]
    record["place"], record["factors"] = reader.place_of_data(data, number), 1.0
    record["directions"][:6] = np.eye(6)
    places = [reader.marker(k) for k in data["markerNumbers"]]
    record.points[:] = [place.point for place in places]
    of_values = record.copy()
    _READERS[data["objectType"]](data, name, places, of_values)
    if data["activeConnector"]:
        law = read_law(mbs, number, data, of_values, of_steps) if of_steps else None
        return KnownConnector(of_values, data, places, law)
    record["kind"] = CARTESIAN
    return KnownConnector(record, data, places)


def _spring(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    record["kind"] = SPRING
    record["stiffness"][0, 0], record["damping"][0, 0] = data["stiffness"], data["damping"]
    record["offset"][0], record["rate_offset"][0] = data["referenceLength"], data["velocityOffset"]
    record["force"][0] = data["force"]


def _cartesian(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    record["kind"] = CARTESIAN
    for i in range(3):
        record["stiffness"][i, i], record["damping"][i, i] = data["stiffness"][i], data["damping"][i]
        record["offset"][i] = data["offset"][i]


def _coordinate(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    record["kind"] = CARTESIAN
    record["stiffness"][0, 0], record["damping"][0, 0] = data["stiffness"], data["damping"]
    record["offset"][0] = data["offset"]


_OF_RUBBING = {
    "dynamic": "dynamicFrictionForce",
    "static": "staticFrictionOffsetForce",
    "decay": "exponentialDecayStatic",
    "viscosity": "viscousFrictionFactor",
    "zone": "frictionProportionalZone",
    "sticking_stiffness": "stickingStiffness",
    "sticking_damping": "stickingDamping",
    "has_stops": "useLimitStops",
    "stop_stiffness": "limitStopsStiffness",
    "stop_damping": "limitStopsDamping",
}


def _rubbing(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    _coordinate(data, name, places, record)
    record["kind"] = RUBBING
    record["factors"] = data["factor0"], data["factor1"]
    record["rate_offset"][0] = data["velocityOffset"]
    record["stops"] = data["limitStopsLower"], data["limitStopsUpper"]
    for field, parameter in _OF_RUBBING.items():
        record[field] = data[parameter]
    sticks = not record["zone"] and bool(record["dynamic"] or record["static"])
    if record["place"] < 0 and (sticks or record["has_stops"]):
        raise UnknownItemError(f"{name}, which rubs, or has stops, without a data node")


def _set_frames(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    if not all(place.has_frame for place in places):
        raise UnknownItemError(f"{name} between markers without frames")
    record["kind"] = SIX
    for k, place in enumerate(places):
        record["turns"][k] = place.turn @ data[f"rotationMarker{k}"]


def _rigid_body(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    _set_frames(data, name, places, record)
    if data["useIntrinsicFormulation"]:
        record["kind"] = INTRINSIC
    record["stiffness"][:], record["damping"][:] = data["stiffness"], data["damping"]
    set_directions(record)
    record["offset"][:] = data["offset"]


def _torsional(data: dict[str, Any], name: str, places: list[Place], record: Any) -> None:
    _set_frames(data, name, places, record)
    record["stiffness"][5, 5], record["damping"][5, 5] = data["stiffness"], data["damping"]
    record["offset"][5], record["rate_offset"][5] = data["offset"], data["velocityOffset"]
    record["force"][5] = data["torque"]


_READERS: dict[str, Callable[..., None]] = {
    "ConnectorSpringDamper": _spring,
    "ConnectorCartesianSpringDamper": _cartesian,
    "ConnectorCoordinateSpringDamper": _coordinate,
    "ConnectorCoordinateSpringDamperExt": _rubbing,
    "ConnectorRigidBodySpringDamper": _rigid_body,
    "ConnectorTorsionalSpringDamper": _torsional,
}
