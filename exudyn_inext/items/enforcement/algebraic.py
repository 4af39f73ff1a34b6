"""`algebraic`: exact native constraint objects, for generalized-alpha and other implicit solvers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from exudyn.itemInterface import (
    CoordinateVectorConstraint,
    MarkerNodeCoordinates,
    MarkerObjectODE2Coordinates,
    NodePointGround,
)

from ...arrays import Array
from ...cable.assembly import add_elastic_force
from ...cable.cable import Cable, CurvatureMeasure
from ...cable.chain import Chain, build_chain
from ...cable.constraint_rows import (
    ConstraintRows,
    build_rows,
    constraint_jacobian,
    constraint_values,
    unconstrained_force,
)
from ...cable.sparse_forms import damping_tangent, elastic_tangent, form_of_cable
from ...element.inertia import mass_matrix
from ...errors import RedundantConstraintError
from ...loads.gravity import gravity_force
from ...scene.model import CableItem
from ..on_ground import node_marker_to_ground
from .coordinates import Coordinates
from .protocol import Enforcement
from .start_of_run import StartOfRun, refuse_weights

PIVOT_TOLERANCE = 1e-12  # smallest eigenvalue of rows of length 1 that do not depend on each other
REASON = (
    "depend on each other (a straight cable between supports as far apart as it is long, or an element "
    "clamped at both ends), which native solvers cannot take: let the cable sag (shape), or free a support."
)
_HOLDS_POSITIONS = ("JointSpherical", "JointRevolute2D")


def are_independent(cable: Cable, rows: ConstraintRows, held: np.ndarray) -> bool:
    """Whether J J^T of the rows is regular for the coordinates that are free.   held: (n, 2, dim)."""
    gradients = np.zeros((rows.number, *cable.reference.shape))
    constraint_jacobian(rows, cable.reference, gradients)
    coordinates = Coordinates(cable)
    jacobian = coordinates.vector(gradients)[:, ~coordinates.vector(held.astype(float)).astype(bool)]
    lengths = np.linalg.norm(jacobian, axis=1, keepdims=True)
    if not lengths.all():
        return False
    scaled = jacobian / lengths
    return bool(np.linalg.eigvalsh(scaled @ scaled.T)[0] > PIVOT_TOLERANCE)


def refuse_redundant_supports(item: CableItem, rows: ConstraintRows) -> Callable[[Any], None]:
    """A check that raises RedundantConstraintError if native constraints to ground depend on the rows."""

    def check(mbs: Any) -> None:
        held, names = np.zeros(item.cable.reference.shape, bool), []
        for number in range(mbs.systemData.NumberOfObjects()):
            data = mbs.GetObject(number)
            if grounded := _grounded_coordinates(mbs, data, item):
                node, coordinates = grounded
                held[node].flat[coordinates] = True
                names.append(f"object {number} '{data['name']}'")
        if not are_independent(item.cable, rows, held):
            raise RedundantConstraintError(
                "enforcement = 'algebraic': the length constraints of the cable and "
                f"{', '.join(names)} {REASON}"
            )

    return check


def _grounded_coordinates(mbs: Any, data: dict[str, Any], item: CableItem) -> tuple[int, list[int]] | None:
    """Place of a node of the cable and its coordinates that an object holds to the ground, or None."""
    kind = data["objectType"]
    tied = node_marker_to_ground(mbs, data) if kind in ("ConnectorCoordinate", *_HOLDS_POSITIONS) else None
    if tied is None or int(tied[0]["nodeNumber"]) not in item.nodes:
        return None
    place = item.nodes.index(int(tied[0]["nodeNumber"]))
    if kind not in _HOLDS_POSITIONS:
        return place, [tied[0]["coordinate"]]
    axes = data.get("constrainedAxes", [1, 1, 1])[: item.cable.dimension]
    return place, [axis for axis, is_held in enumerate(axes) if is_held]


@dataclass(frozen=True)
class Algebraic(Enforcement):
    """Constraints (18), (19) as a CoordinateVectorConstraint, with multipliers of Exudyn.

    Forces that are linear in the coordinates are constant matrices of the object; `product` and bending
    damping take user functions of force and Jacobian (which leaves out how damping changes with the shape),
    for which modified Newton pays. Long runs need numerical damping, as
    in generalizedAlpha.spectralRadius = 0.8; with 1 the pendulum's steps became ever smaller.
    """

    name: ClassVar[str] = "algebraic"

    def require_independent(self, item: CableItem, held: np.ndarray) -> None:
        """J J^T of all rows with the coordinates that are free is regular; see `Enforcement`.

        Raises:
            RedundantConstraintError: it is not.
        """
        if not are_independent(item.cable, build_rows(item.cable, held), held):
            raise RedundantConstraintError(
                "enforcement = 'algebraic': the length constraints of the cable and groundConstraintsStart "
                f"and groundConstraintsEnd {REASON}"
            )

    def object_parameters(self, item: CableItem) -> dict[str, Any]:
        cable = item.cable
        coordinates, chain = Coordinates(cable), build_chain(cable)
        external = gravity_force(cable, item.gravity)
        mass = cable.section.mass_per_length * form_of_cable(cable, mass_matrix)
        is_linear = cable.measure is CurvatureMeasure.SECOND_DERIVATIVE and not cable.section.bending_damping
        forces = _linear_forces if is_linear else _forces_of_user_functions
        return {"massMatrix": coordinates.sparse_matrix(mass), **forces(cable, chain, external)}

    def add_constraints(self, mbs: Any, number: int, item: CableItem, held: np.ndarray) -> list[int]:
        """One constraint object with all rows; those of clamped nodes, redundant there, are left out."""
        rows = build_rows(item.cable, held)
        ground = mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=mbs.AddNode(NodePointGround())))
        marker = mbs.AddMarker(MarkerObjectODE2Coordinates(objectNumber=number))
        values, jacobian = _constraint_user_functions(rows, item)
        constraint = CoordinateVectorConstraint(
            name=f"inextensibility of object {number}",
            markerNumbers=[ground, marker],
            scalingMarker0=np.zeros((rows.number, 1)),
            constraintUserFunction=values,
            jacobianUserFunction=jacobian,
        )
        return [mbs.AddObject(constraint)]


def _linear_forces(cable: Cable, chain: Chain, external: Array) -> dict[str, Any]:
    """K and the force in the reference configuration: objects know displacements only."""
    coordinates, force = Coordinates(cable), external.copy()
    add_elastic_force(chain, cable.reference, force)
    stiffness = elastic_tangent(chain, cable.reference)
    nothing = coordinates.sparse_matrix(0.0 * stiffness)

    def no_more_than_stiffness_user_function(mbs, t, itemNumber, q, q_t, fODE2, fODE2_t):
        return nothing  # without it, Exudyn would find the constant matrix by differences

    return {
        "stiffnessMatrix": coordinates.sparse_matrix(stiffness),
        "forceVector": coordinates.vector(force),
        "jacobianUserFunction": no_more_than_stiffness_user_function,
    }


def _forces_of_user_functions(cable: Cable, chain: Chain, external: Array) -> dict[str, Any]:
    coordinates = Coordinates(cable)
    force = np.zeros(coordinates.shape)

    def cable_force_user_function(mbs, t, itemNumber, q, q_t):
        unconstrained_force(chain, external, coordinates.total(q), coordinates.nodal(q_t), force)
        return coordinates.vector(force)

    def cable_jacobian_user_function(mbs, t, itemNumber, q, q_t, fODE2, fODE2_t):
        at = coordinates.total(q)
        tangent = fODE2 * elastic_tangent(chain, at)
        if cable.section.bending_damping:
            tangent += fODE2_t * damping_tangent(chain, at)
        return coordinates.sparse_matrix(tangent)

    return {
        "forceUserFunction": cable_force_user_function,
        "jacobianUserFunction": cable_jacobian_user_function,
    }


def _constraint_user_functions(rows: ConstraintRows, item: CableItem) -> tuple[Any, Any]:
    """User functions of constraint and Jacobian; they get coordinates with reference values."""
    coordinates = Coordinates(item.cable)
    checks = StartOfRun(refuse_weights(item), refuse_redundant_supports(item, rows))
    values = np.zeros((2, rows.number))
    gradients = np.zeros((rows.number, *coordinates.shape))

    def inextensibility_user_function(mbs, t, itemNumber, q, q_t, velocityLevel):
        checks.look(mbs, t)
        constraint_values(rows, coordinates.nodal(q), coordinates.nodal(q_t), values)
        return values[int(velocityLevel)]

    def inextensibility_jacobian_user_function(mbs, t, itemNumber, q, q_t, velocityLevel):
        checks.look(mbs, t)  # the first one that a solver calls
        constraint_jacobian(rows, coordinates.nodal(q), gradients)
        return coordinates.vector(gradients)

    inextensibility_user_function.enforces_inextensibility = True  # type: ignore[attr-defined]
    return inextensibility_user_function, inextensibility_jacobian_user_function
