"""Parameters of items, read and set by the methods of exudyn.MainSystem as Exudyn has them."""

from typing import Any, NamedTuple

import exudyn

KINDS = ("Load", "Object", "Marker", "Node")
METHODS = {
    f"{what}{kind}Parameter": getattr(exudyn.MainSystem, f"{what}{kind}Parameter")
    for what in ("Get", "Set")
    for kind in KINDS
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
        value = METHODS[f"Get{self.kind}Parameter"](mbs, self.number, self.name)
        return value.get("function", value) if isinstance(value, dict) else value

    def set(self, mbs: Any, value: Any) -> None:
        """Set it, unnoted."""
        METHODS[f"Set{self.kind}Parameter"](mbs, self.number, self.name, value)


def set_unnoted(mbs: Any, number: int, name: str, value: Any) -> None:
    """Set a parameter of an object for the package's own use."""
    Parameter("Object", number, name).set(mbs, value)
