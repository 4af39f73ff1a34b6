"""Supports that depend on the length constraints, which native implicit solvers cannot take."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...cable.cable import Cable
from ...cable.constraint_rows import ConstraintRows, constraint_jacobian
from ...errors import RedundantConstraintError
from ...scene.model import CableItem
from ..on_ground import node_marker_to_ground
from .coordinates import Coordinates

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
