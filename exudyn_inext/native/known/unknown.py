"""Why a scene stays with Exudyn."""

from typing import Any


class UnknownItemError(Exception):
    """An item has no compiled form; the message names it."""


def require_no_functions(data: dict[str, Any], name: str) -> None:
    """Raise UnknownItemError if an item has a user function."""
    if any(isinstance(value, dict) for key, value in data.items() if "UserFunction" in key and key[0] != "V"):
        raise UnknownItemError(f"{name}, which has a user function")
