"""Holonomic constraints c(q, t) = 0 of a cable, Eqs. (18)-(20): one kind a file, found by itself.

A module of this folder that defines `of_cable(cable)` adds a kind. The solver enforces them through the
structure of the chain (see `cable.saddle_point`); here they stand on their own, for consistency
checks and as the oracle of the tests.
"""

import importlib
import pkgutil

from ..cable.cable import Cable
from .constraint import Constraint

KINDS = [
    module
    for module in (
        importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__)
    )
    if hasattr(module, "of_cable")
]


def constraints_of_cable(cable: Cable) -> list[Constraint]:
    """All constraints of `cable`, without redundant ones."""
    found = (kind.of_cable(cable) for kind in KINDS)
    return [constraint for constraint in found if constraint.number > 0]
