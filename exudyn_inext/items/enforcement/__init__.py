"""How native solvers enforce inextensibility: one way a file, found by itself.

A module of this folder that defines a class `ENFORCEMENT` (see `protocol.Enforcement`) adds a way, under
the class's `name`. SolveExplicit moves a cable by index reduction whatever its way.
"""

import importlib
import pkgutil
from typing import Any

from ...errors import InputError
from .protocol import Enforcement

ENFORCEMENTS: dict[str, type[Enforcement]] = {
    module.ENFORCEMENT.name: module.ENFORCEMENT
    for module in (
        importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__)
    )
    if hasattr(module, "ENFORCEMENT")
}


def find_enforcement(given: Any) -> Enforcement:
    """The way of that name with its default parameters, or the given one itself.

    Raises:
        InputError: no such way.
    """
    if type(given) in ENFORCEMENTS.values():
        way: Enforcement = given
        return way
    if isinstance(given, str) and given in ENFORCEMENTS:
        return ENFORCEMENTS[given]()
    raise InputError(
        f"enforcement = {given!r} is unknown: choose one of {sorted(ENFORCEMENTS)}, or give parameters, "
        "as in PenaltyMass(penalty=1e4)."
    )
