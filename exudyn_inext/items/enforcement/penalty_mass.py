"""`penaltyMass`: constraints as very heavy springs, dampers and masses, for native explicit solvers."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array
from ...cable.cable import Cable
from ...cable.constraint_rows import build_rows, constraint_jacobian, constraint_values
from ...cable.index_reduction import force_in_motion
from ...cable.sparse_forms import form_of_cable
from ...checks import as_number, require_positive
from ...element.inertia import mass_matrix
from ...errors import InputError
from ...loads.gravity import gravity_force
from ...scene.model import CableItem
from .coordinates import Coordinates
from .protocol import Enforcement
from .start_of_run import StartOfRun, refuse_weights, warn_of_traps

LIMITS = 1e2, 1e6  # of the penalty: constraints too soft; mass matrix too badly conditioned


class PenalisedCable:
    """(M + k C_q^T C_q) a = F + k C_q^T (gamma - 2 z C' - z^2 C) of a cable, supports included.

    A penalty on a length or position [m] is `penalty` times the element's mass, one on a slope [-] that times
    l^2.

    Args:
        cable: without supports and links.   held: (n, 2, dim) what the ground holds at its reference value.
        penalty: k over the mass of an element [-].   z: rate at which violations decay [1/s].

    weights: (m,) k of the constraints, see `ConstraintRows` [kg m^2, kg].
    held: (n, 2, dim) k of held coordinates [kg, kg m^2], 0 where free.
    """

    def __init__(self, cable: Cable, held: np.ndarray, penalty: float, z: float) -> None:
        self._rows, self._reference, self._z = build_rows(cable, held), cable.reference, z
        masses = penalty * cable.section.mass_per_length * cable.element_lengths
        of_nodes = [_at_nodes(of, cable.closed) for of in (masses, masses * cable.element_lengths**2)]
        self.held = np.where(held, np.stack(of_nodes, axis=1)[:, :, np.newaxis], 0.0)
        self.held[-1] *= not cable.closed  # the last node is the first one once more
        group = cable.group_of_element()
        group = group[group >= 0]
        of_groups = np.bincount(group, masses[: len(group)]) / np.bincount(group)
        self.weights = np.append(of_nodes[1][self._rows.nodal], of_groups)
        mass = cable.section.mass_per_length * form_of_cable(cable, mass_matrix).toarray()
        self._mass: Array = mass + np.diag(self.held.ravel())
        self._values = np.zeros((3, len(self.weights)))
        self._gradients = np.zeros((len(self.weights), *cable.reference.shape))
        self._jacobian = self._gradients.reshape(-1, cable.reference.size)

    def _jacobian_at(self, q: Array) -> Array:
        """(m, n_dof) C_q, in memory."""
        constraint_jacobian(self._rows, q, self._gradients)
        return self._jacobian

    def force(self, external: Array, q: Array, v: Array) -> Array:
        """(n, 2, dim) right-hand side at (q, v) [N, Nm].   external, q, v: (n, 2, dim)."""
        force, z = np.zeros(q.shape), self._z
        force_in_motion(self._rows.chain, external, q, v, force)
        constraint_values(self._rows, q, v, self._values)
        value, rate, gamma = self._values
        demand = self.weights * (gamma - z * (2.0 * rate + z * value))
        force += (demand @ self._jacobian_at(q)).reshape(q.shape)
        return force - self.held * (z * (2.0 * v + z * (q - self._reference)))

    def mass(self, q: Array) -> Array:
        """(n_dof, n_dof) M + k C_q^T C_q at q (n, 2, dim) [kg, kg m, kg m^2]."""
        jacobian = self._jacobian_at(q)
        return self._mass + (jacobian.T * self.weights) @ jacobian


def _at_nodes(of_elements: Array, closed: bool) -> Array:
    """(n,) mean of the neighbouring elements."""
    first, last = (of_elements[-1], of_elements[0]) if closed else (of_elements[0], of_elements[-1])
    mean: Array = 0.5 * (np.append(first, of_elements) + np.append(of_elements, last))
    return mean


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
        system = PenalisedCable(cable, item.held, float(self.penalty), float(self.stabilizationRate))
        external = gravity_force(cable, item.gravity)
        checks = StartOfRun(warn_of_traps, refuse_weights(item))

        def penalty_force_user_function(mbs, t, itemNumber, q, q_t):
            checks.look(mbs, t)
            return coordinates.vector(system.force(external, coordinates.total(q), coordinates.nodal(q_t)))

        def penalty_mass_user_function(mbs, t, itemNumber, q, q_t):
            return coordinates.matrix(system.mass(coordinates.total(q)))

        return {
            "forceUserFunction": penalty_force_user_function,
            "massMatrixUserFunction": penalty_mass_user_function,
        }
