"""Arguments that the public functions have in common: the system, its items, settings."""

from collections.abc import Mapping
from numbers import Integral
from typing import Any

import exudyn

from ..errors import InputError
from ..run.settings import ExplicitSettings


def simulation_settings(given: Any) -> Any:
    """The given exudyn.SimulationSettings, or those by default for None."""
    return settings_of(exudyn.SimulationSettings, "simulationSettings", given)


def explicit_settings(given: Any) -> ExplicitSettings:
    """The given ExplicitSettings, or those by default for None."""
    return settings_of(ExplicitSettings, "explicitSettings", given)


def settings_of(kind: Any, name: str, given: Any) -> Any:
    """The given object of that class, or the one by default for None.

    Raises:
        InputError: something else.   name: of the argument, for the message.
    """
    if given is None:
        return kind()
    if not isinstance(given, kind):
        raise InputError(f"{name} = {given!r}: must be {kind.__name__}(), an object, or None.")
    return given


_INSTEAD = {
    "solverType": "ExplicitSettings(integrator=...) chooses the integrator",
    "updateInitialValues": "leave it out, as the equilibrium becomes the initial state",
    "storeSolver": "leave it out",
} | dict.fromkeys(("showHints", "showCausingItems"), "leave it out, as errors name cause and remedy")


def refuse_others(function: str, others: Mapping[str, Any]) -> None:
    """Raise InputError for arguments that a function does not have, with what native ones become here."""
    for name, value in others.items():
        instead = _INSTEAD.get(name, f"help({function}) lists those that there are")
        raise InputError(f"{name} = {value!r}: {function} has no such argument; {instead}.")


LARGEST_INDEX = 2**31 - 1  # of Exudyn


def require_system(mbs: Any) -> None:
    """Raise InputError unless mbs is a system of Exudyn."""
    if not isinstance(mbs, exudyn.MainSystem):
        raise InputError(f"mbs = {mbs!r}: must be a system of Exudyn, from SystemContainer().AddSystem().")


def object_number(given: Any) -> int:
    """The number of an object, given as an integer or Exudyn's index; -1 if it is no number of an object."""
    return _item_number(given, exudyn.exudynCPP.ObjectIndex)


def node_number(given: Any) -> int:
    """The number of a node, given as an integer or Exudyn's index; -1 if it is no number of a node."""
    return _item_number(given, exudyn.exudynCPP.NodeIndex)


def sensor_number(given: Any) -> int:
    """The number of a sensor, given as an integer or Exudyn's index; -1 if it is no number of a sensor."""
    return _item_number(given, exudyn.exudynCPP.SensorIndex)


def _item_number(given: Any, index_type: Any) -> int:
    is_integer = isinstance(given, Integral) and not isinstance(given, bool)
    if not (is_integer or isinstance(given, index_type)):
        return -1
    return max(-1, min(int(given), LARGEST_INDEX))


def described(data: dict[str, Any], number: int) -> str:
    """An object in messages.   data: of the object."""
    return f"object {number} '{data['name']}' ({data['objectType']})"
