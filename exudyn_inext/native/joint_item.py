"""A native constraint of an mbs as a joint, which Exudyn evaluates."""

from dataclasses import dataclass, field
from typing import Any

import exudyn
import numpy as np
from exudyn.exudynCPP import ObjectIndex

from ..arrays import Array

JACOBIAN = exudyn.ComputeItemType.ConstraintJacobian


@dataclass(frozen=True, eq=False)
class JointItem:
    """An object with algebraic equations.

    number: of the object.   rows: (k,) places of its active equations among all algebraic equations.
    active: (k,) which of its own equations these are.
    coordinates: (n,) places in the system vector, each of them once.
    columns: (N, n) sums Exudyn's columns of its Jacobian, where both markers have some of them; or None.
    name: for messages.   follows_time: whether user functions take part.
    is_linear: whether its Jacobian never changes.   period: modulo which its value counts, or infinite.
    is_angular: whether its Jacobian is of angular velocities, of which its value, of angles, is no integral.
    is_rolling: whether it is J v = 0 alone, and nothing of places, as of a rolling disc.
    scale: length [m] within which it bends, as a rod's, or infinite.
    """

    number: int
    rows: np.ndarray
    active: np.ndarray
    coordinates: np.ndarray
    name: str
    follows_time: bool
    is_linear: bool
    period: float = field(default=np.inf, kw_only=True)
    is_angular: bool = field(default=False, kw_only=True)
    is_rolling: bool = field(default=False, kw_only=True)
    columns: Array | None = field(default=None, kw_only=True)
    scale: float = field(default=np.inf, kw_only=True)

    def jacobian(self, mbs: Any) -> Array:
        """(k, n) with respect to `coordinates`, in the current configuration."""
        jacobian = np.asarray(mbs.ComputeItem(ObjectIndex(self.number), JACOBIAN))[self.active]
        return jacobian if self.columns is None else np.asarray(jacobian @ self.columns)
