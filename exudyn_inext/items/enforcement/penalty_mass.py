"""`penaltyMass`: constraints as very heavy springs, dampers and masses, for native explicit solvers."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...cable.penalty_mass import build_penalty_system, penalty_force, penalty_mass
from ...checks import as_number, require_positive
from ...errors import InputError
from ...loads.gravity import gravity_force
from ...scene.model import CableItem
from .coordinates import Coordinates
from .protocol import Enforcement
from .start_of_run import StartOfRun, refuse_weights, warn_of_traps

LIMITS = 1e2, 1e6  # of the penalty: constraints too soft; mass matrix too badly conditioned


@dataclass(frozen=True)
class PenaltyMass(Enforcement):
    """Bayo's penalty formulation in the user functions of the cable's object, supports included.

    (M + k C_q^T C_q) a = F + k C_q^T (gamma - 2 z C' - z^2 C) takes the place of M a = F. Loads and
    connectors act on the nodes as usual. For native RK44, DOPRI5, ExplicitMidpoint and VelocityVerlet; DOPRI5
    with tolerances of 1e-5 or more (its step control may stall below). The mass matrix is dense: up to some
    20 elements.

    Source: E. Bayo, J. Garcia de Jalon, M. A. Serna, A modified Lagrangian formulation for the dynamic
    analysis of constrained mechanical systems, CMAME 71 (1988) 183-195.

    Args:
        penalty: k over the mass of an element [-]; 1e4 and 1e5 give nearly the same motion.
        stabilizationRate: z, at which violations of the constraints decay [1/s]; z h must be well below 1.

    Raises:
        InputError: penalty outside of 1e2 to 1e6, or a stabilizationRate that is not positive.

    Example:
        CreateInextensibleCable(mbs, ..., enforcement=PenaltyMass(penalty=1e5))
    """

    penalty: float = 1e4
    stabilizationRate: float = 100.0

    name: ClassVar[str] = "penaltyMass"
    supports_are_objects: ClassVar[bool] = False

    def __post_init__(self) -> None:
        low, high = LIMITS
        if not low <= as_number(self.penalty) <= high:
            raise InputError(
                f"penalty = {self.penalty!r}: must be a number from {low:g} (constraints too soft below) to "
                f"{high:g} (mass matrix too badly conditioned above); use 1e4."
            )
        require_positive("stabilizationRate", self.stabilizationRate)

    def object_parameters(self, item: CableItem) -> dict[str, Any]:
        cable, coordinates = item.cable, Coordinates(item.cable)
        system = build_penalty_system(cable, item.held, float(self.penalty), float(self.stabilizationRate))
        external = gravity_force(cable, item.gravity)
        force, mass = np.zeros(coordinates.shape), np.zeros(coordinates.shape * 2)
        checks = StartOfRun(warn_of_traps, refuse_weights(item))

        def penalty_force_user_function(mbs, t, itemNumber, q, q_t):
            checks.look(mbs, t)
            penalty_force(system, external, coordinates.total(q), coordinates.nodal(q_t), force)
            return coordinates.vector(force)

        def penalty_mass_user_function(mbs, t, itemNumber, q, q_t):
            penalty_mass(system, coordinates.total(q), mass)
            return coordinates.matrix(mass)

        return {
            "forceUserFunction": penalty_force_user_function,
            "massMatrixUserFunction": penalty_mass_user_function,
        }
