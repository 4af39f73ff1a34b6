"""Which native cables change nothing."""

from typing import Any

ANCF_CABLES = {"ANCFCable", "ANCFCable2D"}
INERT = ("massPerLength", "bendingStiffness", "axialStiffness", "bendingDamping", "axialDamping")


def is_inert_cable(data: dict[str, Any]) -> bool:
    """Whether an object is a native ANCF cable that neither weighs nor resists: it changes no motion."""
    if data["objectType"] not in ANCF_CABLES or any(data[name] for name in INERT):
        return False
    return not any("UserFunction" in key and bool(value) for key, value in data.items())


def nodes_of_inert_cable(data: dict[str, Any]) -> tuple[int, ...]:
    """Numbers of both nodes of such a cable; none of another object."""
    return tuple(map(int, data["nodeNumbers"])) if is_inert_cable(data) else ()
