"""What a way of enforcement offers."""

from typing import Any, ClassVar

import numpy as np

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
