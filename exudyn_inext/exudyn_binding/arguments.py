"""Settings as the public functions take them."""

from typing import Any

import exudyn

from ..errors import InputError
from ..run.settings import ExplicitSettings


def simulation_settings(given: Any) -> Any:
    """The given exudyn.SimulationSettings, or those by default for None."""
    return settings_of(exudyn.SimulationSettings, "simulationSettings", given)


def explicit_settings(given: Any) -> ExplicitSettings:
    """The given ExplicitSettings, or those by default for None."""
    checked: ExplicitSettings = settings_of(ExplicitSettings, "explicitSettings", given)
    return checked


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
