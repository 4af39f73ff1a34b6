"""What a run gives, and what a study asks for: a trajectory, and a case that can produce one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exudyn_inext.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Positions of one point.   times: (n,) [s]; positions: (n, 3) [m]."""

    times: Array
    positions: Array

    def __post_init__(self) -> None:
        if self.positions.shape != (len(self.times), 3):
            raise InputError(
                f"Trajectory: positions of shape {self.positions.shape} do not fit "
                f"{len(self.times)} times; give an array of shape ({len(self.times)}, 3)."
            )

    @property
    def is_finite(self) -> bool:
        return bool(np.isfinite(self.times).all() and np.isfinite(self.positions).all())


Untimed = Callable[[], Trajectory]
"""Gives the trajectory of a run that is over."""

Run = Callable[[], Trajectory | Untimed]
"""Solves a model that is ready to go; only this call is timed, not what it may return to be called later."""


@dataclass(frozen=True)
class Case:
    """One row of a comparison.

    formulation: "conventional" or "inextensible".   step_size [s].
    prepare: builds a fresh model (not timed) and returns the run (timed).
    details: further settings that the row shall name.
    halved: the same case with half the step, where one may be asked for.
    """

    label: str
    formulation: str
    integrator: str
    elements: int
    step_size: float
    steps: int
    prepare: Callable[[], Run]
    details: Mapping[str, Any] = field(default_factory=dict)
    halved: "Callable[[], Case] | None" = None
