"""Why a scene stays with Exudyn."""

from typing import Any


class UnknownItemError(Exception):
    """An item has no compiled form; the message names it."""


def functions_of(data: dict[str, Any]) -> set[str]:
    """Names of the parameters of an item that are user functions, but for those of its graphics."""
    named = {key: value for key, value in data.items() if "UserFunction" in key and key[0] != "V"}
    return {key for key, value in named.items() if isinstance(value, dict)}


def require_no_functions(data: dict[str, Any], name: str) -> None:
    """Raise UnknownItemError if an item has a user function."""
    if functions_of(data):
        raise UnknownItemError(f"{name}, which has a user function")
