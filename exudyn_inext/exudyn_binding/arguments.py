"""Settings as the public functions take them."""

from typing import Any

import exudyn

from ..errors import InputError
from ..run.settings import ExplicitSettings


def simulation_settings(given: Any) -> Any:
    """The given exudyn.SimulationSettings, or those by default for None."""
    return _settings("simulationSettings", given, exudyn.SimulationSettings)


def explicit_settings(given: Any) -> ExplicitSettings:
    """The given ExplicitSettings, or those by default for None."""
    checked: ExplicitSettings = _settings("explicitSettings", given, ExplicitSettings)
    return checked


def _settings(name: str, given: Any, kind: Any) -> Any:
    if given is None:
        return kind()
    if not isinstance(given, kind):
        raise InputError(f"{name} = {given!r}: must be {kind.__name__}(), an object, or None.")
    return given
