"""Explicit time integrators: one scheme a file, found by itself.

A module of this folder that defines `INTEGRATOR` adds a scheme; nothing else has to be changed.
"""

import importlib
import pkgutil

from ..errors import InputError
from .integrator import Integrator

INTEGRATORS: dict[str, Integrator] = {
    module.INTEGRATOR.name: module.INTEGRATOR
    for module in (
        importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__)
    )
    if hasattr(module, "INTEGRATOR")
}


def find_integrator(name: str) -> Integrator:
    """The integrator called `name`; InputError lists the known ones."""
    if not isinstance(name, str) or name not in INTEGRATORS:
        raise InputError(f"integrator = {name!r} is unknown: choose one of {sorted(INTEGRATORS)}.")
    return INTEGRATORS[name]
