"""What a way of enforcement offers; and `projection`: the plugin's solver alone, as native ones are told."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...errors import EnforcementError
from ...scene.model import CableItem


class Enforcement:
    """How the object of a cable, and constraints beside it, enforce inextensibility in native solvers.

    name: what the user writes.
    supports_are_objects: whether the supports at the ends are native CoordinateConstraints.
    """

    name: ClassVar[str]
    supports_are_objects: ClassVar[bool] = True

    def require_independent(self, item: CableItem, held: np.ndarray) -> None:
        """RedundantConstraintError if native solvers would meet constraints that depend on each other.

        held: (n, 2, dim) coordinates that supports at the ends hold.
        """

    def object_parameters(self, item: CableItem) -> dict[str, Any]:
        """Matrices and user functions of the ObjectGenericODE2."""
        raise NotImplementedError

    def add_constraints(self, mbs: Any, number: int, item: CableItem, held: np.ndarray) -> list[int]:
        """Add what belongs beside object `number`; returns the numbers of the added objects.

        held: (n, 2, dim) coordinates that supports at the ends hold.
        """
        return []


@dataclass(frozen=True)
class Projection(Enforcement):
    """Index reduction in SolveExplicit; any native solver stops with an error."""

    name: ClassVar[str] = "projection"

    def object_parameters(self, item: CableItem) -> dict[str, Any]:
        return {
            "forceUserFunction": _refusing_user_function,
            "massMatrixUserFunction": _refusing_user_function,
        }


def _refusing_user_function(mbs, t, itemNumber, q, q_t):
    raise EnforcementError(
        f"the inextensible cable of object {itemNumber} has enforcement = 'projection', but was evaluated by "
        "a native solver, which does not enforce inextensibility (the cable would fall apart): use "
        "exudyn_inext.SolveExplicit(mbs, simulationSettings), SolveEquilibrium(mbs) for statics, or create "
        "the cable with enforcement='algebraic' for native implicit solvers, with enforcement='penaltyMass' "
        "for native explicit ones."
    )
