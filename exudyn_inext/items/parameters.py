"""Parameters of items, read and set by the methods of exudyn.MainSystem as Exudyn has them."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import exudyn
import numpy as np

from ..errors import SceneError

KINDS = ("Load", "Object", "Marker", "Node")
_OF_NUMBERS = float, list, np.ndarray
CHECK_DIVISIONS = "look for what was divided by zero"
_GET, _SET = (
    {kind: getattr(exudyn.MainSystem, f"{what}{kind}Parameter") for kind in KINDS} for what in ("Get", "Set")
)

_CENTRE = "centerofmass"
# of grounds: which of them a marker names, and what places it; coordinates of a node are relative to that
_PLACES = {
    "Object": ("bodyNumber", ("referencePosition", "referenceRotation")),
    "Node": ("nodeNumber", ("referenceCoordinates",)),
}


class Parameter(NamedTuple):
    """A parameter of an item.   kind: Load, Object, ...   number: of the item."""

    kind: str
    number: int
    name: str

    def __str__(self) -> str:
        return f"'{self.name}' of {self.kind.lower()} {self.number}"

    def value(self, mbs: Any) -> Any:
        """As Exudyn gives it; functions without their description."""
        value = _GET[self.kind](mbs, self.number, self.name)
        return value.get("function", value) if isinstance(value, dict) else value

    @property
    def is_mass(self) -> bool:
        """Whether it is the mass, its centre, or the inertia of a body, under whichever name."""
        return self.kind == "Object" and self._plain_name in ("mass", "inertia", _CENTRE)

    @property
    def is_centre(self) -> bool:
        """Whether it is the centre of mass of a body."""
        return self.kind == "Object" and self._plain_name == _CENTRE

    @property
    def _plain_name(self) -> str:
        return self.name.removeprefix("physics").lower()

    def set(self, mbs: Any, value: Any) -> None:
        """Set it, unnoted."""
        _SET[self.kind](mbs, self.number, self.name, value)


def markers_placed_by(mbs: Any, key: Parameter) -> list[int] | None:
    """Markers that a parameter of a marker or a ground gives another place; None: it does something else."""
    if key.kind == "Marker":
        return [key.number] if key.name == "localPosition" else None
    owner, names = _PLACES.get(key.kind, ("", ()))
    if key.name not in names:
        return None
    markers = ((number, mbs.GetMarker(number)) for number in range(mbs.systemData.NumberOfMarkers()))
    return [
        number
        for number, data in markers
        if int(data.get(owner, -1)) == key.number and "Coordinate" not in data["markerType"]
    ]


def objects_at(mbs: Any, marker: int) -> list[int]:
    """Numbers of the objects that act on a marker, as far as they are switched on."""
    objects = ((number, mbs.GetObject(number)) for number in range(mbs.systemData.NumberOfObjects()))
    found = ((number, data) for number, data in objects if marker in map(int, data.get("markerNumbers", ())))
    return [number for number, data in found if data.get("activeConnector", True)]


def set_unnoted(mbs: Any, number: int, name: str, value: Any) -> None:
    """Set a parameter of an object for the package's own use."""
    Parameter("Object", number, name).set(mbs, value)


def require_numbers(data: Mapping[str, Any], kind: str, label: str) -> None:
    """Raise SceneError if a parameter is no number, as what was divided by zero.

    data: of the item.   kind: Load, Object, ...   label: the item, in messages.
    """
    for name, value in data.items():
        if type(value) in _OF_NUMBERS and lacks_numbers(value, kind) and not name.startswith("V"):
            raise SceneError(f"{name} of {label} = {_listed(value)}: must be finite; {CHECK_DIVISIONS}.")


def lacks_numbers(value: Any, kind: str) -> bool:
    """Whether it is NaN, or contains it; a load must not be infinite, as stops of a spring may.

    value: a number, a list or an array of these; anything else lacks none.
    """
    values = _listed(value)
    floats = [x for x in (values if isinstance(values, list) else [values]) if type(x) is float]
    return any(map(_is_not_finite if kind == "Load" else math.isnan, floats))


def _listed(value: Any) -> Any:
    return value.ravel().tolist() if isinstance(value, np.ndarray) else value


def _is_not_finite(x: float) -> bool:
    return not math.isfinite(x)
