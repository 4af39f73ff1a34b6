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
        refuse = _refuse_to_stretch if item.cable.stretches else _refuse
        return {"forceUserFunction": refuse, "massMatrixUserFunction": refuse}


_OURS = (
    "use exudyn_inext.SolveExplicit(mbs, simulationSettings), SolveEquilibrium(mbs) for statics, "
    "ComputeEigenvalues(mbs) for eigenvalues, or"
)


def _refuse(mbs, t, itemNumber, q, q_t):
    raise EnforcementError(
        f"the inextensible cable of object {itemNumber} has enforcement = 'projection', but was evaluated by "
        "a native solver, which does not enforce inextensibility (the cable would fall apart): "
        f"{_OURS} create the cable with enforcement='algebraic' for native implicit solvers and degrees of "
        "freedom, with enforcement='penaltyMass' for native explicit solvers."
    )


def _refuse_to_stretch(mbs, t, itemNumber, q, q_t):
    raise EnforcementError(
        f"the cable of object {itemNumber}, which stretches, was evaluated by a native solver, which knows "
        f"nothing of its forces: {_OURS} take GenerateBeamElementsAlongLine with an ObjectANCFCable2D or "
        "ObjectANCFCable for native solvers and degrees of freedom."
    )
