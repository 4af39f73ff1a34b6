"""Parameters of items, read and set by the methods of exudyn.MainSystem as Exudyn has them."""

from typing import Any, NamedTuple

import exudyn

KINDS = ("Load", "Object", "Marker", "Node")
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
