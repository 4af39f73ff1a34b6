"""How native solvers enforce inextensibility; SolveExplicit reduces the index, whatever the way."""

from typing import Any

from ...errors import InputError
from .algebraic import Algebraic
from .penalty_mass import PenaltyMass
from .projection import Projection
from .protocol import Enforcement

ENFORCEMENTS: dict[str, type[Enforcement]] = {way.name: way for way in (Algebraic, PenaltyMass, Projection)}


def find_enforcement(given: Any) -> Enforcement:
    """The way of that name with its default parameters, or the given one itself.

    Raises:
        InputError: no such way.
    """
    if type(given) in ENFORCEMENTS.values():
        return given
    if isinstance(given, str) and given in ENFORCEMENTS:
        return ENFORCEMENTS[given]()
    raise InputError(
        f"enforcement = {given!r} is unknown: choose one of {sorted(ENFORCEMENTS)}, or give parameters, "
        "as in PenaltyMass(penalty=1e4)."
    )
