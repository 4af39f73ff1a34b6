"""`projection`: the plugin's solver alone; native solvers are told so."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...errors import EnforcementError
from ...scene.model import CableItem
from .protocol import Enforcement


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
        "the cable with enforcement='algebraic' for native implicit solvers, eigenvalues and degrees of "
        "freedom, with enforcement='penaltyMass' for native explicit solvers."
    )
